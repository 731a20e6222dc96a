"""What studies the controller; nothing that flies imports it.

==================  ==============================================================================
``comparison``      the predictive controller beside other laws, through the same scenarios
``campaign``        Monte-Carlo flights over what is uncertain
``identification``  lag, dead time, gain and limits of an aircraft from a recorded flight
``margins``         stability margins of the closed loop about the orbit, and weights that keep them
``stability``       the paper's stability analysis, recomputed and proved
``feasibility``     what is guaranteed with an artificial orbit, and flights that show it
``benchmark``       solve times beside other solvers
``faults``          faults injected into real nodes
``flight_start``    where a closed loop on the prediction begins
``parallel``        work in processes, with a progress bar
==================  ==============================================================================
"""
