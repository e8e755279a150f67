"""Serialised ROS 2 messages: codecs, layouts and definitions."""
