"""The ``uav_tracking`` command: one file a command, and what the commands share.

===================  =============================================================================
``main``             entry point: chooses the command
``fly``              a mission with real ROS 2 nodes
``link``             what a real autopilot says before a flight
``simulate``         the same mission without ROS
``compare``          the predictive controller beside classical laws
``campaign``         random flights, and how many of them fail
``stability``        the stability analysis, its proof and its certificate
``margins``          stability margins about the orbit, and a search for weights
``benchmark``        solve times beside other solvers
``identify``         lag, dead time and gain from a recorded flight
``torture``          faults injected into real nodes
``monitor``          a live table of a flight
``autopilot``        a simulated ArduPlane or PX4 behind MAVLink
``launch_tracking``  entry point of the executable that only starts the nodes
``arguments``        options that several commands have
``link_arguments``   options that say which autopilot flies, and what was found there
``answer``           how a command prints what it found: JSON or words
``ending``           how a command that failed reports it
===================  =============================================================================

A command's module holds ``HELP`` (one line), ``DESCRIPTION``, ``add_arguments(parser)`` and
``run(arguments)``, which returns the exit code. Whatever takes long to import is imported in
``run``, so that help comes at once.
"""
