"""The settings of a reaction in HuNavSim 2.0's agents.yaml, as ports.

In HuNavSim, the `configuration` decides: default values (0), the given values
(1), or values drawn from a normal (2) or a uniform distribution (3).
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from hunav_drake.systems.common.random_streams import (
    Purpose,
    draw_normal,
    draw_uniform,
)
from hunav_drake.systems.people.human_config import ForcesMode

# The seed of the draws: a file always becomes the same scenario.
_SEED = 0


class Setting(NamedTuple):
    """One setting of a reaction.

    Attributes:
        port: The name of the port here.
        usual: HuNavSim's default; None for the person's `max_vel`.
        mean: The mean of the normal distribution.
        deviation: Its standard deviation.
        least: The lower limit of its draws; 0 if HuNavSim has none, because
            negative times and speeds have the same effect.
        low: The lower end of the uniform distribution.
        high: Its upper end.
    """

    port: str
    usual: float | None
    mean: float
    deviation: float
    least: float
    low: float
    high: float


def _duration(usual: float) -> Setting:
    return Setting("duration", usual, 40.0, 15.0, 0.0, 25.0, 60.0)


def _speed(usual: float | None, least: float) -> Setting:
    return Setting("speed", usual, 0.8, 0.35, least, 0.6, 1.2)


def _sight(usual: float) -> Setting:
    return Setting("distance", usual, 4.5, 2.5, 1.5, 2.0, 6.0)


# By behavior and key.
SETTINGS: Mapping[str, Mapping[str, Setting]] = MappingProxyType(
    {
        "surprised": {"duration": _duration(30.0), "dist": _sight(4.0)},
        "scared": {
            "duration": _duration(40.0),
            "vel": _speed(0.6, 0.0),
            "dist": _sight(3.0),
            "other_force_factor": Setting(
                "push", 20.0, 20.0, 6.0, 0.0, 10.0, 25.0
            ),
        },
        "curious": {
            "duration": _duration(40.0),
            "vel": _speed(None, 0.4),
            "dist": Setting("stop_distance", 1.5, 1.5, 0.3, 0.0, 1.0, 2.5),
        },
        "threatening": {
            "duration": _duration(40.0),
            "dist": Setting("goal_distance", 1.4, 1.4, 0.3, 0.0, 0.8, 1.9),
        },
    }
)

# HuNavSim's values of missing settings.
_MISSING: Mapping[str, Any] = MappingProxyType(
    {
        "duration": 40.0,
        "once": True,
        "vel": 1.0,
        "dist": 0.0,
        "other_force_factor": 20.0,
    }
)
REACTION_KEYS = (*_MISSING,)

# HuNavSim's limit of speeds, in m/s.
_MAX_VEL = 1.8

# HuNavSim's limits of factors of forces, except custom ones.
FACTOR_RANGES: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "goal_force_factor": (2.0, 5.0),
        "obstacle_force_factor": (2.0, 50.0),
        "social_force_factor": (5.0, 20.0),
    }
)

Tell = Callable[[str, str], None]


def reaction_ports(
    human: Mapping[str, Any], given: Mapping[str, Any], count: int, tell: Tell
) -> dict[str, tuple[str, Any]]:
    """Returns the ports of a person's reaction.

    Args:
        human: The fields of the person, with the name of the behavior. A
            behavior without a reaction has no ports.
        given: The settings of the behavior in the file.
        count: The person's default number. The number determines the draws.
        tell: Receives a key, and how the used value differs from the file.

    Returns:
        The key in the file and the value of each port.
    """
    behavior = human["behavior"]
    mode: ForcesMode = human["forces_mode"]
    _tell_factors(mode, given, tell)
    settings = SETTINGS.get(behavior, {})
    for key in _MISSING:
        if key in given and (not settings or key not in (*settings, "once")):
            tell(key, f"has no part in {behavior}")
    if not settings:
        return {}
    number = human.get("id")
    if type(number) is not int or number < 0:
        number = count
    once = given.get("once", True)
    if mode == "default" and once is not True:
        once = True
        tell("once", "is true with the configuration default")
    ports = {"only_once": ("once", once)}
    for index, (key, setting) in enumerate(settings.items()):
        if mode == "custom":
            value = _written(key, given, tell)
        elif mode == "default":
            usual = setting.usual
            value = human["desired_speed"] if usual is None else usual
            tell(key, f"is {value} with the configuration default")
        else:
            value = _drawn(setting, index, mode, number)
            tell(key, f"is drawn with the configuration {mode}, once for all")
        ports[setting.port] = (key, value)
    return ports


def _written(key: str, given: Mapping[str, Any], tell: Tell) -> Any:
    """Returns a custom setting."""
    if key not in given:
        tell(key, f"is missing; as in HuNavSim, {_MISSING[key]}")
        return _MISSING[key]
    value = given[key]
    if key == "vel" and type(value) in (int, float):
        limited = min(max(value, 0.0), _MAX_VEL)
        if limited != value:
            tell(key, f"is limited to {limited} m/s, as in HuNavSim")
        return limited
    return value


def _drawn(
    setting: Setting, index: int, mode: ForcesMode, human_id: int
) -> float:
    """Returns a setting that is drawn, with three decimals."""
    if mode == "random_normal":
        draws = draw_normal(_SEED, [human_id], Purpose.REACTION, index + 1)
        value = setting.mean + setting.deviation * draws[0, index]
        return round(max(setting.least, float(value)), 3)
    draws = draw_uniform(_SEED, [human_id], Purpose.REACTION, index + 1)
    low, high = setting.low, setting.high
    return round(low + (high - low) * float(draws[0, index]), 3)


def _tell_factors(mode: str, given: Mapping[str, Any], tell: Tell) -> None:
    """Reports factors of forces that are unusual or ignored."""
    for key, (low, high) in FACTOR_RANGES.items():
        if key not in given:
            continue
        value: Any = given[key]
        if mode != "custom":
            tell(key, f"has no part with the configuration {mode}")
        elif type(value) in (int, float) and not low <= value <= high:
            tell(
                key,
                f"is kept, but beyond [{low:g}, {high:g}], where HuNavSim"
                " keeps factors that are not custom",
            )
