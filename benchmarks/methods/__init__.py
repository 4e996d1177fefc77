"""Methods beside which goal babbling is compared: one world, one interface."""
