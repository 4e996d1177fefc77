"""Methods beside which goal babbling is compared, each on the same world and behind one interface."""
