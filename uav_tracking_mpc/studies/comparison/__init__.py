"""The predictive controller beside two classical laws, through the same scenarios.

====================  ================================================================
``flights``           every law through every scenario, in processes
``measures``          what counts of a flight, from the truth and the limits alone
``targets``           what the predictive controller is to reach, and whether it does
``results``           all of it as one object for JSON
``table``             the table: for the terminal, and for a page of the documentation
``figures``           a picture of each scenario and a summary
``page``              the page that holds table and pictures
``command``           ``uav_tracking compare``
====================  ================================================================
"""
