"""Optional Cartesian feedback: integrates the error of the tip in goal space."""
