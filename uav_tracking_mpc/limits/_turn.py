"""What the limits of the turn rate share."""

# An orbit that needs every bit of the turn rate leaves nothing to correct an error with.
TURN_RATE_SHARE = 0.95
