"""Learned equilibrium-point controller: bellows lengths to pressures."""
