"""Closed loop without ROS: a plant and the controller, deterministic.

====================  ================================================================
``configuration``     one YAML for all nodes, checked
``plant``             the vehicle behind an autopilot that flies plans
``target_motion``     how the target moves
``flight_log``        what a flight leaves behind
``closed_loop``       the mission, step by step
====================  ================================================================
"""
