"""The controller and its fallback modes."""
