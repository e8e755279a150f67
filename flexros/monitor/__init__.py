"""Gap monitor: an observer model of a running robot, the deviations of the robot, their locations and alarms."""
