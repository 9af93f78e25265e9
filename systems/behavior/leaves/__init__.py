"""The conditions and actions of people. Importing this registers them all."""

from hunav_drake.systems.behavior.leaves import (  # noqa: F401
    reactions,
    robot_conditions,
    walking,
    yielding,
)
