"""Faults on the wire to an autopilot, and what must hold all the while.

Link and controller fly the simulated autopilot in simulated time, so that hours of faults take
minutes and a case can be seen again. Nothing here needs ROS.

====================  =========================================================================
``link_flight``       controller, link and autopilot, step by step
``sent_messages``     what must hold for every message that is sent to the autopilot
``link_fault_kinds``  the wire's faults, and what pilots and companions do
``bad_frames``        frames that are none, and what a connection makes of them
``link_campaign``     faults one after the other, and what came of each
====================  =========================================================================
"""
