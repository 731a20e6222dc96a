"""What flies: the vehicle (3), its motion relative to a target (9)-(12), angles and frames.

====================  ================================================================
``angles``            wrapping
``frames``            REP-103: ENU, FLU, quaternions, signs on the wire
``vehicle``           (3) in ``map``, advanced exactly under held inputs
``orbit``             the reference (r_d, z_d, v_d) and its direction
``gravity``           standard gravity
``lagged_vehicle``    (3) behind inner loops that lag, in a drift, for numbers and symbols
``drifting_orbit``    the periodic orbit under drift and its turn rate
``relative``          (r, theta, z, chi, v): exact, and the paper's models as printed
``discretisation``    Euler (10), Runge-Kutta 4, error form (11), linearisation (12)
====================  ================================================================
"""
