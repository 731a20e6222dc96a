"""What holds for the problem with the artificial orbit, and flights that show it.

====================  ================================================================
``guarantee``         what is guaranteed, why, and what is not: in words
``random_flights``    random states that an aircraft can be in
``campaign``          closed loops from all of them: feasible, converged, does the cost fall?
``command``           ``uav_tracking stability`` for such a configuration
====================  ================================================================
"""
