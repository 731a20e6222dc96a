"""What holds for the problem with the artificial orbit, and flights that show it.

========================  ==============================================================
``guarantee``             what is guaranteed, why, and what is not: in words
``random_flights``        random states that an aircraft can be in
``feasibility_campaign``  closed loops from all of them: feasible, converged, falling cost
``feasibility_study``     the two together
========================  ==============================================================
"""
