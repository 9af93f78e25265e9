"""Cases of crowds at doors."""

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.validation.case import Numbers, Setting, case
from hunav_drake.validation.measures import flow_rate, peak_density
from hunav_drake.validation.places import Area, gap_in_wall, room, spread, wall
from hunav_drake.validation.walkers import SPEED, Walk, Walkers

# The range of measured flows at doors and in experiments, in persons/(m s);
# Seyfried et al. 2009 measured about 1.9.
FLOW_BAND = (1.6, 2.2)

# The widths of the doors, in meters.
_WIDTHS = (0.8, 1.0, 1.2, 1.6, 2.0, 2.4)

# If nobody leaves for this time, the others never do, in seconds.
_PATIENCE = 20.0

# A longer gap between two people interrupts the flow of a door, in seconds.
_GAP = 1.0


def _through_door(
    setting: Setting,
    people: int,
    size: tuple[float, float],
    door: float,
    thick: float = 0.2,
    speed: float = SPEED,
) -> Array:
    """Returns the times at which people leave a room by a door.

    Args:
        setting: The model and the options.
        people: The number of people.
        size: The length of the room along x, and its width, in meters.
        door: The width of the door, in the middle of a side, in meters.
        thick: The thickness of the wall, in meters.
        speed: Their desired speed, in m/s.

    Returns:
        Shape (people,), in seconds, in order; infinite for people who never
        leave.
    """
    length, width = size
    starts = spread(
        people,
        Area(0.3, 0.3, length - 0.7, width - 0.3),
        setting.generator("door"),
    )
    walkers = Walkers(
        setting,
        starts,
        [length + 30, width / 2],
        walls=room(length, width, door, thick),
        speeds=speed,
    )
    end = length + thick
    walk = walkers.walk(
        60 + people / door,
        leave=lambda rows: rows[:, 0] > end + 3,
        patience=_PATIENCE,
    )
    return np.sort(walk.first_time(walk.x > end))


def _left(times: Array) -> float:
    """Returns the number of finite times."""
    return float(np.isfinite(times).sum())


@case(
    "Seyfried et al. 2009",
    question="How many people per second and meter of width leave a room by"
    " doors of 0.8 to 2.4 m?",
    expected="1.6 to 2.2 persons/(m s) at each width",
    accepts=lambda it: all(
        FLOW_BAND[0] <= flow <= FLOW_BAND[1] for flow in it["flow"]
    ),
    shown="{flow:.2f} at {width:g} m",
)
def door_flow(setting: Setting) -> Numbers:
    """Measures the flow through doors of several widths."""
    widths = _WIDTHS[1::3] if setting.quick else _WIDTHS
    people = 30 if setting.quick else 100
    flows = [
        flow_rate(_through_door(setting, people, (10, 10), door)) / door
        for door in widths
    ]
    return {"width": list(widths), "flow": flows}


@case(
    "RiMEA 12 (parts c and d)",
    question="Do more people per second leave a room of 10 x 10 m with 150"
    " people by a wider exit, 0.8, 1.0 and 1.2 m wide?",
    expected="the flow increases with the width, and all leave",
    accepts=lambda it: bool(
        np.all(np.diff(it["flow"]) > 0) and min(it["left"]) == it["people"]
    ),
    shown="{flow:.2f} persons/s at {width:g} m, {left:.0f} of {people:.0f}"
    " leave",
)
def bottleneck_width(setting: Setting) -> Numbers:
    """Measures the flow of a crowd through bottlenecks of three widths."""
    people = 30 if setting.quick else 150
    widths = [0.8, 1.0, 1.2]
    times = [_through_door(setting, people, (10, 10), door) for door in widths]
    return {
        "width": widths,
        "flow": [flow_rate(it) for it in times],
        "left": [_left(it) for it in times],
        "people": people,
    }


@case(
    "RiMEA 12 (part b)",
    question="Do 150 people take longer for an exit 1 m wide and 5 m long than"
    " for one 0.2 m long?",
    expected="the last person is later, and all leave",
    accepts=lambda it: it["short"] < it["long"] < np.inf,
    shown="{short:.1f} s (0.2 m), {long:.1f} s (5 m)",
)
def bottleneck_length(setting: Setting) -> Numbers:
    """Measures when the last person leaves a short and a long bottleneck."""
    people = 30 if setting.quick else 150
    short, long = (
        _through_door(setting, people, (10, 10), 1.0, thick)[-1]
        for thick in (0.2, 5.0)
    )
    return {"short": float(short), "long": float(long)}


@case(
    "NIST 5.2, ISO 11",
    question="Do 100 people leave a room of 8 x 5 m by an exit of 1 m with at"
    " most the flow of regulations (IMO MSC/Circ.1238)?",
    expected="at most 1.33 persons/(m s), and all leave",
    accepts=lambda it: it["flow"] <= 1.33 and it["left"] == it["people"],
    shown="{flow:.2f} persons/(m s), {left:.0f} of {people:.0f} leave",
)
def regulated_flow(setting: Setting) -> Numbers:
    """Measures the mean flow of a room through its exit."""
    people = 40 if setting.quick else 100
    times = _through_door(setting, people, (8, 5), 1.0)
    return {
        "flow": flow_rate(times, 0.0, 1.0),
        "left": _left(times),
        "people": people,
    }


