"""Measurements with a command of their own: the graph, the driver, the trunk without ROS."""
