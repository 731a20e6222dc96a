"""What a flight looks like afterwards: its numbers, its figures, and one page that tells both.

====================  ================================================================
``metrics``           the numbers of ``metrics.json``
``findings``          what the numbers say in sentences: the verdict, the range offset
``figure_style``      colours, type and resolution that all figures share
``time_marks``          labelled dots along a path
``trajectory``        the flight in space, as Figure 2 of the paper
``states``            states, inputs and cost over time, as Figure 3
``figures``           ``save_trajectory`` and ``save_states``
``atomic_write``      files that are whole or absent
``mission_report``    ``write_report``: all of it into one folder
====================  ================================================================

Everything starts from a :class:`uav_tracking_mpc.simulation.flight_log.FlightLog`::

    from uav_tracking_mpc.report.mission_report import write_report

    numbers = write_report(log, Path("output"))
"""
