"""The extended flexible joint model of a robot (Moberg 2007, chapter 3 and Paper B)."""

from flexros.robot.robot import Robot, load_robot, robot_from_data, robot_names

__all__ = ["Robot", "load_robot", "robot_from_data", "robot_names"]
