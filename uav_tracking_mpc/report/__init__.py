# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""What a flight looks like afterwards: its numbers, its figures, and one page that tells both.

====================  ================================================================
``metrics``           the numbers of ``metrics.json``
``flight_findings``   what the numbers say in sentences: the verdict, the range offset
``trajectory``        the flight in space, as Figure 2 of the paper
``time_marks``        labelled dots along a path
``states``            states, inputs and cost over time, as Figure 3
``conditions``        limits, air, target and fallback modes over time
``time_axes``         what panels over time share
``replay``            the flight as a moving scene, made in ``view``
``animation``         the flight as a moving picture
``mission_report``    ``write_report``: all of it into one folder
``mode_colours``      the colour of each fallback mode, in figures and on the live page
``figure_style``      colours, type and resolution that all figures share
``table``             tables for the terminal and for pages
``html_page``         pages that need no other file
``atomic_write``      files that are whole or absent
====================  ================================================================

Everything starts from a :class:`uav_tracking_mpc.simulation.flight_log.FlightLog`::

    from uav_tracking_mpc.report.mission_report import write_report

    numbers = write_report(log, Path("output"))
"""
