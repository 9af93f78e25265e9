"""The connected components of a graph."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def connected_components(count: int, ends: ArrayLike) -> NDArray[np.int64]:
    """Returns the component of each node: 0, 1 ... by their first nodes.

    (SciPy has such a function, but to import it takes 0.3 s, for which each
    command would wait.)

    Args:
        count: The number of nodes.
        ends: The two nodes of each edge, shape (2, m).
    """
    one, other = np.asarray(ends, dtype=np.int64)
    label = np.arange(count)
    while True:
        low = np.minimum(label[one], label[other])
        lower = label.copy()
        for node in (one, other):
            # The label of a label follows, so that long chains end soon.
            np.minimum.at(lower, label[node], low)
            np.minimum.at(lower, node, low)
        lower = lower[lower]
        if (lower == label).all():
            return np.unique(label, return_inverse=True)[1]
        label = lower
