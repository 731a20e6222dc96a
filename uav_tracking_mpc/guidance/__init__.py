"""State in, command out.

=======================  =============================================================
``tracking_parameters``  orbit, model, horizon, weights, limits
``tracking_problem``     these put together as an optimal control problem
``controller``           the control law, and what flies when a solve fails
``certification``        certified, sampled or neither: what may be claimed of the terminal set
``situation``            aircraft, target and drift, as a guidance law sees them
``vector_field``         classical law: Lyapunov loiter vector field
``l1_loiter``            classical law: L1 capture and circle tracking, as ArduPilot's
``altitude_hold``        height and airspeed loops of the classical laws
``pace``                 which states are answered with a command
``target_filter``        the target from measured positions: wrong, late and missing ones
``singer_track``         its Kalman filter: position, velocity, acceleration
``turn_prediction``      where the target will be if it goes on turning
=======================  =============================================================
"""
