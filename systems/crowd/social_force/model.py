"""The social force model, as HuNavSim uses it."""

from concurrent.futures import ThreadPoolExecutor
import functools
import os
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, StrictFloat
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.schema import CONFIG, Integer, within
from hunav_drake.systems.crowd.motion_model import (
    Array,
    MotionModel,
    Snapshot,
    register_motion_model,
)
from hunav_drake.systems.crowd.social_force import kernel, numpy_model
from hunav_drake.systems.crowd.social_force.fast_kernel import people_forces

# Fewer people are not worth the time that threads take to start.
_THREADS_FROM = 200


@register_motion_model("social_force")
@dataclass(kw_only=True, config=CONFIG)
class SocialForceModel(MotionModel):
    """Goal, walls, people, robots and groups push and pull.

    Helbing & Molnar 1995, Moussaid et al. 2009 and 2010, as in `lightsfm`.
    """

    # "fast" agrees with the others to rounding, and in a crowd to
    # `error_bound`; "reference" gives the numbers of the original bit for
    # bit; "numpy" needs no compiler.
    kernel: Literal["fast", "reference", "numpy"] = "fast"

    # From 48 people on, the fast kernel leaves out what adds up to less than
    # this for each person, in m/s^2; 0 leaves nothing out.
    error_bound: Annotated[StrictFloat, within(0, 1, "m/s^2")] = 1e-6

    # In how many threads the fast kernel computes the forces between people,
    # from 200 people on. The result depends on their number in its last
    # digits. Where the cores are busy with other trials, one is the best.
    threads: Annotated[Integer, Field(ge=1, le=256)] = 1

    def forces(self, snapshot: Snapshot) -> Array:
        """Returns the forces: see `MotionModel.forces`."""
        if self.kernel == "numpy":
            return numpy_model.social_forces(snapshot)
        arguments = (
            snapshot.states,
            snapshot.radii,
            snapshot.command,
            snapshot.parameters,
            snapshot.robots,
            snapshot.at_walls,
            snapshot.obstacles.table,
            snapshot.obstacle_range,
            snapshot.max_obstacles,
        )
        forces: Array
        if self.kernel == "fast":
            forces = kernel.fast_social_forces(
                *arguments, self.error_bound, self._in_threads(snapshot)
            )
        else:
            forces = kernel.social_forces(*arguments)
        return forces

    def advance(self, snapshot: Snapshot, forces: Array) -> Array:
        """Returns the next states: see `MotionModel.advance`."""
        if self.kernel == "numpy":
            return numpy_model.advance(snapshot, forces)
        states: Array = kernel.advance(
            snapshot.states, forces, snapshot.command, snapshot.time_step
        )
        return states

    def _in_threads(self, snapshot: Snapshot) -> Array:
        """Returns the forces between people if threads are to compute them."""
        if self.threads == 1 or len(snapshot.states) < _THREADS_FROM:
            return kernel.NOT_GIVEN
        part = functools.partial(
            people_forces,
            snapshot.states,
            snapshot.parameters,
            self.error_bound,
        )
        results = _threads(self.threads).map(
            part, range(self.threads), [self.threads] * self.threads
        )
        # In the order of the parts, so that the sum is always the same.
        total: Array = np.add.reduce(list(results))
        return total


@functools.cache
def _threads(count: int) -> ThreadPoolExecutor:
    """Returns threads that wait for work until the process ends."""
    return ThreadPoolExecutor(count, thread_name_prefix="crowd")


# Threads are not forked: the child of a fork starts its own.
os.register_at_fork(after_in_child=_threads.cache_clear)
