"""Online goal babbling: an inverse model learned while the robot tries to reach goals."""
