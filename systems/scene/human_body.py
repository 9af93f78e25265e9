"""A person's figure: bodies, joints and clothes; its meshes are in `models`."""

from collections.abc import Sequence
from functools import cache
from importlib import resources

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Rgba
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Joint,
    PlanarJoint,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
)

from hunav_drake.systems.people.figure_config import HEAD_POWER, FigureConfig
from hunav_drake.systems.people.gait import THIGH
from hunav_drake.systems.people.legs import HIP_Y, WHEELCHAIR_X, figure_width
from hunav_drake.systems.scene.meshes import disc
from hunav_drake.systems.scene.palette import (
    BACKPACK,
    BAG,
    BASKET,
    BODY_DISC,
    CUP,
    EYES,
    TELEPHONE,
    TELEPHONE_SCREEN,
    WHEELCHAIR,
    WHEELS,
    Clothes,
)
from hunav_drake.systems.scene.visuals import AddLabeledVisual, AddVisual

# Half the distance between the shoulders, and their height above the hips, in
# meters.
_SHOULDER_Y = 0.19
_SHOULDER_Z = 0.515

# The height of the first disc above the floor, and the step to the next one, in
# meters, repeated after this number of levels. Overlapping surfaces at the same
# height would flicker, because the depth buffer cannot separate them.
_DISC_Z = 0.0104
_DISC_STEP = 0.0008
_DISC_LEVELS = 12

# The inward turn of an arm that holds a telephone and the downward pitch of the
# head, in radians, and the height of the neck above the hips, in meters.
_INWARDS = 0.5
_BENT_DOWN = 0.4
_NECK_Z = 0.6

# Where a basket is on the lap, from where it hangs below an elbow, in meters.
_ON_LAP = [0.25, -0.07, 0.66]

# The height of an elbow below the shoulder, in meters, negative.
_ELBOW_Z = -0.275

# The parts of what is held, besides arm and hand.
_HELD = {
    "telephone": (
        ("telephone", TELEPHONE),
        ("telephone_screen", TELEPHONE_SCREEN),
    ),
    "cup": (("cup", CUP),),
}

Axis = Sequence[float]


