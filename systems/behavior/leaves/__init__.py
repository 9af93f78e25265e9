"""The conditions and actions of people. Importing this registers them all."""

# The leaves register themselves.
from hunav_drake.systems.behavior.leaves import (  # noqa: F401
    blocking,
    making_way,
    reactions,
    robot_conditions,
    walking,
    yielding,
)
