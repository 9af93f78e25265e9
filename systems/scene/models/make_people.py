"""Generates the parts of a person's figure, the OBJ files in this folder.

`python -m hunav_drake.systems.scene.models.make_people` writes them. They have
one size for all people, each in the frame of its body, x forward and z up, in
meters.
"""

import math
from pathlib import Path

import numpy as np

from hunav_drake.systems.people.gait import FOOTREST
from hunav_drake.systems.people.legs import (
    RIM,
    SHIN_SECTIONS,
    SHOE_SECTIONS,
    THIGH_SECTIONS,
    WHEEL,
    WHEEL_Y,
)
from hunav_drake.systems.scene.meshes import (
    TriangleMesh,
    circle,
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
_LONG_HAIR = [
    [-0.085, 0, 0.470, 0.022, 0.085],
    [-0.085, 0, 0.560, 0.030, 0.092],
    [-0.070, 0, 0.680, 0.040, 0.090],
    [-0.050, 0, 0.760, 0.050, 0.082],
]
_CUP = [[0.405, 0, -0.245, 0.030, 0.030], [0.405, 0, -0.140, 0.040, 0.040]]
_PACK = [
    [-0.165, 0, 0.11, 0.070, 0.130],
    [-0.180, 0, 0.15, 0.090, 0.155],
    [-0.180, 0, 0.42, 0.085, 0.150],
    [-0.160, 0, 0.52, 0.065, 0.130],
    [-0.150, 0, 0.55, 0.040, 0.090],
]
# Ribbons over the shoulders; across the chest, and the back.
_PACK_STRAPS = [
    [
        [0.085, 0.125 * side, 0.22, 0.024, 0.022],
        [0.098, 0.115 * side, 0.36, 0.026, 0.022],
        [0.092, 0.110 * side, 0.46, 0.026, 0.022],
        [0.010, 0.105 * side, 0.58, 0.050, 0.022],
    ]
    for side in (-1, 1)
]
_BAG = [
    [-0.03, 0.215, -0.18, 0.140, 0.045],
    [-0.03, 0.215, -0.16, 0.155, 0.055],
    [-0.03, 0.210, 0.06, 0.150, 0.050],
    [-0.03, 0.210, 0.08, 0.140, 0.040],
]
_BAG_STRAPS = [
    [
        [side * 0.050, 0.185, 0.06, 0.022, 0.016],
        [side * 0.105, 0.080, 0.20, 0.018, 0.022],
        [side * 0.118, -0.010, 0.36, 0.018, 0.022],
        [side * 0.098, -0.070, 0.48, 0.020, 0.022],
        [side * 0.020, -0.100, 0.58, 0.050, 0.022],
    ]
    for side in (-1, 1)
]


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
    hair = crown.moved((-0.010, 0, 0.744), pitch=-0.35)
    bun = ellipsoid((-0.105, 0, 0.79), (0.045, 0.045, 0.04), sides=10)
    frame, wheels = _wheelchair()
    telephone = extrude(_sheet(-0.005, 0.005, 0.037), -0.06, 0.09)
    screen = extrude(_sheet(-0.007, -0.004, 0.033), -0.055, 0.085)
    return {
        "hips": loft(_HIPS, power=2.3),
        "torso": loft(_TORSO, sides=20, power=2.3),
        # With neck, nose and ears.
        "head": join(head),
        "short_hair": hair,
        "long_hair": join([hair, loft(_LONG_HAIR, sides=12)]),
        "bun_hair": join([hair, bun]),
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
        # The arm that holds a telephone in front of the face, or a cup.
        "telephone_sleeve": join([bent, _held(forearm, -2.15)]),
        "telephone_hand": _held(hand, -2.15),
        "telephone": _facing_up(telephone),
        "telephone_screen": _facing_up(screen),
        "cup_sleeve": join([bent, _held(forearm, -1.75)]),
        "cup_hand": _held(hand, -1.75),
        "cup": loft(_CUP, sides=12),
        "backpack": join([loft(_PACK, power=4), *map(loft, _PACK_STRAPS)]),
        "bag": join([loft(_BAG, power=4), *map(loft, _BAG_STRAPS)]),
        "basket": _basket(),
        "wheelchair": frame,
        "wheels": wheels,
    }


def _basket() -> TriangleMesh:
    """Returns a shopping basket in the hand below the elbow."""
    low, high, grip, y = -0.56, -0.38, -0.31, 0.07
    x, half, thick = 0.20, 0.125, 0.012
    walls = [
        extrude(_block(-x, x, half, y), low, low + thick),
        extrude(_block(-x, thick - x, half, y), low, high),
        extrude(_block(x - thick, x, half, y), low, high),
    ]
    for side in (-1, 1):
        edge = y + side * (half - thick / 2)
        walls.append(extrude(_block(-x, x, thick / 2, edge), low, high))
        bow = _block(-thick, thick, thick / 2, edge)
        walls.append(extrude(bow, high, grip))
    handle = extrude(_block(-thick, thick, half, y), grip - thick, grip)
    return join([*walls, handle])


def _wheelchair() -> tuple[TriangleMesh, TriangleMesh]:
    """Returns frame and wheels of a wheelchair, below the hips."""
    frame = [
        # Seat, back, arms, and what feet stand on.
        extrude(_block(-0.20, 0.26, 0.22), 0.42, 0.47),
        extrude(_block(-0.24, -0.20, 0.22), 0.44, 0.98),
        extrude(_block(0.32, 0.56, 0.16), FOOTREST - 0.03, FOOTREST),
        extrude(_block(0.24, 0.34, 0.03), FOOTREST - 0.03, 0.45),
    ]
    for side in (-1, 1):
        y = 0.23 * side
        frame.append(extrude(_block(-0.2, 0.14, 0.02, y), 0.66, 0.70))
        frame.append(extrude(_block(0.10, 0.13, 0.015, y), 0.45, 0.66))
    wheels = []
    for side in (-1, 1):
        place = (0.0, WHEEL_Y * side, WHEEL)
        large = [_wheel(WHEEL, WHEEL - 0.035, RIM)]
        large.append(_wheel(0.04, 0.0, RIM))
        large += [
            _upright(extrude(_spoke(k * math.pi / 4), -0.006, 0.006))
            for k in range(8)
        ]
        wheels += [it.moved(place) for it in large]
        wheels.append(_wheel(0.08, 0.0, 0.015).moved((0.3, 0.2 * side, 0.08)))
    return join(frame), join(wheels)


def _wheel(outer: float, inner: float, half: float) -> TriangleMesh:
    """Returns an upright ring about the y axis."""
    a, b = circle(inner, 24), circle(outer, 24)
    quads = zip(a, b, np.roll(b, -1, 0), np.roll(a, -1, 0), strict=True)
    parts = [it[bool(inner == 0.0) :] for it in map(np.array, quads)]
    return _upright(join([extrude(it, -half, half) for it in parts]))


def _upright(mesh: TriangleMesh) -> TriangleMesh:
    """Turns a mesh from the floor's plane into the plane of a wheel."""
    vertices, normals = (
        it[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
        for it in (mesh.vertices, mesh.normals)
    )
    return TriangleMesh(vertices, normals, mesh.faces)


def _spoke(angle: float) -> list[list[float]]:
    c, s = math.cos(angle), math.sin(angle)
    corners = _block(0.03, WHEEL - 0.02, 0.006)
    return [[c * x - s * y, s * x + c * y] for x, y in corners]


def _block(
    back: float, front: float, half: float, y: float = 0.0
) -> list[list[float]]:
    return [[x, y + side] for x, side in _sheet(back, front, half)]


def _sheet(back: float, front: float, half: float) -> list[list[float]]:
    return [[back, -half], [front, -half], [front, half], [back, half]]


def _facing_up(telephone: TriangleMesh) -> TriangleMesh:
    """Turns an object in the hand of the bent arm to the eyes."""
    return telephone.moved((0.36, 0.0, -0.07), pitch=0.8)


def _hanging(forearm: TriangleMesh) -> TriangleMesh:
    """Puts a part below the elbow on a hanging, slightly bent arm."""
    return forearm.moved((0.0, 0.0, -0.275), pitch=-0.4)


def _held(forearm: TriangleMesh, pitch: float) -> TriangleMesh:
    """Puts a part below the elbow on the arm that holds something."""
    return forearm.moved((0.12, 0.0, -0.248), pitch=pitch)


if __name__ == "__main__":
    for name, mesh in make_people().items():
        file = Path(__file__).with_name(f"{name}.obj")
        file.write_text(mesh.to_obj(), encoding="utf-8")