def AddHumanBody(
    plant: MultibodyPlant,
    name: str,
    *,
    radius: float,
    clothes: Clothes,
    figure: FigureConfig | None = None,
    label: int | None = None,
    level: int = 0,
    lively: bool = False,
) -> list[Joint]:
    """Adds the figure of a person to a plant as a model instance.

    The figure faces +x at yaw 0. It has eight bodies ("base", "trunk", and
    "thigh", "shin" and "arm" on each side) with eight joints and ten positions,
    no mass, and no collision geometry. A disc on the floor shows the person's
    radius in the crowd; it has no perception role, so simulated cameras do not
    see it.

    Args:
        plant: A plant that is registered with a SceneGraph and not finalized.
        name: The name of the model instance, unique in the plant.
        radius: The radius of the person's disc, in meters.
        clothes: The colors.
        figure: How it looks; by default as an adult of 1.7 m.
        label: The label of the whole figure in label images: see `human_label`;
            by default, each body has a separate one.
        level: The number of people added before. It raises the disc slightly,
            so that overlapping discs have different heights.
        lively: Whether the figure sits, looks aside and gestures: it has four
            bodies, joints and positions more.

    Returns:
        The joints in the order of the positions in `gait`: of the base
        (x, y, yaw), of the trunk (height of the hips), left hip, left knee,
        right hip, right knee, left shoulder, right shoulder; then, in the order
        of those in `manners`, of the pitch of the trunk, the yaw of the head,
        left elbow, right elbow.
    """
    instance = plant.AddModelInstance(name)
    figure = figure or FigureConfig()
    tall, width = figure.tall, figure_width(radius) * figure.wide
    # (Children have large heads.)
    large = tall**HEAD_POWER
    head_size = [figure_width(radius) * figure.build * min(large, 1.0)] * 2
    holds = figure.holds or "nothing"
    joints: list[Joint] = []

    def AddPart(
        body: RigidBody,
        part: str,
        color: Rgba,
        X_BG: RigidTransform | None = None,
        size: Sequence[float] = (width, width, tall),
    ) -> None:
        shape = Mesh(_read_mesh(part), size)
        if label is None:
            AddVisual(plant, body, part, shape, color, X_BG)
        else:
            AddLabeledVisual(plant, body, part, shape, color, X_BG, label)

    def AddTurning(
        body: str, parent: RigidBody, joint: str, place: ArrayLike, axis: Axis
    ) -> tuple[RigidBody, Joint]:
        """Adds a body that turns about a point of another."""
        turning = plant.AddRigidBody(body, instance)
        X_PJ = RigidTransform(np.multiply(place, [1, width, tall]))
        frame = plant.AddFrame(
            FixedOffsetFrame(joint, parent.body_frame(), X_PJ)
        )
        turn = RevoluteJoint(joint, frame, turning.body_frame(), axis)
        return turning, plant.AddJoint(turn)

    def AddSwinging(
        body: str, parent: RigidBody, joint: str, place: ArrayLike, sense: int
    ) -> RigidBody:
        """Adds a body that swings forward or backward."""
        axis = [0, sense, 0]
        hanging, swing = AddTurning(body, parent, joint, place, axis)
        joints.append(swing)
        return hanging

    base = plant.AddRigidBody("base", instance)
    flat = disc(radius, disc_height(level))
    AddVisual(plant, base, "disc", flat, BODY_DISC, perceived=False)

    world, floor, top = plant.world_frame(), base.body_frame(), [0, 0, 1]
    hips = floor
    if figure.wheelchair:
        X_BC = RigidTransform([WHEELCHAIR_X, 0.0, 0.0])
        hips = plant.AddFrame(FixedOffsetFrame("chair", floor, X_BC))
        for part, color in (("wheelchair", WHEELCHAIR), ("wheels", WHEELS)):
            AddPart(base, part, color, X_BC, [1.0, 1.0, 1.0])
    raised = plant.AddRigidBody("raised" if lively else "trunk", instance)
    for joint in (
        PlanarJoint("pose", world, floor),
        PrismaticJoint("height", hips, raised.body_frame(), top),
    ):
        joints.append(plant.AddJoint(joint))
    trunk = head = raised
    neck = [0.0, 0.0, _NECK_Z]
    bent = RotationMatrix.MakeYRotation(
        _BENT_DOWN if holds == "telephone" else 0.0
    )
    X_BH = RigidTransform(bent, np.multiply(neck, tall))
    further: list[Joint] = []
    if lively:
        trunk, lean = AddTurning("trunk", raised, "lean", [0, 0, 0], [0, 1, 0])
        head, turn = AddTurning("head", trunk, "neck", neck, top)
        further = [lean, turn]
        X_BH = RigidTransform(bent, [0.0, 0.0, 0.0])
    X_BH = X_BH @ RigidTransform(np.multiply(neck, -large))
    AddPart(trunk, "hips", clothes.trousers)
    AddPart(trunk, "torso", clothes.top)
    parts = {"head": clothes.skin, "eyes": EYES}
    if figure.hair != "none":
        parts[f"{figure.hair or 'short'}_hair"] = clothes.hair
    for part, color in parts.items():
        AddPart(head, part, color, X_BH, [*head_size, large])
    in_hand = figure.carries == "basket" and not figure.wheelchair
    if figure.carries == "basket" and not in_hand:
        AddPart(trunk, "basket", BASKET, RigidTransform(_ON_LAP))
    if figure.carries in ("backpack", "bag"):
        color = BACKPACK if figure.carries == "backpack" else BAG
        AddPart(trunk, figure.carries, color)

    # Positive angles swing forward at the hip, and bend the knee.
    for side, sign in (("left", 1.0), ("right", -1.0)):
        hip = [0, sign * HIP_Y, 0]
        thigh = AddSwinging(f"{side}_thigh", trunk, f"{side}_hip", hip, -1)
        AddPart(thigh, "thigh", clothes.trousers)
        knee = [0, 0, -THIGH]
        shin = AddSwinging(f"{side}_shin", thigh, f"{side}_knee", knee, 1)
        AddPart(shin, "shin", clothes.trousers)
        AddPart(shin, "shoe", clothes.shoes)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        place = [0, sign * _SHOULDER_Y, _SHOULDER_Z]
        arm = AddSwinging(f"{side}_arm", trunk, f"{side}_shoulder", place, -1)
        is_held = holds != "nothing" and side == "right"
        if is_held:
            # On the trunk, because it does not swing.
            inwards = RotationMatrix.MakeZRotation(_INWARDS)
            X_TS = RigidTransform(inwards, np.multiply(place, [1, width, tall]))
            for part, color in (
                (f"{holds}_sleeve", clothes.top),
                (f"{holds}_hand", clothes.skin),
                *_HELD[holds],
            ):
                AddPart(trunk, part, color, X_TS)
        elif not lively:
            AddPart(arm, "sleeve", clothes.top)
            AddPart(arm, "hand", clothes.skin)
            if side == "left" and in_hand:
                X_AE = RigidTransform([0.0, 0.0, _ELBOW_Z * tall])
                AddPart(arm, "basket", BASKET, X_AE)
        if lively:
            elbow = [0, 0, _ELBOW_Z]
            forearm, bend = AddTurning(
                f"{side}_forearm", arm, f"{side}_elbow", elbow, [0, -1, 0]
            )
            further.append(bend)
            if side == "left" and in_hand:
                AddPart(forearm, "basket", BASKET)
            if not is_held:
                AddPart(arm, "upper_arm", clothes.top)
                AddPart(forearm, "forearm", clothes.top)
                AddPart(forearm, "moving_hand", clothes.skin)
    return joints + further


def disc_height(level: int) -> float:
    """Returns the height of a person's disc, in m: see `AddHumanBody`."""
    return _DISC_Z + _DISC_STEP * (level % _DISC_LEVELS)


@cache
def _read_mesh(name: str) -> InMemoryMesh:
    """Returns a mesh of `models` as a file in memory."""
    file = resources.files(__package__) / f"models/{name}.obj"
    text = file.read_text(encoding="utf-8")
    return InMemoryMesh(mesh_file=MemoryFile(text, ".obj", name))
