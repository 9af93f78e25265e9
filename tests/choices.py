"""What must be given of choices that have no default, for tests of all."""

from hunav_drake.systems.world.furniture import FURNITURE

SQUARE = [[8, 8], [9, 8], [9, 9]]
NEEDED = {
    "box": {"center": [8.5, 8.5], "size": [1, 1]},
    "polygon": {"points": SQUARE},
    "polyline": {"points": SQUARE},
    **{kind: {"center": [8.5, 8.5]} for kind in FURNITURE},
    "urdf": {
        "file": "package://hunav_drake/systems/robot/models/pmb2.sdf",
        "base": "base",
        "drive": {"type": "omnidirectional", "height": 0.01},
    },
    "differential": {
        "left_wheel": "left_wheel_joint",
        "right_wheel": "right_wheel_joint",
        "wheel_separation": 0.4,
        "wheel_radius": 0.1,
    },
}
