"""Serialised ROS 2 messages: one codec per type, layouts and definitions."""
