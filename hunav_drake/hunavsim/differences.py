"""The intended differences from HuNavSim, read from `differences.yaml`."""

from collections.abc import Iterable, Mapping
import dataclasses as dc
from importlib import resources
from types import MappingProxyType
from typing import Any, Literal

import yaml

Area = Literal["forces", "behaviors", "steps", "services", "metrics"]

# The titles of the areas, in order.
AREAS: Mapping[Area, str] = MappingProxyType(
    {
        "forces": "Forces and walls",
        "behaviors": "Behaviors and goals",
        "steps": "Steps and numbers",
        "services": "Services and files",
        "metrics": "Metrics",
    }
)

# The areas that the profile affects.
PROFILE_AREAS: tuple[Area, ...] = ("forces", "behaviors", "steps")


@dc.dataclass(frozen=True, kw_only=True)
class Difference:
    """An intended difference from HuNavSim.

    Attributes:
        area: The part of the program.
        name: Its name; by default, the names of its metrics.
        original: The behavior of HuNavSim.
        here: The behavior of this package.
        why: The reason.
        key: The setting of a scenario that undoes only this difference; empty
            if there is none.
        by_profile: Whether `crowd: {profile: hunavsim}` undoes it.
        metrics: The affected metrics.
        series: Whether only their time series differ, not their values.
    """

    area: Area
    name: str
    original: str
    here: str
    why: str
    key: str = ""
    by_profile: bool = False
    metrics: tuple[str, ...] = ()
    series: bool = False


def _read(file: str) -> str:
    return (resources.files(__package__) / file).read_text(encoding="utf-8")


def _read_differences() -> tuple[Difference, ...]:
    data = yaml.safe_load(_read("differences.yaml"))
    return tuple(
        Difference(
            area=area,
            **{"name": ", ".join(row.get("metrics", ()))}
            | row
            | {"metrics": tuple(row.get("metrics", ()))},
        )
        for area in AREAS
        for row in data[area]
    )


DIFFERENCES: tuple[Difference, ...] = _read_differences()

# The reasons of differences by metrics with other values.
METRIC_REASONS: Mapping[str, str] = MappingProxyType(
    {
        name: f"HuNavSim: {row.original}; here: {row.here}"
        for row in DIFFERENCES
        if not row.series
        for name in row.metrics
    }
)


def differences_of_metric(name: str) -> list[Difference]:
    """Returns the differences of a metric, or of its time series."""
    return [row for row in DIFFERENCES if name in row.metrics]


def left_by_profile() -> list[Difference]:
    """Returns the differences of motion that remain with the profile."""
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
    parts = [_read("differences.md")]
    parts.append(_table(left_by_profile(), undo=False))
    for area, title in AREAS.items():
        chosen = [row for row in rows if row.area == area]
        parts.append(f"## {title}\n\n{_table(chosen, undo=area != 'metrics')}")
    parts.append(_read("differences_end.md").removeprefix("\n"))
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
