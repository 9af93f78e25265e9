"""A person's figure: bodies, joints and clothes, built in code."""

from pydrake.geometry import Cylinder, InMemoryMesh, Mesh, Rgba
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Joint,
    ModelInstanceIndex,
    PlanarJoint,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
)

from hunav_drake.systems.scene import human_parts
from hunav_drake.systems.scene.gait import THIGH
from hunav_drake.systems.scene.palette import (
    BODY_DISC,
    EYES,
    TELEPHONE,
    TELEPHONE_SCREEN,
    Clothes,
)
from hunav_drake.systems.scene.visuals import AddVisual

# The radius of the disc, in meters, at which the figure has the width of an
# adult; other radii make it wider or slimmer, within reason.
_NOMINAL_RADIUS = 0.35
_WIDTH_LIMITS = (0.6, 1.6)

# Half the distances between the hips and between the shoulders, and the
# height of the shoulders above the hips, in meters.
_HIP_Y = 0.09
_SHOULDER_Y = 0.19
_SHOULDER_Z = 0.515

# The disc lies so far above the floor that the two surfaces stay apart in the
# depth buffer of a browser.
_DISC_Z = 0.012

# The arm that holds a telephone is turned inwards by this, in radians, and the
# head is bent down to it, about the neck, at this height above the hips.
_INWARDS = 0.5
_BENT_DOWN = 0.4
_NECK_Z = 0.6


def AddHumanBody(
    plant: MultibodyPlant,
    name: str,
    *,
    radius: float,
    clothes: Clothes,
    telephone: bool = False,
) -> list[Joint]:
    """Adds the figure of a person to a plant, as its own model instance.

    The figure is 1.7 m tall and faces +x at yaw 0. It has eight bodies
    ("base", "trunk", and of each side "thigh", "shin" and "arm") on eight
    joints with ten positions, no mass, and no collision geometry. A disc on
    the floor shows the radius that the crowd computes with; it has no
    perception role, so that simulated cameras do not see it.

    Args:
        plant: A plant that is registered with a SceneGraph and not finalized.
        name: The name of the model instance, unique in the plant.
        radius: The radius of the person's disc, in meters.
        clothes: The colors.
        telephone: Whether the person looks at a telephone in the right hand.

    Returns:
        The joints in the order of the positions in `gait`: of the base
        (x, y, yaw), of the trunk (height of the hips), left hip, left knee,
        right hip, right knee, left shoulder, right shoulder.
    """
    instance = plant.AddModelInstance(name)
    low, high = _WIDTH_LIMITS
    width = min(max(radius / _NOMINAL_RADIUS, low), high)
    builder = _FigureBuilder(plant, instance, width, clothes)

    base = builder.AddBody("base")
    AddVisual(
        plant,
        base,
        "disc",
        Cylinder(radius, 0.002),
        BODY_DISC,
        RigidTransform([0, 0, _DISC_Z - 0.001]),
        perceived=False,
    )

    trunk = builder.AddBody("trunk")
    builder.AddPart(trunk, "hips", human_parts.Hips(), clothes.trousers)
    builder.AddPart(trunk, "torso", human_parts.Torso(), clothes.top)
    X_BH = _tilted(_BENT_DOWN) if telephone else None
    for part, mesh, color in (
        ("head", human_parts.Head(), clothes.skin),
        ("hair", human_parts.Hair(), clothes.hair),
        ("eyes", human_parts.Eyes(), EYES),
    ):
        builder.AddPart(trunk, part, mesh, color, X_BH)

    builder.AddJoint(
        PlanarJoint("pose", plant.world_frame(), base.body_frame())
    )
    builder.AddJoint(
        PrismaticJoint(
            "height", base.body_frame(), trunk.body_frame(), [0, 0, 1]
        )
    )
    for side, sign in (("left", 1.0), ("right", -1.0)):
        thigh = builder.AddBody(f"{side}_thigh")
        builder.AddPart(thigh, "thigh", human_parts.Thigh(), clothes.trousers)
        shin = builder.AddBody(f"{side}_shin")
        builder.AddPart(shin, "shin", human_parts.Shin(), clothes.trousers)
        builder.AddPart(shin, "shoe", human_parts.Shoe(), clothes.shoes)
        # Positive angles swing forward at the hip, and bend the knee.
        builder.AddSwing(f"{side}_hip", trunk, thigh, sign * _HIP_Y, 0, -1)
        builder.AddSwing(f"{side}_knee", thigh, shin, 0, -THIGH, 1)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        arm = builder.AddBody(f"{side}_arm")
        y = sign * _SHOULDER_Y
        if telephone and side == "right":
            # On the trunk, as it does not swing.
            builder.AddTelephone(trunk, [0, y * builder.width, _SHOULDER_Z])
        else:
            builder.AddPart(arm, "sleeve", human_parts.Sleeve(), clothes.top)
            builder.AddPart(arm, "hand", human_parts.Hand(), clothes.skin)
        builder.AddSwing(f"{side}_shoulder", trunk, arm, y, _SHOULDER_Z, -1)
    return builder.joints


def _tilted(pitch: float) -> RigidTransform:
    """Returns the pose of a head that is bent forward about the neck."""
    about = RigidTransform([0.0, 0.0, _NECK_Z])
    turn = RigidTransform(RotationMatrix.MakeYRotation(pitch))
    return about @ turn @ about.inverse()


class _FigureBuilder:
    """What the parts of one figure share while it is built."""

    def __init__(
        self,
        plant: MultibodyPlant,
        instance: ModelInstanceIndex,
        width: float,
        clothes: Clothes,
    ) -> None:
        self._plant = plant
        self._instance = instance
        self._clothes = clothes
        self.width = width
        self.joints: list[Joint] = []

    def AddBody(self, name: str) -> RigidBody:
        return self._plant.AddRigidBody(name, self._instance)

    def AddPart(
        self,
        body: RigidBody,
        name: str,
        mesh: InMemoryMesh,
        color: Rgba,
        X_BG: RigidTransform | None = None,
    ) -> None:
        shape = Mesh(mesh, [self.width, self.width, 1.0])
        AddVisual(self._plant, body, name, shape, color, X_BG)

    def AddTelephone(self, trunk: RigidBody, p_TS: list[float]) -> None:
        """Adds an arm that holds a telephone, at the shoulder S."""
        turn = RotationMatrix.MakeZRotation(_INWARDS)
        for part, mesh, color in (
            ("sleeve", human_parts.BentSleeve(), self._clothes.top),
            ("hand", human_parts.HoldingHand(), self._clothes.skin),
            ("telephone", human_parts.Telephone(), TELEPHONE),
            ("screen", human_parts.TelephoneScreen(), TELEPHONE_SCREEN),
        ):
            X_TG = RigidTransform(turn, p_TS)
            self.AddPart(trunk, part, mesh, color, X_TG)

    def AddSwing(
        self,
        name: str,
        parent: RigidBody,
        child: RigidBody,
        y: float,
        z: float,
        direction: int,
    ) -> None:
        X_PJ = RigidTransform([0, y * self.width, z])
        frame = self._plant.AddFrame(
            FixedOffsetFrame(name, parent.body_frame(), X_PJ)
        )
        axis = [0, direction, 0]
        self.AddJoint(RevoluteJoint(name, frame, child.body_frame(), axis))

    def AddJoint(self, joint: Joint) -> None:
        self.joints.append(self._plant.AddJoint(joint))
