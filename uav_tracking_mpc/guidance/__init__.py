"""State in, command out.

=======================  =============================================================
``tracking_parameters``  orbit, model, horizon, weights, limits
``navigator``            measurements in, situation and forecast out
``state_gate``           which vehicle states are believed
``situation``            aircraft, target and drift, as a guidance law sees them
``forecast``             target and drift over the horizon
``command_history``      commands sent, as the aircraft will still be flying them
``target_filter``        the target from measured positions: wrong, late and missing ones
``singer_track``         its Kalman filter: position, velocity, acceleration
``turn_prediction``      where the target will be if it goes on turning
``pilot``                situation in, command out: always finite, always inside the limits
``ladder``               optimal plan, feasible plan, earlier plan, loiter law, hold, silence
``direction``            which way round, where the nearest is asked for
``formulation``          what a way to pose the tracking problem offers the pilot
``flight_formulation``   the flight problem, fed with parameters, situation and forecast
``flight_problem``       drift, lag, envelope and an artificial orbit as a problem
``paper_formulation``    the paper's problem, fed with a situation
``tracking_problem``     the paper's problem from parameters
``certification``        certified, sampled or neither: what may be claimed of the terminal set
``vector_field``         classical law: Lyapunov loiter vector field, also the fallback
``l1_loiter``            classical law: L1 capture and circle tracking, as ArduPilot's
``altitude_hold``        height and airspeed loops of the classical laws
``pace``                 which states are answered with a command
=======================  =============================================================
"""
