"""Nodes as processes: started, watched over and ended.

=====================  ==========================================================================
``domain``             a ROS domain of one's own
``shared_memory``      files of Fast DDS that a killed process leaves behind
``node_process``       one node as a process that cannot outlive its launcher
``supervisor``         all node processes of a flight: started, frozen, killed, restarted, ended
``flight``             one flight with real nodes, recorded
``preflight``          what a real autopilot says before, and the envelope that follows
``autopilot_process``  an autopilot of our own behind a wire, where there is no other
=====================  ==========================================================================
"""
