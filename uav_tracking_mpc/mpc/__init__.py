"""The optimal control problem (14)-(16) as data, and its solvers. Knows nothing of aircraft.

====================  ================================================================
``problem``           any problem of this kind: dynamics, costs, box, inequalities
``quadratic``         (14)-(16) of the paper: quadratic costs, terminal ellipsoid
``solution``          what comes back: a status in words, cost, plan, time
``solver``            the interface that every solver shares
``casadi_solver``     the problem handed to fatrop or IPOPT through CasADi
``newton_solver``     the problem solved by a stagewise Newton method, compiled for it
``newton``            that method, one idea a file
``cold_start``        the guesses from which a cold solve tries it
``stage_code``        the problem's equations and derivatives as straight-line code
``compiled_method``   compile the method for a problem, or load it from the cache
``prediction_loop``   the closed loop on the prediction model itself, for campaigns
====================  ================================================================
"""
