"""What is known of aircraft, air and target.

====================  ==============================================================
``measurement``       what is measured of the aircraft at one time
``state_gate``        which measurements are believed
``air_data``          the airspeed that belongs to a measurement
``noise_meter``       how noisy a signal is, and how much it wanders
``rate_aided_filter`` an angle or a speed, from itself and its rate, whose bias is taken out
``wind_filter``       mean wind, gusts and sensor biases, from positions and velocities
``target_filter``     where the target is and will be, from positions that may be wrong
``singer_track``      the Kalman filter behind it, on Singer's model
``turn_prediction``   where a target will be that goes on turning
``command_history``   commands that were sent, as the aircraft flies them
``navigator``         measurements in, situations and forecast out
``situation``         aircraft, target and the drift between them at one time
``forecast``          target and drift over a horizon
====================  ==============================================================
"""
