"""Logs: rosbag2 folders with MCAP storage, in and out, and the serialised messages they hold."""
