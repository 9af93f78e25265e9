"""The conditions and actions of people. Importing this registers them all."""

# The leaves register themselves.
from hunav_drake.systems.behavior.leaves import (  # noqa: F401
    activities,
    blocking,
    circles,
    conversations,
    doors,
    gaze,
    goals,
    going,
    making_way,
    needs,
    others,
    pausing,
    reactions,
    robot_conditions,
    speech,
    walking,
    with_robots,
    yielding,
)
