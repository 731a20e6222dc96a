"""What the aircraft can fly and where it may."""
