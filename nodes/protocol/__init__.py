"""The protocol of the nodes in plain Python; imports no ROS."""
