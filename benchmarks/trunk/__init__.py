"""Tables on the simulated trunk, and what they share."""
