"""The columns of a command, as plain integers, for compiled loops.

Numba takes plain integers of a module for constants, but not members of an
enumeration.
"""

from hunav_drake.systems.layout import Command, RobotRole

GOAL_X = int(Command.GOAL_X)
GOAL_Y = int(Command.GOAL_Y)
GOAL_RADIUS = int(Command.GOAL_RADIUS)
HAS_GOAL = int(Command.HAS_GOAL)
DESIRED_SPEED = int(Command.DESIRED_SPEED)
MAX_SPEED = int(Command.MAX_SPEED)
ROBOT_ROLE = int(Command.ROBOT_ROLE)
ROBOT_REPULSION = int(Command.ROBOT_REPULSION)
HOLD = int(Command.HOLD)
TURN_RATE = int(Command.TURN_RATE)
YAW_TARGET = int(Command.YAW_TARGET)
GROUP_ID = int(Command.GROUP_ID)

UNSEEN = int(RobotRole.UNSEEN)
PEDESTRIAN = int(RobotRole.PEDESTRIAN)
OBSTACLE = int(RobotRole.OBSTACLE)
