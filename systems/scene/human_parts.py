"""The parts of a person's figure, of one size for everybody.

Each is in the frame of its body, x forward and z up, in meters, and is made
once.
"""

from collections.abc import Callable
from functools import cache

from pydrake.geometry import InMemoryMesh

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
from hunav_drake.systems.scene.visuals import MakeInMemoryMesh


def _part(make: Callable[[], TriangleMesh]) -> Callable[[], InMemoryMesh]:
    """Returns what makes the mesh of a part, once, under its name."""
    return cache(lambda: MakeInMemoryMesh(make(), make.__name__.lower()))


@_part
def Hips() -> TriangleMesh:
    """Returns the hips, in trousers, of the trunk."""
    sections = [
        [0.00, 0, -0.10, 0.060, 0.095],
        [-0.01, 0, -0.05, 0.100, 0.150],
        [-0.01, 0, 0.03, 0.108, 0.165],
        [0.00, 0, 0.14, 0.092, 0.140],
    ]
    return loft(sections, power=2.3)


@_part
def Torso() -> TriangleMesh:
    """Returns the torso, in a shirt, of the trunk."""
    sections = [
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
    return loft(sections, sides=20, power=2.3)


@_part
def Head() -> TriangleMesh:
    """Returns the neck and head with nose and ears, of the trunk."""
    neck = [[-0.006, 0, 0.56, 0.050, 0.050], [0.000, 0, 0.66, 0.047, 0.047]]
    ear = (0.018, 0.01, 0.026)
    return join(
        [
            loft(neck, sides=12),
            ellipsoid((0.012, 0, 0.712), (0.088, 0.073, 0.108)),
            ellipsoid((0.102, 0, 0.700), (0.020, 0.013, 0.022), sides=8),
            ellipsoid((0.005, 0.074, 0.705), ear, sides=8),
            ellipsoid((0.005, -0.074, 0.705), ear, sides=8),
        ]
    )


@_part
def Hair() -> TriangleMesh:
    """Returns the hair, of the trunk."""
    crown = ellipsoid((0, 0, 0), (0.098, 0.082, 0.088))
    return crown.moved((-0.010, 0, 0.744), pitch=-0.35)


@_part
def Eyes() -> TriangleMesh:
    """Returns the eyes, of the trunk."""
    eyes = [
        ellipsoid((0.088, y, 0.728), (0.012, 0.011, 0.011), sides=8)
        for y in (-0.03, 0.03)
    ]
    return join(eyes)


@_part
def Thigh() -> TriangleMesh:
    """Returns the thigh, in trousers, that hangs from the hip."""
    return loft(THIGH_SECTIONS, sides=14)


@_part
def Shin() -> TriangleMesh:
    """Returns the shin, in trousers, that hangs from the knee."""
    return loft(SHIN_SECTIONS, sides=14)


@_part
def Shoe() -> TriangleMesh:
    """Returns the shoe, of the shin."""
    return loft(SHOE_SECTIONS, sides=14, power=2.3)


@_part
def Sleeve() -> TriangleMesh:
    """Returns the arm, in its sleeve, that hangs from the shoulder."""
    return join([_upper_arm(), _bent(_forearm())])


@_part
def BentSleeve() -> TriangleMesh:
    """Returns the arm in its sleeve, bent to hold something before the face."""
    return join([_upper_arm().moved((0, 0, 0), pitch=-0.45), _held(_forearm())])


@_part
def Hand() -> TriangleMesh:
    """Returns the hand and wrist, of the arm."""
    return _bent(_hand())


@_part
def HoldingHand() -> TriangleMesh:
    """Returns the hand and wrist of the bent arm."""
    return _held(_hand())


@_part
def Telephone() -> TriangleMesh:
    """Returns a telephone, in the hand of the bent arm."""
    return _facing_up(extrude(_sheet(-0.005, 0.005, 0.037), -0.06, 0.09))


@_part
def TelephoneScreen() -> TriangleMesh:
    """Returns the screen of the telephone."""
    return _facing_up(extrude(_sheet(-0.007, -0.004, 0.033), -0.055, 0.085))


def _sheet(back: float, front: float, half: float) -> list[list[float]]:
    return [[back, -half], [front, -half], [front, half], [back, half]]


def _facing_up(telephone: TriangleMesh) -> TriangleMesh:
    """Turns what lies in the hand of the bent arm to the eyes."""
    return telephone.moved((0.36, 0.0, -0.07), pitch=0.8)


def _hand() -> TriangleMesh:
    wrist = loft(
        [[0.000, 0, -0.230, 0.025, 0.020], [0.000, 0, -0.190, 0.028, 0.026]],
        sides=8,
    )
    palm = ellipsoid((0.006, 0, -0.275), (0.034, 0.020, 0.055), sides=10)
    return join([wrist, palm])


def _upper_arm() -> TriangleMesh:
    sections = [
        [0.000, 0, -0.300, 0.034, 0.034],
        [0.000, 0, -0.270, 0.044, 0.042],
        [0.000, 0, -0.120, 0.051, 0.048],
        [0.000, 0, -0.020, 0.057, 0.053],
        [0.000, 0, 0.010, 0.052, 0.048],
        [0.000, 0, 0.032, 0.036, 0.033],
        [0.000, 0, 0.042, 0.014, 0.013],
    ]
    return loft(sections, sides=12)


def _forearm() -> TriangleMesh:
    sections = [
        [0.000, 0, -0.200, 0.036, 0.034],
        [0.000, 0, -0.060, 0.043, 0.041],
        [0.000, 0, 0.000, 0.043, 0.041],
        [0.000, 0, 0.020, 0.030, 0.030],
    ]
    return loft(sections, sides=12)


def _bent(forearm: TriangleMesh) -> TriangleMesh:
    """Puts what hangs from the elbow on a slightly bent arm."""
    return forearm.moved((0.0, 0.0, -0.275), pitch=-0.4)


def _held(forearm: TriangleMesh) -> TriangleMesh:
    """Puts what hangs from the elbow on the arm that holds something."""
    return forearm.moved((0.12, 0.0, -0.248), pitch=-2.15)
