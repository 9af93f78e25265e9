"""The straight ways of a map, each found by itself."""

import numpy as np

from hunav_drake.systems.world.visibility_graph import blocked


def straight_ways(dut):
    """Returns rows (i, j, length), j < i, of vertices that see each other."""
    i, j = np.tril_indices(len(dut.vertices), -1)
    ends = dut.vertices[i], dut.vertices[j]
    seen = ~blocked(*ends, dut.sight, dut.obstacles.table)
    lengths = np.hypot(*(ends[0] - ends[1]).T)
    return np.column_stack([i, j, lengths])[seen]
