"""The paper's Section 5 as a report: what is wrong in it, what is proved, what flights show.

======================  ==========================================================================
``stability_study``     everything below, for one configuration
``analysis``            Section 5 for one configuration
``analysis_text``       the analysis as JSON and in words
``printed``             what the paper prints
``distance_budget``     what can be flown at all in N steps
``paper_cases``         the paper's problem recomputed in three ways
``paper_report``        the paper beside the truth
``paper_report_text``   this report as a table and as a page
``ellipsoid_campaign``  what was proved, flown
``attraction``          maps of X_N (20)
``design``              rho and weights for the largest certified region
``stability_figures``   pictures
======================  ==========================================================================

Proving needs python-flint (``pip install python-flint``, extra ``proof``); checking a certificate,
the status of a configuration and the online check do not.
"""
