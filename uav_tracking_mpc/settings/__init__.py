"""What can be set: the parameters of each part, described once, and configurations of them all.

=========================  ==================================================================
``tracking``               what the controller is asked to do
``estimation_parameters``  what it is told of delays and noise, and what it finds out by itself
``simulator``              the simulated aircraft and its air
``target``                 how the simulated target moves and is measured
``link``                   which autopilot flies, where it is, what may be asked of it
``mission``                what the commands add to the nodes' parameters
``parameter_file``         YAML in the form that ROS 2 reads
``configuration``          one file for all of them, by name, checked
=========================  ==================================================================
"""
