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
``metrics``           the numbers of ``metrics.json``, and what they say in sentences
``trajectory``        the flight in space, as Figure 2 of the paper
``time_panels``       states and inputs over time, as Figure 3; limits, air and modes
``animation``         the flight as a moving picture
``mission_report``    ``write_report``: all of it into one folder
``figure_style``      colours, type and resolution that all figures share
``mode_colours``      the colour of each fallback mode, in figures and on the live page
``pages``             tables for the terminal and for documentation; HTML pages, their icon
``atomic_write``      files that are whole or absent
``bag``               messages of bags, in order
``bag_index``         the same by topic and time
====================  ================================================================

Everything starts from a :class:`uav_tracking_mpc.simulation.flight_log.FlightLog`::

    from uav_tracking_mpc.report.mission_report import write_report

    numbers = write_report(log, Path("output"))
"""
