"""Tables on planar arms and on linear problems, and what they share."""
