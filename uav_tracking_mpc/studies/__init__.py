"""What studies the controller; nothing that flies imports it.

==================  ========================================================================"""
