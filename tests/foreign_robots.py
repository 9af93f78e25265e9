"""Drives public robots from their own files: python -m tests.foreign_robots.

The folder that is given holds copies of their repositories.
"""

import math
from pathlib import Path
import sys

import numpy as np

from hunav_drake.systems.common.models.apart import ModelFault
from hunav_drake.systems.robot import ROBOTS
from tests.systems.robot.driven_robots import drive, make_diagram


def _wheels(left, right, separation, radius):
    return {
        "left_wheel": left,
        "right_wheel": right,
        "wheel_separation": separation,
        "wheel_radius": radius,
    }


_TURTLE = ("wheel_left_joint", "wheel_right_joint")
_PMB2 = _wheels(*_TURTLE, 0.4044, 0.0985)

# The file, the base and the drive of each, and further settings.
ROBOT_FILES = {
    **{
        f"turtlebot3_{name}": (
            f"turtlebot3/turtlebot3_description/urdf/turtlebot3_{name}.urdf",
            "base_footprint",
            _wheels(*_TURTLE, separation, 0.033),
            {"limits": {"max_speed": 0.26}},
        )
        for name, separation in (
            ("burger", 0.16),
            ("waffle", 0.288),
            ("waffle_pi", 0.288),
        )
    },
    "jackal": (
        "jackal/jackal_description/urdf/jackal.urdf.xacro",
        "base_link",
        _wheels(
            ["front_left_wheel", "rear_left_wheel"],
            ["front_right_wheel", "rear_right_wheel"],
            0.37559,
            0.098,
        ),
        {},
    ),
    "pmb2": (
        "pmb2_robot/pmb2_description/robots/pmb2.urdf.xacro",
        "base_footprint",
        _PMB2,
        {},
    ),
    "tiago": (
        "tiago_robot/tiago_description/robots/tiago.urdf.xacro",
        "base_footprint",
        _PMB2,
        {"arguments": {"arm": "no-arm", "end_effector": "no-end-effector"}},
    ),
}


def drive_file(folder, name, packages=None):
    """Yields rows of commanded and reached (v, omega) of a robot."""
    file, base, wheels, more = ROBOT_FILES[name]
    robot = {
        "type": "urdf",
        "file": str(folder / file),
        "base": base,
        "drive": wheels,
        "packages": packages or {},
        **more,
    }
    for _, message in ROBOTS.make(robot).find_faults():
        raise ModelFault(("file",), message)
    diagram = make_diagram(robot)
    for command in ((0.2, 0.0), (0.0, 1.0), (0.15, 0.5), (-0.1, -0.5)):
        run = drive(diagram, command, duration=4.0)
        _, _, yaw, vx, vy, omega, _ = run.robot[run.times > 2].T
        speed = np.mean(vx * np.cos(yaw) + vy * np.sin(yaw))
        yield command, (float(speed), float(np.mean(omega)))


def main() -> int:
    """Prints a line for each robot and command."""
    folder = Path(sys.argv[1])
    packages = dict(it.split("=") for it in sys.argv[2:])
    worst = 0.0
    for name in ROBOT_FILES:
        try:
            for wanted, got in drive_file(folder, name, packages):
                worst = max(worst, math.dist(wanted, got))
                print(
                    f"{name}: commanded {wanted}, reached"
                    f" ({got[0]:.3f}, {got[1]:.3f})",
                    flush=True,
                )
        except ModelFault as fault:
            print(f"{name}: {fault}", flush=True)
    print(f"off by at most {worst:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
