"""What the links to autopilots on MAVLink share.

======================  ==================================================================
``mavlink_link``        what all of them do alike
``listener``            everything that is heard of one autopilot
``dialect``             pymavlink and its messages
``connection``          bytes to messages and back
``autopilot_clock``     the autopilot's clock by ours
``telemetry``           messages to measurements
``flight_direction``    where it flies, from where the nose points
``vehicle_sighting``    a vehicle to circle that tells where it is
``vehicle_parameters``  parameters of the autopilot, read
``requests``            commands until they are acknowledged
``engagement``          who flies: pilot and autopilot, or our commands
``latency``             from telemetry in to the set-point that answers it
``findings``            what is looked at before a flight
``home_fence``          the autopilot's fence, as the controller and as an orbit see it
``arduplane_envelope``  what ArduPlane's parameters allow
``px4_envelope``        what PX4's parameters allow
``energy_law``          pitch and thrust, for autopilots that are told these
======================  ==================================================================
"""
