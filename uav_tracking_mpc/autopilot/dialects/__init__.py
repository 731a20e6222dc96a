"""Autopilots that can be simulated, one a file.

=============  ==================================================================
``ardupilot``  ArduPlane: GUIDED, with altitude and airspeed held by itself
``px4``        PX4 fixed wing: OFFBOARD, by attitude and thrust
=============  ==================================================================
"""
