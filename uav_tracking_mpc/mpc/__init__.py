"""The optimal control problem (14)-(16) as data, and its solvers. Knows nothing of aircraft.

====================  ================================================================
``problem``           any problem of this kind: dynamics, costs, box, inequalities
``quadratic``         (14)-(16) of the paper: quadratic costs, terminal ellipsoid
``solution``          what comes back: a status in words, cost, plan, time
``solver``            the interface that every solver shares
``casadi_solver``     the problem handed to fatrop or IPOPT through CasADi
====================  ================================================================
"""
