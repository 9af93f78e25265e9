"""The social force model, as HuNavSim uses it."""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import StrictBool, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.layout import VX, VY, Command, Hold
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

    kernel: Literal["fast", "reference", "numpy", "hunavsim"] = "fast"
    """Implementation of the forces: "fast" agrees with the others to rounding,
    and in a crowd to `error_bound`; "reference" gives the numbers of the
    original bit for bit; "numpy" needs no compiler. "hunavsim" has the rules of
    the form that HuNavSim calls: see `hunavsim.py`. It is without epsilon."""

    error_bound: Annotated[StrictFloat, within(0, 1, "m/s^2")] = 1e-6
    """Bound of the sum of forces on a person that the fast kernel neglects,
    from 48 people on, in m/s^2; 0 neglects nothing."""

    time_gap: Annotated[StrictFloat, within(0, 10, "s")] = 0.62
    """Time gap that people keep to the person ahead, in seconds; 0 is none, as
    in HuNavSim. The default fits measured flows and recorded people:
    docs/calibration.md."""

    speed_matching: Annotated[StrictFloat, within(0, 1)] = 0.54
    """Share of the speed of the person ahead that is added to the speed that
    the time gap allows. The default fits measurements, as above."""

    passing_speed: Annotated[StrictFloat, within(0, 10, "m/s")] = 0.3
    """Least speed that the time gap leaves people behind others who stand, in
    m/s: those who touch them walk around them. In version 0.1 it was 0.02."""

    robot_obstacle_radius: Annotated[StrictFloat, within(0, 5, "m")] = 0.0
    """With the kernel "hunavsim": radius of a robot's body that pushes people
    who do not react to it as a wall does, in meters; 0 for none. In Gazebo,
    hunav_gazebo_wrapper takes the nearest of all models for an obstacle, and
    leaves out people, but not robots."""

    measured_velocities: StrictBool = False
    """Whether people who stop have no velocity with the kernel "hunavsim",
    which keeps it for others to see. In Gazebo they have none, as
    hunav_gazebo_wrapper derives velocities from positions."""

    follows: ClassVar[bool] = True

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the forces: see `MotionModel.forces`."""
        if self.kernel == "numpy":
            return numpy_model.social_forces(snapshot)
        forces: Array
        if self.kernel == "fast":
            forces = kernel.fast_social_forces(
                *snapshot.as_arguments, self.error_bound
            )
        elif self.kernel == "hunavsim":
            ordered, _, places = _in_turn(snapshot)
            forces = hunavsim.social_forces(*ordered.as_arguments)[places]
            if self.robot_obstacle_radius > 0:
                hunavsim.add_pushes(
                    *(forces, snapshot.states, snapshot.radii),
                    *(snapshot.parameters, snapshot.robots),
                    self.robot_obstacle_radius,
                )
        else:
            forces = kernel.social_forces(*snapshot.as_arguments)
        return forces

    def advance(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the next states: see `MotionModel.advance`."""
        if self.kernel == "numpy":
            return numpy_model.advance(snapshot, forces)
        states: Array
        if self.kernel == "hunavsim":
            ordered, rows, places = _in_turn(snapshot)
            states = hunavsim.advance(
                *ordered.as_arguments, forces[rows], snapshot.time_step
            )[places]
            if self.measured_velocities:
                stays = snapshot.command[:, Command.HOLD] == Hold.STAY
                states[stays, VX : VY + 1] = 0.0
            return states
        states = kernel.advance(
            snapshot.states, forces, snapshot.command, snapshot.time_step
        )
        return states


def _in_turn(snapshot: Snapshot) -> tuple[Snapshot, Any, Any]:
    """Returns a snapshot whose rows are in turn: see `Snapshot.turns`.

    After it come its rows in the given one, and the given ones' rows in it.
    """
    rows = snapshot.turns
    if rows is None:
        return snapshot, slice(None), slice(None)
    ordered = snapshot._replace(
        states=snapshot.states[rows],
        radii=snapshot.radii[rows],
        command=snapshot.command[rows],
        parameters=snapshot.parameters[rows],
        eased=snapshot.at_walls[rows],
        turns=None,
    )
    return ordered, rows, np.argsort(rows)
