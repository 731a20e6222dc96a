"""What studies the controller; nothing that flies imports it.

==================  ==============================================================================
``comparison``      the predictive controller beside other laws, through the same scenarios
``campaign``        many flights of what is uncertain, and how many of them fail
``margins``         stability margins of the closed loop about the orbit, and weights that keep them
``identification``  lag, dead time, gain and limits of each channel from a recorded flight
``stability``       the paper's stability analysis, recomputed and proved
``feasibility``     what is guaranteed with an artificial orbit, and flights that show it
``benchmark``       solve times beside other solvers
``faults``          faults injected into real nodes
``link_faults``     faults on the wire to an autopilot
``flight_start``    where a closed loop on the prediction begins
``parallel``        work in processes, with a progress bar
==================  ==============================================================================
"""
