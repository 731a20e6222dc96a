"""Closed loop without ROS: a plant, a target and the controller, deterministic.

===================  ==============================================================
``closed_loop``      a plant and the controller, step by step
``flight_log``       what a flight leaves behind
``plants``           what can be flown, one plant a file
``plan_follower``    the part of an autopilot that flies plans
``flight_dynamics``  six degrees of freedom: JSBSim with an airframe of ours
``flight_control``   its inner loops: bank, path angle, airspeed
``inner_loop``       dead time and lag between a command and the rate flown
``lagged_flight``    the vehicle while its rates approach their commands
``vehicle_sensors``  how the aircraft is measured: noise
``wind``             mean wind and Dryden gusts
``motions``          how the target moves, one motion a file
``target_sensor``    how its position is measured: noise, dropouts, delay
===================  ==============================================================
"""
