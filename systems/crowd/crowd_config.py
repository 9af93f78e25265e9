"""The configuration of the crowd as a whole."""

from collections.abc import Mapping
from dataclasses import field
from typing import Annotated, Any

from pydantic import Field, StrictBool, StrictFloat, model_validator
from pydantic.dataclasses import dataclass
from pydantic_core import ArgsKwargs

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    Integer,
    PositiveLength,
    within,
)
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS, MotionModel
from hunav_drake.systems.people.profile import PROFILES, ProfileName

Acceleration = Annotated[StrictFloat, within(0.1, 1e3, "m/s^2")]
TurnRate = Annotated[StrictFloat, within(0.1, 1e3, "rad/s")]


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class CrowdConfig:
    """How people move, and how they take in the world."""

    profile: ProfileName = "default"
    """What is meant where a key is left out: the defaults written here, or, by
    "hunavsim", what HuNavSim does; see `people/profile.py`. It chooses the
    behaviors, too. A key that is given counts, whatever the profile (and
    `dataclasses.replace` gives them all)."""

    model: Annotated[MotionModel, MOTION_MODELS] = field(
        default_factory=MOTION_MODELS.make
    )
    """The motion model: a registered one, its name, or a mapping of its `type`
    and parameters, as in {type: orca, time_horizon: 2.0}. See
    `hunav_drake.systems.crowd.MOTION_MODELS`."""

    obstacle_range: PositiveLength = 5.0
    """Walls whose nearest point is farther than this are not felt, in meters.
    """

    max_obstacles: Annotated[Integer, Field(ge=0, le=10**6)] = 0
    """How many walls are felt at most, the nearest first; 0 for all in range.
    """

    keep_out_of_walls: StrictBool = True
    """Whether walls stop people who are pushed into them: at the end of a step
    nobody's body is deeper in a wall than 1 cm, of bodies of up to 0.3 m, but
    for who was so before, and comes no nearer. Who meets no wall moves as
    without."""

    keep_apart: StrictBool = True
    """Whether bodies are kept apart: at the end of a step nobody's overlaps
    another's, or a robot's, if there is room. People give way to robots."""

    robots_stop: StrictBool | None = None
    """Whether bodies stop robots, so that only who is pushed gives way to one;
    else nobody is where a robot is going by the end of the step. By default as
    the robot of the trial is, and else not. See docs/robots.md."""

    groups_part: StrictBool = True
    """Whether people of a group walk together only as long as they go the same
    way: who has another goal, or has arrived, does not hold back the others.
    Without, as in HuNavSim, groups are held together whatever they want."""

    robot_gap: Annotated[StrictFloat, within(0, 10, "m")] = 0.6
    """The gap that people leave between their bodies and a robot that is one
    more pedestrian to them, in meters, where there is room: who sees one in the
    way, within 3 m, walks past it. 0 leaves it to the forces, as in HuNavSim.
    """

    standing: StrictBool = True
    """Whether people without a goal, or at it, stand: they stop, only strong
    forces and bodies move them, and they come back."""

    max_acceleration: (
        Annotated[StrictFloat, within(0.1, 1e3, "m/s^2")] | None
    ) = 3.5
    """How fast velocities change at most, in m/s^2; None is without limit, as
    in HuNavSim."""

    max_turn_rate: Annotated[StrictFloat, within(0.1, 1e3, "rad/s")] | None = (
        4.0
    )
    """How fast headings change at most, in rad/s; None is without limit, as in
    HuNavSim."""

    route_planning: StrictBool = True
    """Whether people walk around walls to their goals, and let no walls push
    them back from the doors on their way; without, straight at the goals, as in
    HuNavSim, whose forces let nobody of 0.35 m through 0.85 m."""

    @model_validator(mode="before")
    @classmethod
    def _apply_profile(cls, data: Any) -> Any:
        given = data.kwargs if isinstance(data, ArgsKwargs) else data
        if not isinstance(given, Mapping):
            return data
        name = given.get("profile")
        known = isinstance(name, str) and name in PROFILES
        return {**PROFILES[str(name)].crowd, **given} if known else data

    def defaults(self) -> "CrowdConfig":
        """Returns what this is by its profile alone."""
        return CrowdConfig(profile=self.profile)
