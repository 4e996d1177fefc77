"""What several nodes of the Bionic Handling Assistant workspace share."""
