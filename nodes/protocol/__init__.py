"""The protocol of the nodes as plain Python: imports no ROS."""
