"""What is known of aircraft, air and target."""
