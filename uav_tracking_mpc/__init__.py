"""Nonlinear model predictive control of a fixed-wing UAV that circles a ground target in 3-D.

The package is a ROS 2 node package and, without ROS, a library. Its rooms, top to bottom; each
imports only from those below it:

===============  ==============================================================================
``cli``          the ``uav_tracking`` command
``launch``       the nodes as processes, started by plain Python
``nodes``        ROS 2 nodes: messages in, one call, messages out
``feasibility``  the artificial orbit: what is guaranteed, and flights that show it
``comparison``   the controller beside classical laws, through the same scenarios
``report``       metrics, figures, the mission report
``simulation``   closed loop without ROS, deterministic
``guidance``     state in, command out; what to do when things fail
``stability``    terminal ingredients and the paper's analysis
``mpc``          the optimal control problem (14)-(16) as data, and its solvers
``dynamics``     the vehicle (3) and its motion relative to the target (9)-(12)
===============  ==============================================================================

Equation numbers are those of "On the Stability of Nonlinear Model Predictive Control for 3D Target
Tracking". Units are SI and radians throughout; frames follow REP-103.
"""

__version__ = "0.2.0"
