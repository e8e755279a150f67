"""Replay: the messages of a log, own or foreign, in the order of time and at a pace; free of ROS and of clocks."""
