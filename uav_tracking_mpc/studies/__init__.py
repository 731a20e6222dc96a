"""What studies the controller; nothing that flies imports it.

================  ==============================================================================
``comparison``    the predictive controller beside other laws, through the same scenarios
``stability``     the paper's stability analysis, recomputed and proved
``feasibility``   what is guaranteed with an artificial orbit, and flights that show it
``benchmark``     solve times beside other solvers
``faults``        faults injected into real nodes
``parallel``      work in processes, with a progress bar
================  ==============================================================================
"""
