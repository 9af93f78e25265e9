"""The social force model, as HuNavSim uses it."""

from pydantic.dataclasses import dataclass

from hunav_drake.systems.crowd import kernel
from hunav_drake.systems.crowd.motion_model import (
    Array,
    Snapshot,
    register_motion_model,
)
from hunav_drake.systems.schema import CONFIG


@register_motion_model("social_force")
@dataclass(kw_only=True, config=CONFIG)
class SocialForceModel:
    """Goal, walls, people, robots and groups push and pull.

    Helbing & Molnar 1995, Moussaid et al. 2009 and 2010, as in `lightsfm`.
    """

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the forces: see `MotionModel.forces`."""
        forces: Array = kernel.social_forces(
            snapshot.states,
            snapshot.radii,
            snapshot.command,
            snapshot.parameters,
            snapshot.robots,
            snapshot.obstacles.segments,
            snapshot.obstacles.first,
            snapshot.obstacle_range,
            snapshot.max_obstacles,
        )
        return forces

    def advance(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the next states: see `MotionModel.advance`."""
        states: Array = kernel.advance(
            snapshot.states, forces, snapshot.command, snapshot.time_step
        )
        return states
