"""Faults injected into flying nodes from a seeded schedule, and what must hold all the while.

====================  =========================================================================
``kinds``             the faults, one idea a file, and their base
``stream_fault``      bases of faults that strike messages
``message_fields``    fields of the messages that faults change
``catalogue``         every fault by its label
``schedule``          which faults come when, from a seed
``injection``         one fault under way
``injected_flight``   the flight that faults act on
``streams``           the topics that faults strike, on both sides of the relay
``fault_relay``       the node in the middle of every topic, which strikes the messages
``parameter_client``  set_parameters, from a process of its own
``invariants``        what must hold for every message
``recovery``          when the aircraft is back on its orbit
``resources``         memory, files and threads of the processes
``observer``          the node that hears every message and checks the invariants
``case_bag``          the messages of a case that failed
``fault_findings``    what came of every case, and in total
``timeline``          the campaign in one figure
``fault_campaign``    cases one after the other
--------------------  -------------------------------------------------------------------------
``soak``              hours of flight without faults: is the orbit held, does anything grow
====================  =========================================================================

Schedule, invariants, recovery, resources, findings and timeline know nothing of ROS.
"""
