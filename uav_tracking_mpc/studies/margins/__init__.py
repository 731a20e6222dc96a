"""Stability margins of the closed loop about the orbit.

==================  ==============================================================
``flown_loop``      the loop as it answers impulses in flight, with all estimators
``margin_study``    margins in still air and in wind, and all of it for JSON
``margin_table``    the table
``margin_figure``   a Nichols chart, and the margins around the orbit
``weight_search``   weights for performance that keep the margins
==================  ==============================================================
"""
