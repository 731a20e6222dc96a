"""The solver of this package against its peers: same problems, same starts, one interleaved run.

===============  ================================================================================
``cases``        the problems, where they start, the random states of the cold starts
``flight_case``  the problem with drift, envelope and artificial orbit
``measure``      run every solver on a case; times and shares
``command``      ``uav_tracking benchmark``: table, JSON, figure
===============  ================================================================================
"""
