"""Compiles the kernels of a trial in several processes, at its first run."""

from collections.abc import Iterator
import contextlib
import importlib
import os
import warnings

from hunav_drake.runs.worker_pool import WorkerPool
from hunav_drake.scenario import Scenario
from hunav_drake.scenario.fleet import planners_of

# The large kernels of trials, in the order in which processes begin them: what
# takes long first, and last what the trial itself compiles first. Names that
# are missing here are compiled when they are used.
_STEPS = {
    "hunavsim": "crowd.bodies.hunavsim_step.hunavsim_step",
    "fast": "crowd.bodies.whole_step.whole_step",
}
_AMONG_WALLS = (
    "world.waypoints.guided",
    "crowd.bodies.taking_turns.take_turns",
    "crowd.walls.passages.ease",
    "crowd.bodies.passing_robots.pass_robots",
    "crowd.bodies.adaptation._adapted",
)
_PLANNERS = {
    "dwb": ("planning.dwb.weighing.weigh_samples",),
    "mppi": ("planning.mppi.improving.improve",),
    "orca": ("planning.social.reciprocal.avoiding_velocity",),
    "scl": (
        "planning.dwb.weighing.weigh_samples",
        "planning.costmap.social_layer.add_people",
    ),
    "sfm": ("planning.social.forces.robot_force",),
    "sfw": ("planning.social.prediction.candidate_costs",),
}
_MAPS = (
    "planning.costmap.raster.stamp_discs",
    "planning.global_planner.navfn_kernel.navfn_potential",
    "planning.global_planner.navfn_kernel.navfn_descent",
    "planning.costmap.raster.mark_walls",
)
_ALL = (
    "robot.disc_step.drive_disc",
    "crowd.walls.keep_out.keep_out_of_walls",
    "crowd.bodies.keep_apart.keep_apart",
    "crowd.bodies.finish.finish",
    "robot.discs.touch_discs",
    "world.visibility_graph.blocked",
    "world.nearest.nearest_on_walls",
    "world.nearest.inside_shapes",
    "behavior.nodes.walk_kernel.walk",
)

# More processes than this would mostly wait for each other.
_MOST_PROCESSES = 4


def kernels_of(scenario: Scenario) -> list[str]:
    """Returns the names of the large kernels that a trial needs."""
    model = scenario.crowd.model
    step = _STEPS.get(getattr(model, "kernel", ""))
    names = [step] if step else []
    is_empty = scenario.world == type(scenario.world)()
    if scenario.crowd.route_planning and not is_empty:
        names += _AMONG_WALLS
    for planner in planners_of(scenario).split("+"):
        chosen = _PLANNERS.get(planner, ())
        names += [*chosen, *_MAPS] if chosen else ()
    return list(dict.fromkeys([*names, *_ALL]))


@contextlib.contextmanager
def compiling_ahead(scenario: Scenario) -> Iterator[None]:
    """Compiles kernels of a trial in other processes while a block runs.

    The processes end with the block. With one processor there are none.
    """
    processes = min((os.cpu_count() or 1) - 1, _MOST_PROCESSES)
    if processes < 1:
        yield
        return
    pool = WorkerPool(processes)
    try:
        for name in kernels_of(scenario):
            pool.submit(compile_ahead, name)
        yield
    finally:
        pool.end_now()


def compile_ahead(name: str) -> None:
    """Compiles one kernel, unless another process does so already.

    What there is to warn of is the trial's to tell.

    Args:
        name: Its name in `hunav_drake.systems`.
    """
    module, _, kernel = f"hunav_drake.systems.{name}".rpartition(".")
    found = getattr(importlib.import_module(module), kernel)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found.compile_once(waits=False)
