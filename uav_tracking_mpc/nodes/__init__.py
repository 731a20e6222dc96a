"""ROS 2 nodes: parameters and messages in, one call, messages out.

=======================  =============================================================
``uav_simulator``        the vehicle and its autopilot
``target_publisher``     where the target is
``autopilot_link``       a real aircraft in the simulator's place
``clock_offset``         ROS time by the clock of a link
``link_reader``          the thread that reads a vehicle link
``sighting_publisher``   what a vehicle to circle says of itself, as the target
``px4_ros_link``         PX4 over its own ROS 2 interface, as a link
``px4_topics``           its topics
``px4_messages``         its messages to measurements, inputs to its set-points
``nmpc_controller``      messages to the controller, its commands to the vehicle
``controller_report``    what it has done, as numbers for /diagnostics
``air_values``           what is known of the air, as values of diagnostics
``response_values``      how the aircraft answers commands, as values of these
``controller_views``     what it shows to people: tracking errors, path, markers
``view_messages``        the messages of path and markers
``orbit_message``        the orbit that is flown, and back
``command_wire``         a command as bytes, rewritten in place
``stall_guard``          whether the process has been standing still
``monitor``              a live table in the terminal
``flight_recorder``      every topic of a flight
``flight_bag``           an MCAP bag: written, and read back as a flight log
``flown_target``         where the target of a recorded flight was
``peers``                whether anybody is at the other end, and what rate is promised
``topics``               names, types and qualities of service
``conversions``          messages to arrays and back, the only module that knows both
``target_odometry``      what a tracker says of the target
``declared_parameters``  parameter dataclasses as ROS parameters
``diagnostics``          /diagnostics
``sample_window``        median, percentile, maximum and histogram of durations
``reference_tables``     the tables of the README, written from the code
``run``                  start, spin, stop, exit codes
=======================  =============================================================
"""
