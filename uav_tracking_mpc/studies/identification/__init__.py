"""Lag, dead time, gain and limits of an aircraft's channels, from a recorded flight.

========================  ===================================================================
``flight_record``         plans as they were flown, and what was measured
``bag_record``            such a record from a bag
``csv_record``            such a record from and to a CSV file
``channel_record``        what it says of one channel
``held_demand``           first-order lag and dead time, exact
``noise_model``           what the fit leaves over
``channel_fit``           maximum likelihood of lag, dead time and gain
``saturation``            limits, where the response shows them
``profile_intervals``     confidence intervals
``identification``        all channels of a flight
``identification_text``   table and YAML
``response_figure``       measured and fitted response
``validation``            how often all this is right, on simulated flights
========================  ===================================================================
"""
