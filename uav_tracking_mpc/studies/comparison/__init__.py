"""The predictive controller beside other laws, through the same scenarios.

======================  ==============================================================
``law_names``           which laws there are
``flights``             every law through every scenario, in processes
``mismatches``          what may be other than the controller was told, by name
``measures``            what counts of a flight, from the truth and the limits alone
``targets``             what the predictive controller is to reach, and whether it does
``mismatch_targets``    what it is to hold under a mismatch, and whether it does
``results``             the comparison, and all of it as one object for JSON
``mismatch_results``    the flights under mismatches as one object for JSON
``comparison_table``    the table of the scenarios
``mismatch_table``      the table of the mismatches
``comparison_figures``  a picture of each scenario and a summary
``mismatch_figure``     a picture of all mismatches
``comparison_page``     the page that holds table and pictures
======================  ==============================================================
"""
