"""ROS 2 nodes of FlexROS: thin shells that turn messages into calls of the library and back."""
