"""The controller, from a measurement to a command, and its fallback modes.

====================  ==============================================================
``controller``        the whole control step
``guidance``          what the parameters ask for: an optimal control problem, or a law
``bank_alone``        a law where the autopilot holds altitude and airspeed
``fallback``          the modes from the optimal plan down to silence, and their choice
``command_shaping``   commands inside their limits, faded from one guidance to another
``excitation``        a small test signal, from which the aircraft's answer is identified
``command``           what the controller answers
``adaptation``        flies by the response that the aircraft shows
``oscillation``       tells limit cycles, and why
``limit_cycle``       notices one
``event``             what it reports
``direction``         which way round
``orbit_shortfall``   tells when another orbit is flown than the one asked for
``pace``              when a command is due
``plan_memory``       what is left of the last plan
``rate_keeper``       whether the control rate is kept
``record``            what a controller was given, to be flown again
``certification``     what may be claimed of the terminal set that is flown
``orbit_deviation``   motion near the orbit, linearised at one azimuth
``sampled_loop``      lag, dead time, prediction and a static gain as a sampled loop
``orbit_loop``        that of the controller: its answers near the orbit
``loop_margins``      gain, phase, delay and disk margins of a loop
``margin_check``      whether they are as large as is asked, in words
====================  ==============================================================
"""
