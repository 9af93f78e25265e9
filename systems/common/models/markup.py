"""Finds faults in the text of a URDF or SDF file, with their lines.

Drake finds most of them, but for some states neither the place nor the rule.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
import math
from pathlib import Path
import re
from xml.parsers import expat

from hunav_drake.systems.common.suggest import shown

# The elements for other programs.
_FOREIGN = ("gazebo", "plugin", "ros2_control", "sensor", "transmission")

# The endings of meshes that bodies may touch.
_MESHES = (".obj", ".gltf", ".vtk")

# The largest number of a robot or a building, in SI units.
_LARGEST = 1e9

# The deepest nesting of elements.
_DEEPEST = 100

# The largest size of a part, in meters.
_SIZE = 1e5

_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_BEFORE = re.compile(rb"^(\s+)(<\?xml\b.*?\?>)", re.DOTALL)


@dataclass
class Element:
    """An element of XML.

    Attributes:
        tag: Its name, without that of a name space.
        attributes: Its attributes.
        line: The line of its start tag.
        children: The elements in it.
        text: The text in it.
    """

    tag: str
    attributes: dict[str, str]
    line: int
    children: list["Element"] = field(default_factory=list)
    text: str = ""

    def all(self) -> Iterator["Element"]:
        """Yields it and all elements in it, except those of other programs."""
        yield self
        for child in self.children:
            if child.tag not in _FOREIGN:
                yield from child.all()


@dataclass(frozen=True)
class Rule:
    """A rule for numbers, each in [low, high], or (low, high] if it is open.

    There must be one of `counts` of them; if `not_zero` is "each", none may be
    zero, if it is "all", not all of them.
    """

    counts: tuple[int, ...] = (1,)
    low: float = -_LARGEST
    high: float = _LARGEST
    is_open: bool = False
    not_zero: str = ""

    def broken(self, text: str) -> str:
        """Returns the rule that a text breaks; empty if none."""
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            values = []
        bad = not all(map(math.isfinite, values))
        if len(values) not in self.counts or bad:
            count = self.counts[0]
            many = f"{count} finite numbers" if count > 1 else "a finite number"
            return f"must be {many}"
        least, most = min(values), max(values)
        if least < self.low or most > self.high:
            bad = True
        if bad or (self.is_open and least == self.low):
            bracket = "(" if self.is_open else "["
            return f"must be in {bracket}{self.low:g}, {self.high:g}]"
        if self.not_zero == "each" and 0 in values:
            return "must not be 0"
        if self.not_zero == "all" and not any(values):
            return "must not be 0 along all axes"
        return ""


_NUMBER, _POINT, _LEAST_0 = Rule(), Rule((3,)), Rule(low=0.0)
# Those of limits that are none are large, as 1e16.
_ANY, _ANY_LEAST_0 = Rule((1,), -math.inf, math.inf), Rule((1,), 0.0, math.inf)
# A length, and three of them.
LENGTH = Rule(low=0.0, high=_SIZE, is_open=True)
SIDES = Rule((3,), 0.0, _SIZE, is_open=True)
_SCALE = Rule((3, 1), not_zero="each")
_SHAPES = {
    ("box", "size"): SIDES,
    ("sphere", "radius"): LENGTH,
    ("cylinder", "radius"): LENGTH,
    ("cylinder", "length"): LENGTH,
    ("capsule", "radius"): LENGTH,
    ("capsule", "length"): LENGTH,
    ("ellipsoid", "radii"): SIDES,
    ("ellipsoid", "a"): LENGTH,
    ("ellipsoid", "b"): LENGTH,
    ("ellipsoid", "c"): LENGTH,
    ("mesh", "scale"): _SCALE,
}
_INERTIA = {
    ("inertia", key): _LEAST_0 if key[1] == key[2] else _NUMBER
    for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
}
# Those of URDF are attributes, those of SDF are texts in elements.
_URDF = {
    **_SHAPES,
    **_INERTIA,
    ("origin", "xyz"): _POINT,
    ("origin", "rpy"): _POINT,
    ("mass", "value"): _LEAST_0,
    ("axis", "xyz"): Rule((3,), not_zero="all"),
    ("limit", "lower"): _ANY,
    ("limit", "upper"): _ANY,
    ("limit", "effort"): _ANY_LEAST_0,
    ("limit", "velocity"): _ANY_LEAST_0,
    ("mu_static", "value"): _LEAST_0,
    ("mu_dynamic", "value"): _LEAST_0,
    ("dynamics", "damping"): _LEAST_0,
    ("dynamics", "friction"): _LEAST_0,
    ("mimic", "multiplier"): _NUMBER,
    ("mimic", "offset"): _NUMBER,
}
_SDF = {
    **_SHAPES,
    **_INERTIA,
    ("inertial", "mass"): _LEAST_0,
    ("proximity_properties", "mu_static"): _LEAST_0,
    ("proximity_properties", "mu_dynamic"): _LEAST_0,
}


def parse_markup(path: Path, text: str | None = None) -> Element:
    """Returns the elements of a file of XML, in one without a name.

    The `text` is what is read in place of its content, if there is any.

    Raises:
        OSError: If it cannot be read.
        ValueError: If it is not XML; the text has the place.
    """
    # Like Drake, it does not check name spaces.
    parser = expat.ParserCreate(None if text is None else "utf-8")
    top = Element("", {}, 0)
    opened = [top]

    def start(tag: str, attributes: dict[str, str]) -> None:
        tag = tag.removeprefix("drake:")
        element = Element(tag, attributes, parser.CurrentLineNumber)
        opened[-1].children.append(element)
        if len(opened) > _DEEPEST:
            raise ValueError(f"has elements in more than {_DEEPEST} others")
        opened.append(element)

    def add_text(data: str) -> None:
        opened[-1].text += data

    def refuse(*_: object) -> None:
        raise ValueError("declares an entity; write what it stands for")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: opened.pop()
    parser.CharacterDataHandler = add_text
    parser.EntityDeclHandler = refuse
    parser.buffer_text = True
    content = path.read_bytes() if text is None else text.encode()
    # Like Gazebo and Drake, it takes comments with "--" in them, and space
    # before the declaration.
    content = _COMMENT.sub(lambda it: b"\n" * it[0].count(b"\n"), content)
    content = _BEFORE.sub(rb"\2\1", content)
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        line = parser.CurrentLineNumber
        raise ValueError(
            f"{path.name}:{line}: Error parsing XML: {error}"
        ) from error
    return top


def find_markup_fault(path: Path, text: str | None = None) -> str:
    """Returns the first fault of a file of XML, with its line; empty if none.

    See `parse_markup` for the arguments.

    Raises:
        OSError: If it cannot be read.
    """
    try:
        top = parse_markup(path, text)
    except ValueError as error:
        return str(error)
    for element, message in _faults(top):
        return f"{path.name}:{element.line}: {message}"
    return ""


def _faults(root: Element) -> Iterator[tuple[Element, str]]:
    kind = root.children[0].tag if root.children else ""
    rules = {"robot": _URDF, "sdf": _SDF}.get(kind, {})
    # Those of joints that do not move may be zero.
    fixed = [it for it in root.all() if it.attributes.get("type") == "fixed"]
    idle = {id(axis) for joint in fixed for axis in joint.children}
    for element in root.all():
        if id(element) in idle and element.tag == "axis":
            continue
        texts = {
            **{child.tag: child.text for child in element.children},
            **element.attributes,
        }
        all_text = "".join([element.text, *element.attributes.values()])
        if element.tag.startswith("xacro:") or "${" in all_text:
            yield (
                element,
                f"<{element.tag}> is for xacro, and nothing gives it a value;"
                " name the file robot.urdf.xacro, or give the value among the"
                " arguments",
            )
        for key, text in texts.items():
            rule = rules.get((element.tag, key))
            if rule is not None and (broken := rule.broken(text)):
                yield (
                    element,
                    f"{key} of <{element.tag}> {broken}, got"
                    f" {shown(text.strip())}; correct it",
                )
        if element.tag == "collision":
            yield from _collision_faults(element)
        if element.tag == "limit" and rules is _URDF:
            lower, upper = (
                float(element.attributes.get(key, 0))
                for key in ("lower", "upper")
            )
            if lower > upper:
                yield (
                    element,
                    f"lower of <limit> must be at most upper, got {lower:g} and"
                    f" {upper:g}; swap them",
                )


def _collision_faults(collision: Element) -> Iterator[tuple[Element, str]]:
    shapes = [
        shape
        for child in collision.children
        if child.tag == "geometry"
        for shape in child.children
    ]
    if not shapes:
        yield (
            collision,
            "<collision> must have a <geometry> with a shape; give it one, or"
            " leave the element out",
        )
    for mesh in (shape for shape in shapes if shape.tag == "mesh"):
        name = mesh.attributes.get("filename", "").strip()
        for child in mesh.children:
            name = child.text.strip() if child.tag == "uri" else name
        if not name.lower().endswith(_MESHES):
            # Of URDF, those that are there and can be read are replaced.
            others = ", or a .stl or .dae that is there and can be read"
            yield (
                mesh,
                f"the mesh of <collision> must be one of {', '.join(_MESHES)}"
                f"{others * ('filename' in mesh.attributes)}, got"
                f" {shown(name)}; convert it, or take a box or cylinder",
            )
