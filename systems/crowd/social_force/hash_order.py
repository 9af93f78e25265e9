"""The order in which HuNavSim processes people: that of a hash table.

It keeps them in a `std::unordered_map` by their numbers. This is the order of
GCC's: the elements are one chain, in which those of a bucket, the number modulo
the number of buckets, are adjacent. A new one comes to the front of its bucket
or, if that is empty, of the chain.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

# The numbers of buckets of a table as it grows, which it does when there are
# more elements: the primes that follow double the last one, in GCC's list.
_BUCKETS = (
    *(13, 29, 59, 127, 257, 541, 1109, 2357, 5087, 10273, 20753, 42043),
    *(85229, 172933, 351061),
)


def hash_order(ids: Sequence[int]) -> NDArray[np.intp]:
    """Returns the rows of people in the order of such a table.

    Args:
        ids: Their numbers, all different, in the order in which they are put
            into it. The table does not grow beyond 351061 people here.
    """
    chain = _Chain(ids, _BUCKETS[0])
    for row in range(len(ids)):
        if row in _BUCKETS[:-1]:
            larger = _BUCKETS[_BUCKETS.index(row) + 1]
            chain = _Chain(ids, larger, chain.rows())
        chain.insert(row)
    return np.array(list(chain.rows()), dtype=np.intp)


class _Chain:
    """A linked list of rows; -1 is before the first."""

    def __init__(
        self, ids: Sequence[int], buckets: int, rows: Iterable[int] = ()
    ) -> None:
        self._ids = ids
        self._buckets = buckets
        self._next: dict[int, int | None] = {-1: None}
        # By bucket, the row before its first row.
        self._before: dict[int, int] = {}
        for row in rows:
            self.insert(row)

    def insert(self, row: int) -> None:
        bucket = self._bucket(row)
        before = self._before.setdefault(bucket, -1)
        after = self._next[before]
        self._next[row] = after
        self._next[before] = row
        if before == -1 and after is not None:
            other = self._bucket(after)
            if other != bucket:
                self._before[other] = row

    def rows(self) -> Iterable[int]:
        row = self._next[-1]
        while row is not None:
            yield row
            row = self._next[row]

    def _bucket(self, row: int) -> int:
        return self._ids[row] % self._buckets
