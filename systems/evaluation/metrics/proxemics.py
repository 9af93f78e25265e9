"""Distances of the robot from people and groups.

Distances are gaps: between the surfaces of the discs of robot and person, 0
where they overlap.
"""

from functools import partial
import math

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics import reduce
from hunav_drake.systems.evaluation.metrics.path import PEREZ_2018
from hunav_drake.systems.evaluation.recording import Recording

_metric = partial(register_metric, family="proxemics")

# The outer radii of the intimate, personal and social space around a person, in
# meters: Hall, "The Hidden Dimension", 1969.
INTIMATE, PERSONAL, SOCIAL = 0.45, 1.2, 3.6

# The gap that a robot should keep from people, in meters.
COMPLIANT_GAP = 0.5


@_metric(
    unit="m",
    direction="higher",
    source=PEREZ_2018,
    aliases=["avg_distance_to_closest_person"],
    reduce=reduce.mean,
)
def avg_dist_to_closest_person(recording: Recording) -> Array:
    """The mean over the samples of the gap to the closest person.

    mean_k min_i gap_k^i, over the samples at which anyone is present; NaN
    without people. Series: the gap to the closest person.
    """
    return recording.features.closest_gap


@_metric(
    unit="m",
    direction="higher",
    source=PEREZ_2018,
    aliases=["minimum_distance_to_people"],
)
def min_dist_to_people(recording: Recording) -> float:
    """The smallest gap to anyone, min_{k,i} gap_k^i; NaN without people."""
    return float(np.fmin.reduce(recording.features.closest_gap))


@_metric(
    unit="m",
    source="HuNavSim, Perez-Higueras et al. 2023",
    aliases=["maximum_distance_to_people"],
)
def max_dist_to_people(recording: Recording) -> float:
    """The largest gap to anyone, max_{k,i} gap_k^i; NaN without people."""
    gaps = recording.features.gaps
    return float(np.fmax.reduce(gaps, axis=None, initial=np.nan))


@_metric(unit="%", direction="higher", source="Francis et al. 2025")
def space_compliance(recording: Recording) -> tuple[float, Array]:
    """The percentage of samples at which nobody is closer than 0.5 m.

    Among the samples at which anyone is present, those with min_i gap_k^i of at
    least 0.5 m; NaN without people. Series: 1 at such a sample, else 0.
    """
    complies = within_band(
        recording.features.closest_gap, COMPLIANT_GAP, math.inf
    )
    return 100 * reduce.mean(complies), complies


def within_band(gap: Array, low: float, high: float) -> Array:
    """Returns 1 where low <= gap < high, else 0, and NaN where gap is NaN."""
    inside = (gap >= low) & (gap < high)
    return np.where(np.isnan(gap), np.nan, inside.astype(float))


def _gap(low: float, high: float) -> str:
    """Returns the text for low <= gap < high, in meters."""
    below = f" < {high} m" if math.isfinite(high) else ""
    return f"{low} m <= gap{below}" if low else f"gap{below}"


def _in_band(
    recording: Recording, *, feature: str, low: float, high: float
) -> Array:
    return within_band(getattr(recording.features, feature), low, high)


# The kind of the gap, its feature, and its definition.
_PERSON = (
    "person",
    "closest_gap",
    "The gap is min_i gap_k^i. Samples without people count among all;\n"
    "NaN if nobody ever is present.",
)
_GROUP = (
    "group",
    "group_gap",
    "The gap is that to the interaction center c of the group,\n"
    "max(|p_k - c_k| - R_r, 0), where c is the mean over the members\n"
    "present, two at least, of the point 1.5 m ahead of each. NaN\n"
    "without groups.",
)

for _name, _low, _high, (_whom, _feature, _gap_text) in (
    ("intimate_space_intrusions", 0.0, INTIMATE, _PERSON),
    ("personal_space_intrusions", INTIMATE, PERSONAL, _PERSON),
    ("social+_space_intrusions", PERSONAL, SOCIAL, _PERSON),
    ("public_space_intrusions", SOCIAL, math.inf, _PERSON),
    ("group_intimate_space_intrusions", 0.0, INTIMATE, _GROUP),
    ("group_personal_space_intrusions", INTIMATE, PERSONAL, _GROUP),
    ("group_social+_space_intrusions", PERSONAL, SOCIAL, _GROUP),
):
    _metric(
        name=_name,
        unit="%",
        direction="none" if math.isinf(_high) else "lower",
        source=PEREZ_2018 if math.isfinite(_high) else "hunav_drake",
        aliases=[_name.replace("+", "")] if "+" in _name else [],
        definition=f"The share of samples with {_gap(_low, _high)} to the"
        f" nearest {_whom}.\n\n{_gap_text} Series: 1 at such a sample, else 0.",
        reduce=reduce.share,
    )(partial(_in_band, feature=_feature, low=_low, high=_high))