@case(
    "Helbing et al. 2000",
    question="Is there a desired speed above which a crowd takes longer to"
    " leave by a door of 0.8 m?",
    expected="the shortest time is not at the largest of 0.8, 1.3, 2.0 and 3.0"
    " m/s, and all leave",
    accepts=lambda it: (
        max(it["time"]) < np.inf and min(it["time"]) < it["time"][-1]
    ),
    shown="{time:.1f} s at {speed:.1f} m/s",
)
def faster_is_slower(setting: Setting) -> Numbers:
    """Measures when the last person leaves, for several desired speeds."""
    people = 20 if setting.quick else 60
    speeds = [0.8, 1.3, 2.0, 3.0]
    times = [
        _through_door(setting, people, (10, 10), 0.8, speed=speed)[-1]
        for speed in speeds
    ]
    return {"speed": speeds, "time": [float(time) for time in times]}


@case(
    "Helbing et al. 2000",
    question="Does a crowd form arches at a door of 0.8 m, which interrupt its"
    " flow?",
    expected="gaps of over 1 s between two people, and all leave",
    accepts=lambda it: it["gaps"] > 0 and it["left"] == it["people"],
    shown="{gaps:.0f} gaps, the longest of {longest:.1f} s; {left:.0f} of"
    " {people:.0f} leave",
)
def intermittent_flow(setting: Setting) -> Numbers:
    """Measures gaps in the flow of a crowd through a narrow door."""
    people = 30 if setting.quick else 80
    times = _through_door(setting, people, (10, 10), 0.8)
    gaps = np.diff(times[np.isfinite(times)])
    return {
        "gaps": float((gaps > _GAP).sum()),
        "longest": float(gaps.max(initial=0.0)),
        "left": _left(times),
        "people": people,
    }


@case(
    "NIST 5.1, ISO 10 (without the stair)",
    question="Do 100 people who leave a room of 8 x 8 m by a corridor 2 m wide"
    " and 12 m long queue at its entrance?",
    expected="a peak density in the room at the entrance that is at least 5 %"
    " above that in the middle of the corridor",
    accepts=lambda it: it["before"] >= 1.05 * it["middle"],
    shown="{before:.2f} before, {neck:.2f} where it begins, {middle:.2f}"
    " persons/m² in the middle",
)
def congestion_at_neck(setting: Setting) -> Numbers:
    """Measures peak densities before, at and behind the neck of a room."""
    people = 50 if setting.quick else 100
    walk = _into_corridor(setting, people)
    return {
        name: peak_density(walk, Area(x, 3, x + 2, 5))
        for name, x in (("before", 6.0), ("neck", 8.2), ("middle", 13.2))
    }


def _into_corridor(setting: Setting, people: int) -> Walk:
    walls = [*room(8, 8, 2.0), wall(8.2, 2.8, 20.2, 3), wall(8.2, 5, 20.2, 5.2)]
    starts = spread(people, Area(0.3, 0.3, 7.7, 7.7), setting.generator("neck"))
    walkers = Walkers(setting, starts, [50, 4], walls=walls)
    return walkers.walk(90.0, leave=lambda rows: rows[:, 0] > 24)


@case(
    "RiMEA 9",
    question="Does a large room take twice the time to empty if two of its four"
    " exits of 1 m are closed? It is a quarter of the room of the guideline,"
    " with 160 people in 10 x 10 m, each assigned to the nearest exit.",
    expected="1.5 to 2.5 times as long, and all leave",
    accepts=lambda it: (
        it["two"] < np.inf and 1.5 <= it["two"] / it["four"] <= 2.5
    ),
    shown="{four:.1f} s by four, {two:.1f} s by two",
)
def exits_of_large_room(setting: Setting) -> Numbers:
    """Measures when the last person leaves by four exits, and by two."""
    people = 60 if setting.quick else 160
    starts = spread(
        people, Area(0.3, 0.6, 9.7, 9.4), setting.generator("large room")
    )
    return {
        name: _empty(setting, starts, doors)
        for name, doors in (
            ("four", [(10, 2.5), (10, 7.5), (0, 2.5), (0, 7.5)]),
            ("two", [(10, 2.5), (10, 7.5)]),
        )
    }


def _empty(
    setting: Setting, starts: Array, doors: list[tuple[int, float]]
) -> float:
    """Returns when the last person leaves a room of 10 x 10 m by its doors."""
    walls = [wall(-0.2, -0.2, 10.2, 0), wall(-0.2, 10, 10.2, 10.2)]
    for side, left in ((0, -0.2), (10, 10.0)):
        heights = sorted(y for x, y in doors if x == side)
        edges = [0.0, *(heights[i] + 2.5 for i in range(len(heights))), 10.0]
        if not heights:
            walls.append(wall(left, 0, left + 0.2, 10))
        for y, low in zip(heights, edges[:-1], strict=False):
            high = edges[edges.index(low) + 1]
            walls += gap_in_wall(left, low, high, y, 1.0)
    exits = np.array(doors, dtype=float)
    outside = exits + np.where(exits[:, :1] > 5, [[20.0, 0]], [[-20.0, 0]])
    offset = starts[:, None] - exits
    nearest = np.argmin(np.hypot(offset[..., 0], offset[..., 1]), axis=1)
    walkers = Walkers(setting, starts, outside[nearest], walls=walls)
    walk = walkers.walk(
        60 + len(starts) / len(doors),
        leave=lambda rows: abs(rows[:, 0] - 5) > 9,
        patience=_PATIENCE,
    )
    return float(walk.first_time(abs(walk.x - 5) > 5.2).max())


CASES = (
    door_flow,
    bottleneck_width,
    bottleneck_length,
    regulated_flow,
    congestion_at_neck,
    exits_of_large_room,
    faster_is_slower,
    intermittent_flow,
)
