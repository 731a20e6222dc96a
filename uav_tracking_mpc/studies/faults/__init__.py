"""Faults injected into flying nodes from a seeded schedule, and what must hold all the while.

===================  ============================================================================
``fault_kinds``      every kind of fault: whom it strikes and for how long
``schedule``         which faults come when, from a seed
``corruption``       what is done to the fields of a message
``message_faults``   what is done to a stream: lost, late, twice, out of order, corrupted
``fault_relay``      the node in the middle of every topic, which does it
``crew``             the node processes: started, stopped, killed, started again
``parameter_storm``  set_parameters, with values sane and absurd
``invariants``       what must hold for every message
``recovery``         when the aircraft is back on its orbit
``resources``        memory, files and threads of the processes
``observer``         the node that hears everything and judges
``case_bag``         the messages of a case that failed
``strokes``            how a fault of each action is done and undone
``findings``         what came of every case, and in total
``timeline``         the campaign in one figure
``campaign``         cases one after the other
-------------------  ----------------------------------------------------------------------------
``mutations``        one field of a message, anywhere in it, gone wrong
``mangling``         a stream of messages from a sender gone wrong
``fingerprint``      a digest of what an object holds
``bench``            a real node whose callbacks are called by hand
``message_fuzz``     messages by the hundred thousand into controller and vehicle
-------------------  ----------------------------------------------------------------------------
``soak``             hours of flight without faults: is the orbit held, does anything grow
``command``          ``uav_tracking torture``
===================  ============================================================================

Schedule, corruption, mutations, mangling, fingerprint, message faults, invariants, recovery,
resources, findings and timeline know nothing of ROS.
"""
