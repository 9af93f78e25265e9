"""What a simulated person is."""

from dataclasses import field
from typing import Annotated, Literal

from pydantic import Field, StrictBool
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    BodyRadius,
    Integer,
    Name,
    Points,
    Pose,
    PositiveLength,
    PositiveSpeed,
    Speed,
)
from hunav_drake.systems.people.behavior_choice import Behavior, behavior_name
from hunav_drake.systems.people.parameters import SocialForceParameters

# The radius of a body whose owner says nothing of it, at most, in meters.
LARGEST_BODY = 0.25

ForcesMode = Literal["custom", "default", "random_normal", "random_uniform"]


# The largest number of a group.
MAX_GROUP_ID = 2**31 - 1


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class HumanConfig:
    """One simulated person."""

    name: Name = ""
    """What the person is called; without a name "human_1", "human_2", ... in
    order."""

    id: Annotated[Integer, Field(ge=0, le=2**31 - 1)] | None = None
    """The number of the person, by which HuNavSim knows them; without one they
    are given out in order, from 1."""

    pose: Pose
    """The first pose (x, y, yaw) in W, in meters and radians."""

    behavior: Behavior = "regular"
    """The behavior tree: the name of one that comes with the package (see
    `hunav_drake.systems.behavior.BEHAVIORS`), the path of an XML file (it ends
    in .xml), or XML; with values for ports, a BehaviorConfig."""

    desired_speed: Speed = 1.2
    """The speed that the person prefers, in m/s; 0 is a standing person."""

    max_speed: PositiveSpeed | None = None
    """The speed never exceeded, in m/s; by default the desired speed, as in
    HuNavSim, and at least that."""

    radius: BodyRadius = 0.35
    """The radius of the disc that others keep off, in meters."""

    body_radius: BodyRadius | None = None
    """The radius of the body, which nobody else's overlaps, in meters; by
    default the radius above, but at most 0.25 m."""

    group_id: Annotated[Integer, Field(ge=-(2**31), le=MAX_GROUP_ID)] = -1
    """People with the same number (>= 0) walk together; -1 walks alone, and so
    do those below, but by HuNavSim's rules (its kernel of the forces), for
    which they are groups as any other."""

    goals: Points = field(default_factory=list)
    """The points to walk to, one after the other, in meters."""

    cyclic: StrictBool | None = None
    """Whether the first goal follows the last; by default not, but with the
    crowd's profile "hunavsim"."""

    goal_radius: PositiveLength = 0.3
    """The distance at which a goal counts as reached, in meters."""

    forces: SocialForceParameters = field(default_factory=SocialForceParameters)
    """The weights of the forces."""

    forces_mode: ForcesMode = "custom"
    """Where the factors of goal, obstacles and other people come from: they are
    as in `forces` ("custom"), HuNavSim's ("default"), or drawn for each person
    by the seed of the Context: see `HumanCrowd.SetSeed` and
    `hunav_drake.systems.people.weights`. The rest of `forces` always holds."""

    @property
    def speed_limit(self) -> float:
        """The speed that the person never exceeds, in m/s."""
        if self.max_speed is None:
            return self.desired_speed
        return self.max_speed

    @property
    def contact_radius(self) -> float:
        """The radius of the body, which nobody else's overlaps, in meters."""
        if self.body_radius is None:
            return min(self.radius, LARGEST_BODY)
        return self.body_radius

    @property
    def behavior_name(self) -> str:
        """What the behavior is called in tables."""
        return behavior_name(self.behavior)
