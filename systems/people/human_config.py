"""The configuration of a simulated person."""

from collections.abc import Mapping
from dataclasses import field
from typing import Annotated, Any, Literal

from pydantic import (
    Field,
    GetJsonSchemaHandler,
    StrictBool,
    StrictFloat,
    model_validator,
)
from pydantic.dataclasses import dataclass
from pydantic_core import ArgsKwargs

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
    within,
)
from hunav_drake.systems.people.behavior_choice import Behavior, behavior_name
from hunav_drake.systems.people.figure_config import FigureConfig
from hunav_drake.systems.people.parameters import SocialForceParameters
from hunav_drake.systems.people.track_config import TrackConfig

# The largest radius of a body for which none is given, in meters; in a
# wheelchair, half its width.
LARGEST_BODY, WHEELCHAIR_BODY = 0.25, 0.3

ForcesMode = Literal["custom", "default", "random_normal", "random_uniform"]


# The pose of a person whose recording has it.
STAND_IN = (0.0, 0.0, 0.0)

# The largest number of a group.
MAX_GROUP_ID = 2**31 - 1


Level = Annotated[StrictFloat, within(0, 100)]
NeedRate = Annotated[StrictFloat, within(0, 100, "1/s")]


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class NeedConfig:
    """A need of a person: 100 when it is satisfied, 0 when it is urgent."""

    initial: Level = 100.0
    """Level at the start."""

    rate: NeedRate = 1.0
    """Loss of level per second, in 1/s."""


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class HumanConfig:
    """One simulated person."""

    name: Name = ""
    """Name of the person; by default "human_1", "human_2", ... in order."""

    id: Annotated[Integer, Field(ge=0, le=2**31 - 1)] | None = None
    """Number of the person, by which HuNavSim knows it; by default 1, 2, ... in
    order."""

    pose: Pose
    """Initial pose (x, y, yaw) in W, in meters and radians. A person with a
    `track` needs none."""

    track: TrackConfig | None = None
    """Recording that the person follows; it replaces pose, goals and speeds. By
    default, there is none."""

    behavior: Behavior = "regular"
    """Behavior tree: the name of one that comes with the package (see
    `hunav_drake.systems.behavior.BEHAVIORS`), the path of an XML file (it ends
    in .xml), or XML; with values for ports, a BehaviorConfig."""

    desired_speed: Speed = 1.2
    """Desired speed, in m/s; 0 is a standing person."""

    max_speed: PositiveSpeed | None = None
    """Speed limit, in m/s; by default the desired speed, as in HuNavSim, and at
    least that."""

    radius: BodyRadius = 0.35
    """Radius of the disc that others keep clear of, in meters."""

    body_radius: BodyRadius | None = None
    """Radius of the body, which no other body overlaps, in meters; by default
    `radius`, but at most 0.25 m, in a wheelchair 0.3 m."""

    group_id: Annotated[Integer, Field(ge=-(2**31), le=MAX_GROUP_ID)] = -1
    """Group of the person: people with the same number (>= 0) walk together.
    People with -1 walk alone, and so do those with lower numbers, except by
    HuNavSim's rules (its kernel of the forces), where these are groups, too."""

    invitations: Literal["accept", "ignore"] = "accept"
    """Whether the person comes when others ask for a talk or a walk together:
    see `ConversationFormation` and `SetGroupWalk`."""

    needs: dict[Name, NeedConfig] = field(default_factory=dict)
    """Needs by name, which behavior trees see to: see `NeedsSelector`."""

    figure: FigureConfig = field(default_factory=FigureConfig)
    """How the person looks."""

    goals: Points = field(default_factory=list)
    """Goals (x, y) to walk to, one after the other, in W, in meters."""

    cyclic: StrictBool | None = None
    """Whether the first goal follows the last; by default only with the crowd's
    profile "hunavsim"."""

    goal_radius: PositiveLength = 0.3
    """Distance at which a goal counts as reached, in meters."""

    forces: SocialForceParameters | None = None
    """Weights of the forces; of those that are given, missing ones are those of
    HuNavSim. By default, those of the crowd's profile, which are fitted to
    recorded people unless it is another program's."""

    forces_mode: ForcesMode = "custom"
    """Source of the factors of goal, obstacles and other people: as in `forces`
    ("custom"), as in HuNavSim ("default"), or drawn for each person by the seed
    of the Context: see `HumanCrowd.SetSeed` and
    `hunav_drake.systems.people.weights`. The rest of `forces` always holds."""

    @model_validator(mode="before")
    @classmethod
    def _stand_in(cls, data: Any) -> Any:
        """Gives a person with a track a pose, which its recording replaces."""
        is_call = isinstance(data, ArgsKwargs)
        given = data.kwargs if is_call else data
        if not isinstance(given, Mapping) or given.get("track") is None:
            return data
        given = {"pose": STAND_IN, **given}
        return ArgsKwargs(data.args, given) if is_call else given

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: Any, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Returns the JSON schema: a person with a track needs no pose."""
        reference = handler(core_schema)
        schema = handler.resolve_ref_schema(reference)
        required = {"required": schema.pop("required")}
        given = {"properties": {"track": {"type": "object"}}}
        schema.update(
            {"if": {**given, "required": ["track"]}, "else": required}
        )
        return reference

    @property
    def speed_limit(self) -> float:
        """The speed that the person never exceeds, in m/s."""
        if self.max_speed is None:
            return self.desired_speed
        return self.max_speed

    @property
    def contact_radius(self) -> float:
        """The radius of the body, which no other body overlaps, in meters."""
        if self.body_radius is not None:
            return self.body_radius
        sits = self.figure.wheelchair
        return min(self.radius, WHEELCHAIR_BODY if sits else LARGEST_BODY)

    @property
    def behavior_name(self) -> str:
        """The name of the behavior in tables."""
        return behavior_name(self.behavior)
