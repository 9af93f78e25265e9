"""The settings that an import of HuNavSim's files ignores."""

from collections.abc import Iterable
from dataclasses import dataclass

from hunav_drake.scenario.error import Fault, Loc, path_text

# The number of people named in a line.
_MOST_NAMES = 5


@dataclass(frozen=True)
class LeftOut(Fault):
    """A setting that was not imported, or assumed.

    Attributes:
        loc: Its path in the parameters of the file's node; for people, it
            starts with the name.
    """

    loc: Loc = ()


def group_notes(left_out: Iterable[LeftOut]) -> list[str]:
    """Returns a line for each kind of setting, with the affected people."""
    groups: dict[tuple[str, str, bool, str], list[LeftOut]] = {}
    for it in left_out:
        is_own = len(it.loc) > 1
        key = it.source, str(it.loc[-1]), is_own, it.message
        groups.setdefault(key, []).append(it)
    return [
        str(own[0]) if len(own) == 1 else _line(own) for own in groups.values()
    ]


def _line(own: list[LeftOut]) -> str:
    first = own[0]
    ways = {it.loc[1:] for it in own}
    # Goals have different names.
    way = first.loc[1:] if len(ways) == 1 else first.loc[-1:]
    names = list(dict.fromkeys(str(it.loc[0]) for it in own))
    more = len(names) - _MOST_NAMES
    told = ", ".join(names[:_MOST_NAMES]) + f" and {more} more" * (more > 0)
    return f"{first.place}: {path_text(None, way)} of {told}: {first.message}"
