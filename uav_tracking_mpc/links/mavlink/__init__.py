"""What the links to autopilots on MAVLink share.

====================  ==================================================================
``dialect``           pymavlink and its messages
``connection``        bytes to messages and back
``autopilot_clock``   the autopilot's clock by ours
``telemetry``         messages to measurements
====================  ==================================================================
"""
