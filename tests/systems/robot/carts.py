"""Carts on wheels, as URDF, and the drives that fit them."""

import numpy as np

from tests.systems.robot.driven_robots import drive

RADIUS = 0.1

# The places of wheels of a skid steer with six, and of a car with mecanum
# wheels, by name; and of a car, whose front wheels are steered.
SIX = {
    f"{x}_{side}_wheel": (0.25 * k, 0.2 * sign)
    for k, x in ((1, "front"), (0, "middle"), (-1, "rear"))
    for side, sign in (("left", 1), ("right", -1))
}
FOUR = {name: place for name, place in SIX.items() if "middle" not in name}

_INERTIA = '<inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{0}"/>'


def _link(name, mass, inertia, shape):
    return (
        f'<link name="{name}"><inertial><mass value="{mass}"/>'
        f"{_INERTIA.format(inertia)}</inertial><collision>"
        f'<origin rpy="1.5707963267948966 0 0"/><geometry>{shape}</geometry>'
        "</collision></link>"
    )


def _joint(name, parent, child, place, axis):
    x, y, z = place
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{x} {y} {z}"/>'
        f'<axis xyz="{axis}"/></joint>'
    )


def cart(wheels, *, steered=(), casters=()) -> str:
    """Returns URDF of a box of 20 kg on wheels.

    The origin of its link "base" is 0.1 m above the floor. Joints have the
    names of wheels; before those that are `steered` there is one with the name
    and "_steering". The `casters` are places of wheels that swivel.
    """
    tire = f'<cylinder radius="{RADIUS}" length="0.04"/>'
    parts = [_link("base", 20, 0.8, '<box size="0.6 0.1 0.2"/>')]
    for name, (x, y) in wheels.items():
        parts.append(_link(f"{name}_link", 0.5, 0.003, tire))
        parent, place = "base", (x, y, 0)
        if name in steered:
            knuckle = f"{name}_knuckle"
            parts.append(
                f'<link name="{knuckle}"><inertial><mass value="0.5"/>'
                f"{_INERTIA.format(0.003)}</inertial></link>"
            )
            steering = f"{name}_steering"
            parts.append(_joint(steering, "base", knuckle, place, "0 0 1"))
            parent, place = knuckle, (0, 0, 0)
        parts.append(_joint(name, parent, f"{name}_link", place, "0 1 0"))
    for k, (x, y) in enumerate(casters):
        fork, ball = f"fork_{k}", f"caster_{k}"
        parts.append(
            f'<link name="{fork}"><inertial><mass value="0.2"/>'
            f"{_INERTIA.format(0.0005)}</inertial></link>"
        )
        parts.append(_link(ball, 0.2, 0.0002, '<sphere radius="0.03"/>'))
        parts.append(_joint(fork, "base", fork, (x, y, -0.03), "0 0 1"))
        parts.append(_joint(ball, fork, ball, (-0.03, 0, -0.04), "0 1 0"))
    return f'<robot name="cart">{"".join(parts)}</robot>'


def sides(wheels):
    """Returns the drive of a skid steer."""
    return {
        "type": "differential",
        "left_wheel": [name for name in wheels if "left" in name],
        "right_wheel": [name for name in wheels if "right" in name],
        "wheel_separation": 0.4,
        "wheel_radius": RADIUS,
    }


CAR = {
    "type": "ackermann",
    "left_wheel": "rear_left_wheel",
    "right_wheel": "rear_right_wheel",
    "left_steering": "front_left_wheel_steering",
    "right_steering": "front_right_wheel_steering",
    "wheel_radius": RADIUS,
    "max_steering_angle": 0.6,
}
STEERED = ("front_left_wheel", "front_right_wheel")
MECANUM = {
    "type": "mecanum",
    "wheel_radius": RADIUS,
    **{name: name for name in FOUR},
}


def reached(diagram, command, *, duration=2.5, time_step=0.05):
    """Returns the mean (v, omega) of a robot at the end of a drive."""
    run = drive(diagram, command, duration=duration, every=time_step)
    _, _, yaw, vx, vy, omega, _ = run.robot[run.times > duration - 0.8].T
    speed = vx * np.cos(yaw) + vy * np.sin(yaw)
    return float(speed.mean()), float(omega.mean())
