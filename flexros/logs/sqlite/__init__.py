"""Reading of bags in the SQLite storage of rosbag2, the default one up to ROS 2 Humble."""
