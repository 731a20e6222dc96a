"""The paper's problem and the flight problem."""
