"""Closed loop without ROS: a plant and the controller, deterministic.

========================  ============================================================
``configuration``         one YAML for all nodes, checked
``simulator_parameters``  the simulated aircraft and its air, as parameters
``plant``                 the vehicle in moving air, behind an autopilot that flies plans
``inner_loop``            dead time and lag between a command and the rate flown
``lagged_flight``         the vehicle while its rates approach their commands
``wind``                  mean wind and Dryden gusts
``target_motion``         how the target moves
``target_sensor``         how its position is measured: noise, dropouts, delay
``flight_log``            what a flight leaves behind
``closed_loop``           the mission, step by step
========================  ============================================================
"""
