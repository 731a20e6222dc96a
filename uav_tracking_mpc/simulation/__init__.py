"""Closed loop without ROS: a plant and the controller, deterministic.

====================  ================================================================
``flight_log``        what a flight leaves behind
``closed_loop``       the mission, step by step
====================  ================================================================
"""
