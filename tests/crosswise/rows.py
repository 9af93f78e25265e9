"""Rows of levels in which each pair of levels is at least once."""

from collections.abc import Iterator
from functools import cache
from itertools import combinations
import random

from tests.crosswise.factors import (
    Row,
    applies,
    factors,
    refusal,
    refused_parts,
)

Level = tuple[str, str]
Pair = frozenset[Level]

# How many rows are tried for each that is taken.
_TRIES = 4


def covered(row: Row) -> Iterator[Pair]:
    """Yields the pairs of levels that a row tries."""
    levels = [(path, row[path]) for path in row if applies(path, row)]
    yield from map(frozenset, combinations(levels, 2))


def all_pairs() -> list[Pair]:
    """Returns each pair of levels that is possible, and not refused."""
    levels = [(path, it) for path in factors() for it in factors()[path].levels]
    return [
        frozenset((one, other))
        for one, other in combinations(levels, 2)
        if one[0] != other[0] and _least_row([one, other])
    ]


def pair_rows() -> list[Row]:
    """Returns rows that have each pair, greedily as few as it can.

    Each begins with a pair that is still missing, and takes level after level
    which brings the most of those that are. The rows are always the same.
    """
    chance = random.Random(0)
    missing = dict.fromkeys(all_pairs())
    # Of each level, those that it is missing with.
    partners: dict[Level, set[Level]] = {}
    for one, other in map(tuple, missing):
        partners.setdefault(one, set()).add(other)
        partners.setdefault(other, set()).add(one)
    rows = []
    while missing:
        begin = _least_row(sorted(next(iter(missing))))
        tries = [_filled(begin, partners, chance) for _ in range(_TRIES)]
        row = max(tries, key=lambda it: len(missing.keys() & set(covered(it))))
        rows.append(row)
        for pair in missing.keys() & set(covered(row)):
            del missing[pair]
            one, other = pair
            partners[one].discard(other)
            partners[other].discard(one)
    return rows


def _filled(
    begin: Row, partners: dict[Level, set[Level]], chance: random.Random
) -> Row:
    """Returns a row that begins so, with levels that bring the most."""
    row = dict(begin)
    paths = [path for path in factors() if path not in row]
    chance.shuffle(paths)
    # What others hang on comes first.
    for path in sorted(paths, key=lambda it: bool(factors()[it].owners)):
        present = set(row.items())

        def gain(level: Level, present: set[Level] = present) -> int:
            own = len(partners.get(level, set()) & present)
            return own + sum(
                max(gain((child, it)) for it in factors()[child].levels)
                for child in _owned().get(level, ())
            )

        row[path] = max(
            (
                it
                for it in factors()[path].levels
                if not refusal(row | {path: it})
            ),
            key=lambda it: gain((path, it)),
        )
    return row


@cache
def _owned() -> dict[Level, list[str]]:
    """Returns the factors that apply with a level, by level."""
    found: dict[Level, list[str]] = {}
    for path, factor in factors().items():
        for owner in factor.owners:
            found.setdefault(owner, []).append(path)
    return found


def refused_rows() -> list[Row]:
    """Returns a row for each part of one that is refused by rule."""
    rest = {path: it.levels[0] for path, it in factors().items()}
    return [
        rest | next(_with_owners(list(part.items()), {}))
        for part in refused_parts()
    ]


def random_rows(count: int, seed: int) -> Iterator[Row]:
    """Yields rows drawn from all that are possible."""
    chance = random.Random(seed)
    for _ in range(count):
        yield {path: chance.choice(it.levels) for path, it in factors().items()}


def _least_row(levels: list[Level]) -> Row:
    """Returns a part of a row with some levels; empty if there is none."""
    rows = (it for it in _with_owners(levels, {}) if not refusal(it))
    return next(rows, {})


def _with_owners(levels: list[Level], row: Row) -> Iterator[Row]:
    """Yields the least rows with some levels, and all that these hang on."""
    if not levels:
        yield row
        return
    (path, level), *rest = levels
    if row.get(path, level) != level:
        return
    row = row | {path: level}
    owners = sorted(factors()[path].owners)
    for more in [[it] for it in owners] or [[]]:
        yield from _with_owners([*more, *rest], row)
