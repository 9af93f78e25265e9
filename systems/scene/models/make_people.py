"""Generates the parts of a person's figure, the OBJ files in this folder.

`python -m hunav_drake.systems.scene.models.make_people` writes them. They have
one size for all people, each in the frame of its body, x forward and z up, in
meters.
"""

from pathlib import Path

from hunav_drake.systems.people.legs import (
    SHIN_SECTIONS,
    SHOE_SECTIONS,
    THIGH_SECTIONS,
)
from hunav_drake.systems.scene.meshes import (
    TriangleMesh,
    ellipsoid,
    extrude,
    join,
    loft,
)

_HIPS = [
    [0.00, 0, -0.10, 0.060, 0.095],
    [-0.01, 0, -0.05, 0.100, 0.150],
    [-0.01, 0, 0.03, 0.108, 0.165],
    [0.00, 0, 0.14, 0.092, 0.140],
]
_TORSO = [
    [0.000, 0, 0.050, 0.114, 0.176],
    [0.000, 0, 0.080, 0.114, 0.174],
    [0.000, 0, 0.150, 0.106, 0.158],
    [0.000, 0, 0.240, 0.098, 0.146],
    [0.006, 0, 0.360, 0.114, 0.172],
    [0.004, 0, 0.450, 0.112, 0.184],
    [-0.004, 0, 0.510, 0.096, 0.184],
    [-0.008, 0, 0.545, 0.080, 0.160],
    [-0.008, 0, 0.570, 0.066, 0.115],
    [-0.008, 0, 0.588, 0.056, 0.078],
    [-0.006, 0, 0.600, 0.050, 0.055],
]
_NECK = [[-0.006, 0, 0.56, 0.050, 0.050], [0.000, 0, 0.66, 0.047, 0.047]]
_EAR = (0.018, 0.01, 0.026)
_UPPER_ARM = [
    [0.000, 0, -0.300, 0.034, 0.034],
    [0.000, 0, -0.270, 0.044, 0.042],
    [0.000, 0, -0.120, 0.051, 0.048],
    [0.000, 0, -0.020, 0.057, 0.053],
    [0.000, 0, 0.010, 0.052, 0.048],
    [0.000, 0, 0.032, 0.036, 0.033],
    [0.000, 0, 0.042, 0.014, 0.013],
]
_FOREARM = [
    [0.000, 0, -0.200, 0.036, 0.034],
    [0.000, 0, -0.060, 0.043, 0.041],
    [0.000, 0, 0.000, 0.043, 0.041],
    [0.000, 0, 0.020, 0.030, 0.030],
]
_WRIST = [[0.000, 0, -0.230, 0.025, 0.020], [0.000, 0, -0.190, 0.028, 0.026]]


def make_people() -> dict[str, TriangleMesh]:
    """Returns the parts by name."""
    head = [
        loft(_NECK, sides=12),
        ellipsoid((0.012, 0, 0.712), (0.088, 0.073, 0.108)),
        ellipsoid((0.102, 0, 0.700), (0.020, 0.013, 0.022), sides=8),
        ellipsoid((0.005, 0.074, 0.705), _EAR, sides=8),
        ellipsoid((0.005, -0.074, 0.705), _EAR, sides=8),
    ]
    crown = ellipsoid((0, 0, 0), (0.098, 0.082, 0.088))
    eyes = [
        ellipsoid((0.088, y, 0.728), (0.012, 0.011, 0.011), sides=8)
        for y in (-0.03, 0.03)
    ]
    upper_arm, forearm = loft(_UPPER_ARM, sides=12), loft(_FOREARM, sides=12)
    palm = ellipsoid((0.006, 0, -0.275), (0.034, 0.020, 0.055), sides=10)
    hand = join([loft(_WRIST, sides=8), palm])
    bent = upper_arm.moved((0, 0, 0), pitch=-0.45)
    telephone = extrude(_sheet(-0.005, 0.005, 0.037), -0.06, 0.09)
    screen = extrude(_sheet(-0.007, -0.004, 0.033), -0.055, 0.085)
    return {
        "hips": loft(_HIPS, power=2.3),
        "torso": loft(_TORSO, sides=20, power=2.3),
        # With neck, nose and ears.
        "head": join(head),
        "hair": crown.moved((-0.010, 0, 0.744), pitch=-0.35),
        "eyes": join(eyes),
        "thigh": loft(THIGH_SECTIONS, sides=14),
        "shin": loft(SHIN_SECTIONS, sides=14),
        "shoe": loft(SHOE_SECTIONS, sides=14, power=2.3),
        "sleeve": join([upper_arm, _hanging(forearm)]),
        "hand": _hanging(hand),
        # The parts of an arm with an elbow, each below its joint.
        "upper_arm": upper_arm,
        "forearm": forearm,
        "moving_hand": hand,
        # The arm that holds a telephone in front of the face.
        "bent_sleeve": join([bent, _held(forearm)]),
        "holding_hand": _held(hand),
        "telephone": _facing_up(telephone),
        "telephone_screen": _facing_up(screen),
    }


def _sheet(back: float, front: float, half: float) -> list[list[float]]:
    return [[back, -half], [front, -half], [front, half], [back, half]]


def _facing_up(telephone: TriangleMesh) -> TriangleMesh:
    """Turns an object in the hand of the bent arm to the eyes."""
    return telephone.moved((0.36, 0.0, -0.07), pitch=0.8)


def _hanging(forearm: TriangleMesh) -> TriangleMesh:
    """Puts a part below the elbow on a hanging, slightly bent arm."""
    return forearm.moved((0.0, 0.0, -0.275), pitch=-0.4)


def _held(forearm: TriangleMesh) -> TriangleMesh:
    """Puts a part below the elbow on the arm that holds a telephone."""
    return forearm.moved((0.12, 0.0, -0.248), pitch=-2.15)


if __name__ == "__main__":
    for name, mesh in make_people().items():
        file = Path(__file__).with_name(f"{name}.obj")
        file.write_text(mesh.to_obj(), encoding="utf-8")
