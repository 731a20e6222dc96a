"""Stability: the paper's Section 5, what is wrong in it, and a proof of the terminal set.

=======================  ==========================================================================
``terminal``             local controller, terminal weight, terminal level (23)-(25), (28)
``stability_problem``    what is analysed: model, orbit, weights, input set; the paper's values
``theorems``             Theorems 2 and 3 as written, quantity by quantity
``violation``            search for states that break a condition
``analysis``             Section 5 for one configuration; ``analysis_text`` for JSON and words
``printed``              what the paper prints
``distance_budget``      what can be flown at all in N steps
``paper_report``         the paper beside the truth; ``paper_report_text`` for table and page
-----------------------  --------------------------------------------------------------------------
``ball``                 CasADi functions in ball arithmetic (python-flint)
``closed_loop``          f(x, K x) and derivatives with exact numbers
``quadratic_bound``      the one kind of inequality that is proved
``box_check``             is it true on one box? with the guesses of ``box_guess``
``cover``                is it true on all of X_f? halve boxes until it is
``admissible``           inputs in U, states in the model's domain, on all of X_f
``direct_condition``     the three together: X_f is a terminal set
``certificate``          the proof written down
``verify``               the independent checker, on ``interval`` and ``interval_matrix``
``claim``                what a controller may claim, in words
``status``               certified, sampled or neither: what a controller may claim
-----------------------  --------------------------------------------------------------------------
``decrease``             online check of (54)
``campaign``             what was proved, flown
``attraction``           maps of X_N (20)
``design``               rho and weights for the largest certified region
``tracking_problem``     P_N of (16) for a configuration
``parallel``             work in processes, with a progress bar
``figures``              pictures
``command``              ``uav_tracking stability``
=======================  ==========================================================================

Proving needs python-flint (``pip install python-flint``, extra ``proof``); checking a certificate,
the status of a configuration and the online check do not.
"""
