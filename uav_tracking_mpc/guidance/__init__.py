"""State in, command out.

=======================  =============================================================
``tracking_parameters``  orbit, model, horizon, weights, limits
``tracking_problem``     these put together as an optimal control problem
``controller``           the control law, and what flies when a solve fails
``certification``        certified, sampled or neither: what may be claimed of the terminal set
``situation``             aircraft, target and drift, as a guidance law sees them
``pace``                 which states are answered with a command
``target_filter``        position and velocity of the target from its measured positions
=======================  =============================================================
"""
