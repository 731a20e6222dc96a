"""ROS 2 nodes: parameters and messages in, one call, messages out.

=======================  =============================================================
``uav_simulator``        the vehicle and its autopilot
``target_publisher``     where the target is
``nmpc_controller``      the control law
``monitor``              a live table in the terminal
``flight_recorder``      every topic of a flight into an MCAP bag
``topics``               names, types and qualities of service
``conversions``          messages to arrays and back, the only module that knows both
``declared_parameters``  parameter dataclasses as ROS parameters
``diagnostics``          /diagnostics
``run``                  start, spin, stop, exit codes
=======================  =============================================================
"""
