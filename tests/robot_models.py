"""Models of robots, and meshes that they may name, sound and broken."""

from pathlib import Path

from tests.systems.robot.crate import CRATE, FOOTPRINT, STAGES

PMB2 = Path(__file__).parents[1] / "systems/robot/models/pmb2.sdf"

# Each model with its base and its drive.
ROBOTS = {
    "crate.urdf": (CRATE, "chassis", {"type": "omnidirectional"}),
    "turtle.urdf": (
        FOOTPRINT,
        "base_link",
        {
            "left_wheel": "left_joint",
            "right_wheel": "right_joint",
            "wheel_separation": 0.3,
            "wheel_radius": 0.08,
        },
    ),
    "stages.urdf": (
        STAGES,
        "chassis",
        {"type": "omnidirectional", "x": "along_x", "y": "along_y"}
        | {"yaw": "turn"},
    ),
    "pmb2.sdf": (
        PMB2.read_text(),
        "base",
        {
            "left_wheel": "left_wheel_joint",
            "right_wheel": "right_wheel_joint",
            "wheel_separation": 0.4044,
            "wheel_radius": 0.0985,
        },
    ),
}

TENT = (
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
)
FILES = {
    "part.obj": TENT,
    "part.stl": "solid part\nendsolid part\n",
    "part.dae": "<COLLADA/>",
    "broken.obj": "v 0 0\nf 1 2 9\n",
    "flat.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n",
    "empty.obj": "",
    "broken.gltf": '{"asset":',
}
