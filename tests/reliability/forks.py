"""Whether a trial that goes on from a clone ends as the one that ran through.

`python -m tests.reliability.forks --duration 20` tries all scenarios with all
planners and all robots, at instants all over the trial and inside its last
step, and prints where a fork differs.
"""

import argparse
from collections.abc import Iterator
import itertools
import math

import numpy as np

from hunav_drake import (
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
)
from hunav_drake.scenario import Scenario, ScenarioError
from hunav_drake.scenarios import shipped_names
from tests.planners import NAMES, planner_override

ROBOTS = ("differential_drive", "pmb2")

# Parts of the last step.
_LAST = (0.02, 0.5, 0.999)


def load_trial(
    name: str, planner: str, robot: str, duration: float
) -> Scenario | None:
    """Returns a shipped scenario with other parts; None if that is refused."""
    changes = [
        planner_override(planner),
        f"robot.type={robot}",
        f"simulation.duration={duration}",
    ]
    try:
        return LoadScenario(filename=name, overrides=changes)
    except ScenarioError:
        return None


def differing_forks(scenario: Scenario, seed: int = 0) -> Iterator[str]:
    """Yields where the forks of a trial end otherwise than it does."""
    step = scenario.simulation.time_step
    diagram = MakeTrialDiagram(scenario)
    rng = np.random.default_rng(seed)
    whole = MakeTrialSimulator(diagram)
    whole.AdvanceTo(scenario.simulation.duration)
    end = whole.get_context().get_time()
    expected = GetTrialResult(scenario, diagram, whole.get_context())
    last = end - step
    anywhere = rng.uniform(0, max(last, 0), 2)
    on_a_step = step * math.floor(rng.uniform(0, end) / step)
    times = sorted(
        {0.0, *anywhere, on_a_step, *(last + part * step for part in _LAST)}
    )
    first = MakeTrialSimulator(diagram)
    for time in times:
        first.AdvanceTo(time)
        fork = MakeTrialSimulator(diagram, first.get_context().Clone())
        fork.AdvanceTo(scenario.simulation.duration)
        result = GetTrialResult(scenario, diagram, fork.get_context())
        for what, is_same in (
            ("end", fork.get_context().get_time() == end),
            ("recording", result.recording == expected.recording),
            ("end reason", result.end_reason == expected.end_reason),
            ("metrics", result.metrics.equals(expected.metrics)),
        ):
            if not is_same:
                yield f"forked at {time!r} s: another {what}"


def main() -> None:
    """Tries all, and prints what differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--duration", type=float, default=3.0)
    parser.add_argument("--scenario", nargs="+", default=shipped_names())
    parser.add_argument("--planner", nargs="+", default=NAMES)
    parser.add_argument("--robot", nargs="+", default=ROBOTS)
    options = parser.parse_args()
    tried = refused = differing = 0
    for names in itertools.product(
        options.scenario, options.planner, options.robot
    ):
        scenario = load_trial(*names, options.duration)
        if scenario is None:
            refused += 1
            continue
        tried += 1
        faults = list(differing_forks(scenario))
        differing += bool(faults)
        for fault in faults:
            print(*names, fault, flush=True)
    print(
        f"{tried} trials, of which the forks of {differing} differ;"
        f" {refused} are refused"
    )


if __name__ == "__main__":
    main()
