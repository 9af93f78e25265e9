"""All that is not as in HuNavSim, on purpose, and why: the one list of it."""

from collections.abc import Iterable, Mapping
import dataclasses as dc
from types import MappingProxyType
from typing import Any

from hunav_drake.hunavsim.metric_differences import METRIC_ROWS
from hunav_drake.hunavsim.people_differences import PEOPLE_ROWS
from hunav_drake.hunavsim.row import Area, Difference

DIFFERENCES: tuple[Difference, ...] = (*PEOPLE_ROWS, *METRIC_ROWS)

# What the areas are called, in order.
AREAS: Mapping[Area, str] = MappingProxyType(
    {
        "forces": "Forces and walls",
        "behaviors": "Behaviors and goals",
        "steps": "Steps and numbers",
        "services": "Services and files",
        "metrics": "Metrics",
    }
)

# The areas that the profile is about.
PROFILE_AREAS: tuple[Area, ...] = ("forces", "behaviors", "steps")

# Of the metrics whose value differs, why.
METRIC_REASONS: Mapping[str, str] = MappingProxyType(
    {
        name: f"HuNavSim: {row.original}; here: {row.here}"
        for row in METRIC_ROWS
        if not row.series
        for name in row.metrics
    }
)


def differences_of_metric(name: str) -> list[Difference]:
    """Returns how a metric, or its series, differs from HuNavSim's."""
    return [row for row in METRIC_ROWS if name in row.metrics]


def left_by_profile() -> list[Difference]:
    """Returns what differs in how people move even with the profile."""
    return [
        row
        for row in DIFFERENCES
        if row.area in PROFILE_AREAS and not row.by_profile
    ]


def as_data(rows: Iterable[Difference] = DIFFERENCES) -> list[dict[str, Any]]:
    """Returns differences as plain data, for JSON."""
    return [dc.asdict(row) for row in rows]


def as_text(rows: Iterable[Difference] = DIFFERENCES) -> str:
    """Returns differences as text, for a terminal."""
    lines: list[str] = []
    area: Area | None = None
    for row in rows:
        if row.area != area:
            area = row.area
            lines += ["", AREAS[area], ""] if lines else [AREAS[area], ""]
        lines += [
            f"  {row.name}",
            f"    HuNavSim  {row.original}",
            f"    here      {row.here}",
            f"    why       {row.why}",
            f"    undo      {_undo(row)}",
        ]
    return "\n".join(lines)


def as_markdown(rows: Iterable[Difference] = DIFFERENCES) -> str:
    """Returns the page `docs/hunavsim.md`."""
    rows = list(rows)
    parts = [_INTRODUCTION]
    parts.append(_table(left_by_profile(), undo=False))
    for area, title in AREAS.items():
        chosen = [row for row in rows if row.area == area]
        parts.append(f"## {title}\n\n{_table(chosen, undo=area != 'metrics')}")
    return "\n".join(parts)


def _undo(row: Difference) -> str:
    words = [row.key] if row.key else []
    if row.by_profile:
        words.append("profile hunavsim")
    return " or ".join(words) or "nothing"


def _table(rows: Iterable[Difference], *, undo: bool) -> str:
    heads = ["what", "HuNavSim", "here", "why"] + ["undone by"] * undo
    lines = [heads, ["---"] * len(heads)]
    for row in rows:
        cells = [row.name, row.original, row.here, row.why]
        if undo:
            keys = [f"`{row.key}`"] if row.key else []
            keys += ["the profile"] * row.by_profile
            cells.append(", ".join(keys) or "nothing")
        lines.append(cells)
    return "".join(
        f"| {' | '.join(cell.replace('|', r'\|') for cell in line)} |\n"
        for line in lines
    )


_INTRODUCTION = """\
# HuNavSim, and what differs from it

`hunav differences --markdown` writes this page; `hunav differences` prints the
list, `--json` as data.

## As in HuNavSim, by one switch

```yaml
crowd: {profile: hunavsim}
```

or `CrowdConfig(profile="hunavsim")` for `AddHumans`, `MakeHumans` and
`AgentServices`, or `--set crowd.profile=hunavsim`. Forces, walls, behaviors and
goals are then HuNavSim's. `systems/people/profile.py` is the table of values,
and `systems/behavior/hunavsim/` has the leaves and trees. A key that is given
beside the profile counts. In trees of one's own, too, the names of HuNavSim's
leaves mean what they mean there; only whether `RegularNav` feels the robot
follows from the tree here: write `ignore_robot="true"` for who could react.

People who walk from their start to the end of the recorded runs of HuNavSim,
without being put back, are where they are there, bit for bit: regular and
impassive people, groups, walls, each reaction alone, and six people with six
behaviors for 60 s. `tests/hunav_drake/hunavsim/test_profile.py` holds this. The
profile is for comparisons: its people are not better ones. This is left:
"""
