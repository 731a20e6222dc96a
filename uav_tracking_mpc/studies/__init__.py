"""Studies of what flies."""
