"""Replay: the messages of any log in the order of time and at a given rate; without ROS and without a clock."""
