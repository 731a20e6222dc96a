"""The tracking problem, posed in two ways, over a prediction model and limits.

======================  ==============================================================
``formulation``         what a way to pose the problem offers the controller
``flight_formulation``  the flight problem, fed with parameters, situation and forecast
``flight_problem``      drift, lag, limits and an artificial orbit as a problem
``input_span``          what each input can be in a motion, by all limits together
``layout``              named parts of the problem's parameter vector
``paper_formulation``   the paper's problem, fed with a situation
``paper_problem``       (14)-(16), for a configuration of the analysis and for parameters
======================  ==============================================================
"""
