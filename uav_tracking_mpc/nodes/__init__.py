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

"""ROS 2 nodes: parameters and messages in, one call, messages out.

=========================  ===============================================================
``uav_simulator``          the vehicle and its autopilot
``target_publisher``       where the target is
``target_truth``           where it truly is, and where it is sent, as messages
``autopilot_link``         a real aircraft in the simulator's place
``clock_offset``           ROS time by the clock of a link
``link_reader``            the thread that reads a vehicle link
``sighting_publisher``     what a vehicle to circle says of itself, as the target
``nmpc_controller``        messages to the controller, its commands to the vehicle
``engage_service``         takes its commands away and gives them back
``controller_report``      what it has done, as numbers for /diagnostics
``air_values``             what is known of the air, as values of diagnostics
``response_values``        how the aircraft answers commands, as values of these
``controller_views``       what it shows to people: tracking errors, path, markers
``view_messages``          the messages of path and markers
``orbit_message``          the orbit that is flown, and back
``reported_orbit``         the orbit that is asked for, as values of diagnostics, and back
``reported_mode``          the fallback mode, likewise
``tracking_message``       what the controller tracks by, as figures by name
``command_path``           where a command leads, point by point
``odometry_wire``          an odometry from bytes, read in place
``command_wire``           a command as bytes, rewritten in place
``stall_guard``            whether the process has been standing still
``monitor``                a live table in the terminal
``flight_watcher``         every aircraft of a domain, for who only looks
``heard_aircraft``         what is heard of one of them
``newest_message``         the newest message of a topic, read when it is looked at
``remote_parameters``      parameters of another node
``spun_node``              a node in the background of a program that is none
``flight_recorder``        every topic of a flight
``flight_bag``             an MCAP bag: written, and read back as a flight log
``flight_complaint``       what the nodes of a recorded flight complained of last
``bag_series``             values beside the states and commands of a bag
``offered_quality``        what publishers offer, as the metadata of a bag states it
``recorded_transform``     the aircraft's transform for /tf in a bag
``flown_target``           where the target of a recorded flight was
``message_times``          when messages were measured; those without a stamp
``sole_sender``            whether a topic has two senders that should have one
``throttled_warnings``     warnings that may come with every message
``peers``                  whether anybody is at the other end, and what rate is promised
``topics``                 names, types and qualities of service
``endpoints``              publishers and subscriptions of them, with ``qos_overrides``
``qos_overrides``          these parameters, checked
``overhearing``            subscriptions that only look, and follow the senders
``conversions``            messages to arrays and back, the only module that knows both
``frame_names``            the frames of messages as a node writes and expects them
``transform_broadcaster``  ``/tf`` and ``/tf_static``, where ROS has tf2_msgs
``vehicle_transform``      the transform of ``/tf`` that an odometry says
``message_checks``         what may stand in a message
``odometry_noise``         noise as the covariances of an odometry, and back
``target_odometry``        what a tracker says of the target
``declared_parameters``    parameter dataclasses as ROS parameters
``diagnostics``            /diagnostics
``steady_status``          which status is shown where it may change with every message
``managed_node``           the transitions of a managed node: told, and survived
``sample_window``          median, percentile, maximum and histogram of durations
``node_help``              what a node prints with --help
``reference_tables``       the tables of the README, written from the code
``log_folder``             a folder for log files that can be written
``ros_environment``        the domain that is exported, and why ROS does not start
``steering_requests``      what another node asks of them: parameters, services, the target's goal
``outage``                 a service that keeps back what a node sends, for a while
``run``                    start, spin, stop, exit codes
=========================  ===============================================================
"""
