"""The social force model, as HuNavSim uses it."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG, within
from hunav_drake.systems.crowd.motion_model import (
    Array,
    MotionModel,
    Snapshot,
    register_motion_model,
)
from hunav_drake.systems.crowd.social_force import hunavsim, kernel, numpy_model


@register_motion_model("social_force")
@dataclass(kw_only=True, config=CONFIG)
class SocialForceModel(MotionModel):
    """Goal, walls, people, robots and groups push and pull.

    Helbing & Molnar 1995, Moussaid et al. 2009 and 2010, as in `lightsfm`.
    """

    # "fast" agrees with the others to rounding, and in a crowd to
    # `error_bound`; "reference" gives the numbers of the original bit for
    # bit; "numpy" needs no compiler. "hunavsim" has the rules of the form that
    # HuNavSim calls, too: see `hunavsim.py`. It is without epsilon.
    kernel: Literal["fast", "reference", "numpy", "hunavsim"] = "fast"

    # From 48 people on, the fast kernel leaves out what adds up to less than
    # this for each person, in m/s^2; 0 leaves nothing out.
    error_bound: Annotated[StrictFloat, within(0, 1, "m/s^2")] = 1e-6

    # The time that people keep to whoever walks ahead of them, in seconds, and
    # what part of that one's speed they add; 0 lets them run up, as in
    # HuNavSim. The values fit measured speeds and flows: docs/validation.md.
    time_gap: Annotated[StrictFloat, within(0, 10, "s")] = 0.8
    speed_matching: Annotated[StrictFloat, within(0, 1)] = 0.35

    follows: ClassVar[bool] = True

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the forces: see `MotionModel.forces`."""
        if self.kernel == "numpy":
            return numpy_model.social_forces(snapshot)
        arguments = _arguments(snapshot)
        forces: Array
        if self.kernel == "fast":
            forces = kernel.fast_social_forces(*arguments, self.error_bound)
        elif self.kernel == "hunavsim":
            forces = hunavsim.social_forces(*arguments)
        else:
            forces = kernel.social_forces(*arguments)
        return forces

    def advance(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the next states: see `MotionModel.advance`."""
        if self.kernel == "numpy":
            return numpy_model.advance(snapshot, forces)
        states: Array
        if self.kernel == "hunavsim":
            states = hunavsim.advance(
                *_arguments(snapshot), forces, snapshot.time_step
            )
            return states
        states = kernel.advance(
            snapshot.states, forces, snapshot.command, snapshot.time_step
        )
        return states


def _arguments(snapshot: Snapshot) -> tuple[Any, ...]:
    """Returns what the compiled functions take."""
    return (
        snapshot.states,
        snapshot.radii,
        snapshot.command,
        snapshot.parameters,
        snapshot.robots,
        snapshot.at_walls,
        snapshot.obstacles.table,
        snapshot.obstacle_range,
        snapshot.max_obstacles,
    )
