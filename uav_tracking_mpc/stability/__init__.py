"""Stability: terminal ingredients of the paper's Section 5.

====================  ================================================================
``terminal``          local controller, terminal weight, terminal level (23)-(25), (28)
====================  ================================================================
"""
