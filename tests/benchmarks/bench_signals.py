"""What signals cost: ten nodes that take notice of them, and ten that do not.

Both are trees of people who walk; all are ticked by one system.
"""

import math
import time

from tests.vocabulary.stage import DT, Stage, robot_at, someone

SOCIAL = (
    "LookAtRobot",
    'SaySomething message="hello there"',
    'IsLookingAtMe target_id="{}" duration="0.05"',
    'IsSpeaking target_id="{}" duration="0.05"',
)
PLAIN = (
    'IsRobotVisible distance="50"',
    "IsGoalReached",
    'IsRobotClose threshold="0.1"',
    'IsAgentClose target_agent_id="{}" threshold="0.1"',
)
COUNTS = (5, 25, 100)
# How many times faster than real time 100 people with signals are to be.
WANTED = 60.0
_STEPS = 60


def ten_nodes(leaves: tuple[str, ...], other: int) -> str:
    """Returns ten nodes with four leaves, all of which are ticked."""
    each = (f"<ForceFailure><{it}/></ForceFailure>" for it in leaves)
    nodes = "".join(each).format(other, other)
    return f"<ForceFailure><Fallback>{nodes}</Fallback></ForceFailure>"


def make_people(leaves: tuple[str, ...], count: int) -> Stage:
    """Returns people who walk to and fro, 2 m apart."""
    side = math.ceil(math.sqrt(count))
    people = []
    for i in range(count):
        x, y = 2.0 * (i % side), 2.0 * (i // side)
        nodes = ten_nodes(leaves, (i + 1) % count + 1)
        goals = [(x + 30, y), (x - 30, y)]
        people.append(someone(x, y, 0.1 * i, nodes, goals=goals, cyclic=True))
    return Stage(people, robot=robot_at(-3, 0, 0, 0.1), separate_trees=False)


def seconds_per_step(count: int) -> tuple[float, float]:
    """Returns the time of a step with signals, and without, in turns."""
    stages = [make_people(it, count) for it in (SOCIAL, PLAIN)]
    best = [math.inf, math.inf]
    for stage in stages:
        for _ in stage.run(1.0):
            pass
    for _ in range(6):
        for k, stage in enumerate(stages):
            started = time.process_time()
            for _ in range(_STEPS):
                stage.step()
            best[k] = min(best[k], (time.process_time() - started) / _STEPS)
    return best[0], best[1]


def main() -> None:
    """Prints the table."""
    print("A step of people with trees of ten nodes, in us")
    print("people  signals  without  ratio  times real time  wanted")
    for count in COUNTS:
        social, plain = seconds_per_step(count)
        print(
            f"{count:6} {1e6 * social:8.0f} {1e6 * plain:8.0f}"
            f" {social / plain:6.2f} {DT / social:16.0f}"
            f" {WANTED if count == 100 else 0:7.0f}"
        )


if __name__ == "__main__":
    main()
