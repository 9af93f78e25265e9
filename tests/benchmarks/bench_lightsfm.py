"""What a step of people costs, beside the original's library lightsfm.

All figures are of one run on one machine: compare the ratios. The environment
variable HUNAV_LIGHTSFM names the folder of lightsfm's headers (sfm.hpp, ...),
which need Boost's (Debian: libboost-dev); without it there are no ratios.
"""

import math
import os
from pathlib import Path
import subprocess
import tempfile

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.crowd import CrowdConfig
from tests.benchmarks.bench_crowd import (
    TIME_STEP,
    drake_step,
    kernel_step,
    simulate,
    walking_snapshot,
    walking_states,
)

PEOPLE = (5, 20, 50, 100, 200, 500, 1000, 2000)
DENSITY = 0.25
BEHAVIORS = (
    *("regular", "impassive", "surprised"),
    *("scared", "curious", "threatening"),
)


def compile_lightsfm(headers: str, folder: Path) -> Path:
    """Compiles the program that times lightsfm; returns its path."""
    program = folder / "lightsfm"
    source = Path(__file__).with_name("lightsfm.cpp")
    flags = ["-O3", "-march=native", "-std=c++17", f"-I{headers}"]
    subprocess.run(["g++", *flags, source, "-o", program], check=True)
    return program


def lightsfm_step(program: Path, n: int) -> float:
    """Returns the seconds of a step of lightsfm, the fastest of three runs."""
    steps = max(3, min(20_000, 2_000_000 // n**2))
    rows = walking_states(n, DENSITY)[:, [0, 1, 3, 4]]
    text = "\n".join(" ".join(map(repr, row)) for row in rows.tolist())
    told = [
        subprocess.run(
            [program],
            input=f"{n} {steps}\n{text}\n",
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for _ in range(3)
    ]
    return min(float(line.split()[0]) for line in told)


def trees_step(n: int, behaviors: tuple[str, ...]) -> float:
    """Returns the seconds of a step of a crowd with everybody's tree.

    The robot stands in the middle of the people.
    """
    humans = [
        HumanConfig(
            pose=(x, y, 0.0),
            goals=[(x + 50 * vx, y + 50 * vy)],
            behavior=behaviors[i % len(behaviors)],
        )
        for i, (x, y, vx, vy) in enumerate(
            walking_states(n, DENSITY)[:, [0, 1, 3, 4]].tolist()
        )
    ]
    builder = DiagramBuilder()
    ports = AddHumans(builder, humans, time_step=TIME_STEP)
    middle = np.mean([human.pose[:2] for human in humans], axis=0)
    robot = builder.AddSystem(ConstantVectorSource([*middle, 0, 0, 0, 0, 0.3]))
    builder.Connect(robot.get_output_port(), ports.robot_states)
    return simulate(Simulator(builder.Build()), n)


def main() -> None:
    """Prints the table."""
    headers = os.environ.get("HUNAV_LIGHTSFM")
    hunavsim = CrowdConfig(profile="hunavsim")
    with tempfile.TemporaryDirectory() as folder:
        program = compile_lightsfm(headers, Path(folder)) if headers else None
        print(
            "us per person and step"
            + " (times lightsfm)" * bool(program)
            + f", {DENSITY} persons/m^2, no walls"
        )
        names = ("kernel", "HumanCrowd", "hunavsim", "regular", "six behaviors")
        print("people  lightsfm " + "".join(f"{name:>17}" for name in names))
        for n in PEOPLE:
            snapshot = walking_snapshot(n, DENSITY)
            base = lightsfm_step(program, n) if program else math.nan
            steps = (
                kernel_step(snapshot, "fast"),
                drake_step(snapshot),
                drake_step(snapshot, hunavsim),
                trees_step(n, BEHAVIORS[:1]),
                trees_step(n, BEHAVIORS),
            )
            cells = [
                f"{1e6 * step / n:8.2f} "
                + (f"({step / base:6.3f})" if program else " " * 8)
                for step in steps
            ]
            print(f"{n:6} {1e6 * base / n:9.2f} {''.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
