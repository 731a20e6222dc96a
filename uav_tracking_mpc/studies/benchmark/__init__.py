"""The solver of this package beside others: same problems, same starts, one interleaved run.

====================  ===========================================================================
``cases``             the problems, where they start, the random states of the cold starts
``solver_timing``     run every solver on a case; times and shares
``benchmark_study``   all cases, a sweep over the horizon, missions a second
``benchmark_report``  table and figure
====================  ===========================================================================
"""
