"""Compiles the kernels of a trial in several processes, at its first run."""

from collections.abc import Iterable, Iterator
import contextlib
import functools
import importlib
import os
import subprocess
import sys
from typing import Any

from hunav_drake.scenario import Scenario
from hunav_drake.scenario.fleet import planners_of
from hunav_drake.systems.common.kernels import keeps_code, meanwhile
from hunav_drake.systems.common.registry import name_of

# The large kernels of trials, in the order in which processes begin them: what
# takes long first, and last what the trial itself compiles first. Names that
# are missing here are compiled when they are used.
_MODELS = {
    "orca": "orca.model.orca_accelerations",
    "anticipation_velocity": "anticipation_velocity.anticipated_velocities",
    "collision_free_speed": "collision_free_speed.collision_free_speeds",
}
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
    "world.visibility_graph.free_points",
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
    "planning.global_planner.navfn_kernel.navfn_potential",
    "planning.global_planner.navfn_kernel.navfn_descent",
    "planning.costmap.raster.mark_walls",
    "planning.costmap.raster.stamp_discs",
)
_CLEARANCE = ("planning.clearance.clearance_ahead",)
_LIDAR = "sensing.ray_kernels.ray_distances"
# Of social forces.
_BODIES = ("crowd.bodies.keep_apart.keep_apart", "crowd.bodies.finish.finish")
_ALL = (
    "robot.disc_step.drive_disc",
    "robot.contact_rows.count_contacts",
    "crowd.walls.keep_out.keep_out_of_walls",
    "robot.discs.touch_discs",
    "world.visibility_graph.blocked",
    "world.nearest.nearest_on_walls",
    "world.nearest.inside_shapes",
    "world.nearest.nearest_on_shapes",
    "evaluation.curves.lines_blocked",
    "evaluation.curves.total_winding",
    "behavior.nodes.walk_kernel.walk",
)

# More processes than this would mostly wait for each other.
_MOST_PROCESSES = 4


def kernels_of(scenario: Scenario, planners: Iterable[str] = ()) -> list[str]:
    """Returns the names of the large kernels that a trial needs.

    `planners` are the names of others that it may have, too.
    """
    model = scenario.crowd.model
    names: list[str] = []
    # (With people who come and go, other functions are compiled.)
    if name_of(model) in _MODELS:
        names.append(f"crowd.{_MODELS[name_of(model)]}")
    elif (step := _STEPS.get(getattr(model, "kernel", ""))) is not None:
        names += [] if scenario.population.sources else [step, *_BODIES]
    is_empty = scenario.world == type(scenario.world)()
    if scenario.crowd.route_planning and not is_empty:
        names += _AMONG_WALLS
    for planner in (*planners_of(scenario).split("+"), *planners):
        if planner in _PLANNERS:
            names += [*_PLANNERS[planner], *_MAPS]
        else:
            names += _CLEARANCE
    if scenario.sensors:
        names.append(_LIDAR)
    return list(dict.fromkeys([*names, *_ALL]))


@contextlib.contextmanager
def compiling_ahead(
    scenario: Scenario, planners: Iterable[str] = ()
) -> Iterator[None]:
    """Compiles `kernels_of` a trial in other processes while a block runs.

    This process compiles them, too, when it has to wait for another one. The
    processes end with the block. There are none with one processor, where
    compiled code cannot be kept on disk, or where no process can be started.
    """
    names = kernels_of(scenario, planners)
    count = min(_num_processors() - 1, _MOST_PROCESSES) if keeps_code() else 0
    # (Ctrl-C ends the block, and so the processes.)
    start = functools.partial(
        subprocess.Popen,
        [sys.executable, "-P", "-m", __name__, *names],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        start_new_session=True,
    )
    processes: list[Any] = []
    try:
        with contextlib.suppress(OSError):
            for _ in range(count):
                processes.append(start())
        meanwhile.extend(functools.partial(compile_ahead, it) for it in names)
        yield
    finally:
        meanwhile.clear()
        for process in processes:
            process.kill()
            process.wait()


def _num_processors() -> int:
    """Returns the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def compile_ahead(name: str) -> None:
    """Compiles one kernel, unless another process does so already.

    Args:
        name: Its name in `hunav_drake.systems`.
    """
    module, _, kernel = f"hunav_drake.systems.{name}".rpartition(".")
    getattr(importlib.import_module(module), kernel).compile_once(waits=False)


if __name__ == "__main__":
    for _name in sys.argv[1:]:
        compile_ahead(_name)
