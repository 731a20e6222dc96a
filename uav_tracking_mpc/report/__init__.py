"""What a flight looks like afterwards: its numbers, its figures, and one page that tells both.

====================  ================================================================
``metrics``           the numbers of ``metrics.json``
``flight_findings``   what the numbers say in sentences: the verdict, the range offset
``trajectory``        the flight in space, as Figure 2 of the paper
``time_marks``        labelled dots along a path
``states``            states, inputs and cost over time, as Figure 3
``animation``         the flight as a moving picture
``mission_report``    ``write_report``: all of it into one folder
``figure_style``      colours, type and resolution that all figures share
``table``             tables for the terminal and for pages
``html_page``         pages that need no other file
``atomic_write``      files that are whole or absent
====================  ================================================================

Everything starts from a :class:`uav_tracking_mpc.simulation.flight_log.FlightLog`::

    from uav_tracking_mpc.report.mission_report import write_report

    numbers = write_report(log, Path("output"))
"""
