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
from hunav_drake.systems.crowd.decisions_config import DecisionsConfig
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS, MotionModel
from hunav_drake.systems.people.profile import PROFILES, ProfileName

Acceleration = Annotated[StrictFloat, within(0.1, 1e3, "m/s^2")]
TurnRate = Annotated[StrictFloat, within(0.1, 1e3, "rad/s")]


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class CrowdConfig:
    """The configuration of the crowd: motion model, bodies, walls, robots."""

    profile: ProfileName = "default"
    """Source of the values of missing keys: the defaults written here or, with
    "hunavsim", the values of HuNavSim, with "hunav_drake_0.1" those of version
    0.1; see `people/profile.py`. It also selects the behaviors, and the weights
    of people without any. A key that is given takes precedence over the profile
    (and `dataclasses.replace` gives all keys)."""

    model: Annotated[MotionModel, MOTION_MODELS] = field(
        default_factory=MOTION_MODELS.make
    )
    """Motion model: a registered one, its name, or a mapping of its `type` and
    parameters, as in {type: orca, time_horizon: 2.0}. See
    `hunav_drake.systems.crowd.MOTION_MODELS`."""

    obstacle_range: PositiveLength = 5.0
    """Distance beyond which walls exert no force, in meters."""

    max_obstacles: Annotated[Integer, Field(ge=0, le=10**6)] = 0
    """Largest number of walls that exert forces, nearest first; 0 for all in
    range."""

    keep_out_of_walls: StrictBool = True
    """Whether walls stop people who are pushed into them: at the end of a step
    no body of up to 0.3 m radius is deeper in a wall than 1 cm, unless it was
    before, and then it comes no nearer. People who meet no wall move as without
    it."""

    keep_apart: StrictBool = True
    """Whether bodies are kept apart: at the end of a step no body overlaps
    another, or a robot, if there is room. People give way to robots."""

    robots_stop: StrictBool | None = None
    """Whether bodies stop robots, so that people give way only when pushed;
    otherwise people leave the place that a robot moves to by the end of the
    step. By default, as the robot of the trial demands, else not. See
    docs/robots.md."""

    groups_part: StrictBool = True
    """Whether members of a group walk together only while they go the same way:
    a member who has another goal, or has arrived, does not hold back the
    others. If false, as in HuNavSim, groups stay together in any case."""

    robot_gap: Annotated[StrictFloat, within(0, 10, "m")] = 0.6
    """Gap between the bodies of people and a robot that is a pedestrian to
    them, in meters, where there is room: people with a robot in the way, within
    3 m, walk past it. 0 leaves it to the forces, as in HuNavSim."""

    robots_behind: StrictBool = True
    """Whether people keep that gap also to robots that come from behind; else
    only forces and bodies move them out of the way, as in version 0.1."""

    standing: StrictBool = True
    """Whether people without a goal, or at it, stand: they stop, only strong
    forces and bodies move them, and they come back."""

    max_acceleration: Acceleration | None = 3.5
    """Largest rate of change of velocities, in m/s^2; None is no limit, as in
    HuNavSim."""

    max_turn_rate: TurnRate | None = 4.0
    """Largest rate of change of headings, in rad/s; None is no limit, as in
    HuNavSim."""

    route_planning: StrictBool = True
    """Whether people plan routes around walls to their goals, and are not
    pushed back by the walls of doors on their way. If false, as in HuNavSim,
    they walk straight to their goals, and the forces let no person of 0.35 m
    radius through a door of 0.85 m."""

    walls_behind_doors: StrictBool = True
    """Whether people who plan routes also pass a narrow door close behind which
    a wall makes them turn; else that wall counts as one that leaves no way, as
    in version 0.1, and slow people may stop before it."""

    separate_trees: StrictBool | None = None
    """Whether each person's behavior tree is a system of its own in the
    diagram; else one system ticks all, faster for many, with the same results.
    None is true for up to 10 people."""

    decisions: DecisionsConfig | None = None
    """Random decisions of people who walk, which the seed of the trial draws;
    by default, people decide by their behaviors alone. {} takes the defaults of
    all its keys."""

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
        """Returns the configuration that the profile alone gives."""
        return CrowdConfig(profile=self.profile)
