"""MCAP files and rosbag2 folders, in and out."""
