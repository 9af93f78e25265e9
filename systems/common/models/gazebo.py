"""Reads Gazebo's worlds and models: SDF that Drake does not read as such.

A world names models of other folders, has meshes that Drake does not know, and
elements of a simulator. It becomes a list of shapes, each with its pose. All
that could move stands where it begins.
"""

from collections import Counter
from collections.abc import (
    Callable,
    Container,
    Iterable,
    Iterator,
    Mapping,
    Sequence,
)
from dataclasses import dataclass, field, replace
import functools
import math
import os
from pathlib import Path
import re
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from hunav_drake.systems.common.models.apart import ModelFault
from hunav_drake.systems.common.models.gazebo_folders import (
    VARIABLES,
    Folders,
    model_file,
)
from hunav_drake.systems.common.models.markup import (
    LENGTH,
    SIDES,
    Element,
    Rule,
    parse_markup,
)
from hunav_drake.systems.common.models.mesh_files import MeshFile, read_mesh
from hunav_drake.systems.common.models.reading import file_path
from hunav_drake.systems.common.suggest import shown

# What a text has that is for this reader, and not for Drake's. (Joints have no
# meaning in a world, and Drake refuses those that form a loop.)
_OURS = re.compile(rb"<(?:world|include|mesh|actor|joint)\b")

# Models of the simulator: here, a trial has a floor, and views have light.
_SCENERY = ("sun", "ground_plane", "ground plane")

# The largest number of files in each other, of models in each other, of models
# and of shapes.
_DEEPEST = 30
_DEEPEST_MODEL = 100
_MOST_MODELS = 10_000
_MOST = 50_000

# The farthest that something may be, and the range of sizes with the scale of
# a state, in meters.
_FAR = 1e5
_SIZES = 1e-6, 1e4
_POSE = Rule((6,), -1e12, 1e12)
_QUATERNION = Rule((7,), -1e12, 1e12)
_COLOR = Rule((4, 3))
_TIME = Rule((1,), 0.0, 1e9)
_NORMAL = Rule((3,), not_zero="all")
# The cosine of the slope up to which a plane is a floor.
_LEVEL = 0.99
_SCALE = Rule((3, 1), -1e4, 1e4, not_zero="each")
GREY = (0.7, 0.7, 0.7, 1.0)
_NAMED = {
    "white": (1, 1, 1),
    "black": (0.1, 0.1, 0.1),
    "grey": GREY[:3],
    "darkgrey": (0.35, 0.35, 0.35),
    "red": (0.8, 0.1, 0.1),
    "green": (0.1, 0.7, 0.1),
    "blue": (0.1, 0.2, 0.8),
    "yellow": (0.9, 0.8, 0.1),
    "orange": (0.95, 0.5, 0.1),
    "purple": (0.5, 0.1, 0.6),
    "wood": (0.6, 0.42, 0.25),
    "bricks": (0.6, 0.32, 0.25),
}

Color = tuple[float, float, float, float]
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Part:
    """A shape of a model.

    Attributes:
        name: Its name, unique in the file.
        place: File and line of its element.
        X_WG: Its pose in the frame of the file.
        shape: A shape of Drake's, or a mesh.
        scale: The scale of a mesh along its axes.
        color: Red, green, blue and opacity, in [0, 1]; None is that of the
            mesh.
    """

    name: str
    place: str
    X_WG: RigidTransform
    shape: Shape | MeshFile
    scale: Triple = (1.0, 1.0, 1.0)
    color: Color | None = None


@dataclass(frozen=True)
class Actor:
    """A person in a world.

    Attributes:
        name: The name.
        place: File and line of its element.
        waypoints: Rows (time, x, y, yaw), in s, m and rad.
        loops: Whether the first one follows the last.
    """

    name: str
    place: str
    waypoints: tuple[tuple[float, float, float, float], ...]
    loops: bool


@dataclass(frozen=True, eq=False)
class GazeboFile:
    """What is in a file of Gazebo.

    Attributes:
        visuals: What one sees.
        collisions: What one runs into.
        actors: The people.
        losses: What should be there and is not, a line for each.
        notes: What has no meaning here, a line for each kind.
        files: All files that were read.
    """

    visuals: tuple[Part, ...]
    collisions: tuple[Part, ...]
    actors: tuple[Actor, ...]
    losses: tuple[str, ...]
    notes: tuple[str, ...]
    files: tuple[Path, ...]


def is_gazebo_file(file: str | Path) -> bool:
    """Returns whether this reads a file, and not Drake's parser.

    It is a .world; or a .sdf with a world, an include, an actor, a mesh or a
    joint.
    """
    kind = Path(file).suffix.lower()
    if kind not in (".world", ".sdf"):
        return False
    try:
        path = _path(file)
        return kind == ".world" or bool(_OURS.search(path.read_bytes()))
    except (OSError, ValueError):
        return False


def _path(file: str | Path) -> Path:
    if str(file).startswith("package://"):
        return file_path(str(file))
    return Path(os.path.abspath(file))


# The files read last, with the times of all that they name.
_read: dict[Any, tuple[GazeboFile, tuple[int, ...]]] = {}


def read_gazebo(
    file: str | Path, model_path: Sequence[str] = (), skip_missing: bool = False
) -> GazeboFile:
    """Reads a world or a model of Gazebo.

    The files read last are remembered, as long as none of them changes.

    Args:
        file: The file.
        model_path: Folders in which models are searched first.
        skip_missing: Whether models that are not there are losses, no faults.

    Raises:
        ModelFault: If it cannot be read, with file, line and remedy.
    """
    path = _path(file)
    variables = tuple(os.environ.get(name, "") for name in VARIABLES)
    key = path, tuple(model_path), skip_missing, variables
    if key in _read and _stamps(_read[key][0].files) == _read[key][1]:
        return _read[key][0]
    found = _Reader(path, model_path, skip_missing).read()
    while len(_read) > 31:
        _read.pop(next(iter(_read)))
    _read[key] = found, _stamps(found.files)
    return found


def _stamps(files: Sequence[Path]) -> tuple[int, ...]:
    try:
        return tuple(os.stat(it).st_mtime_ns for it in files)
    except OSError:
        return ()


class _Fault(ValueError):
    """A fault of an element; the text has file, line, rule and remedy."""


class _Missing(_Fault):
    """A model or a mesh that is not there."""


@dataclass(frozen=True)
class _Source:
    """An element, the file that it is in, and those that include this one."""

    element: Element
    path: Path
    above: tuple[Path, ...] = ()

    def place(self) -> str:
        # Models have files of one name.
        name = "/".join(
            self.path.parts[-2 if self.path.stem == "model" else -1 :]
        )
        return f"{name}:{self.element.line}"

    def fault(self, words: object) -> _Fault:
        return _Fault(f"{self.place()}: {words}")

    def of(self, element: Element) -> "_Source":
        return replace(self, element=element)

    def children(self, *tags: str) -> Iterator["_Source"]:
        for child in self.element.children:
            if child.tag in tags:
                yield self.of(child)

    def child(self, tag: str) -> "_Source | None":
        return next(self.children(tag), None)

    def text(self, tag: str, default: str = "") -> str:
        child = self.child(tag)
        return default if child is None else child.element.text.strip()

    def is_true(self, tag: str) -> bool:
        return self.text(tag).lower() in ("true", "1")

    @property
    def name(self) -> str:
        return self.element.attributes.get("name", self.element.tag)

    def numbers(self, tag: str, rule: Rule, default: Any = None) -> list[float]:
        """Returns the numbers of a child, or the default ones."""
        child = self.child(tag)
        if child is None and default is not None:
            return list(default)
        text = "" if child is None else child.element.text
        if broken := rule.broken(text):
            raise (child or self).fault(
                f"<{tag}> {broken}, got {shown(text.strip())}; correct it"
            )
        return [float(word) for word in text.split()]

    def pose(self) -> tuple[RigidTransform, str]:
        """Returns its pose, and the name of the frame that it is in."""
        pose = self.child("pose")
        if pose is None:
            return RigidTransform(), ""
        attributes = pose.element.attributes
        frame = attributes.get("relative_to", attributes.get("frame", ""))
        if not pose.element.text.strip():
            return RigidTransform(), frame
        if attributes.get("rotation_format") == "quat_xyzw":
            *p, x, y, z, w = self.numbers("pose", _QUATERNION)
            norm = math.hypot(x, y, z, w)
            if norm < 1e-6:
                raise pose.fault("the quaternion of <pose> is 0; correct it")
            turn = Quaternion(np.array([w, x, y, z]) / norm)
            return RigidTransform(RotationMatrix(turn), p), frame
        numbers = self.numbers("pose", _POSE)
        angles = np.array(numbers[3:])
        if attributes.get("degrees", "").lower() in ("true", "1"):
            angles = np.radians(angles)
        # (`fmod` is exact, and Drake has no limit of angles.)
        turn = RollPitchYaw(*np.fmod(angles, 2 * np.pi))
        return RigidTransform(turn, numbers[:3]), frame


class _Member(NamedTuple):
    """A model in a world or in a model, perhaps of another file.

    Attributes:
        element: Its element: <model> or <include>.
        name: Its name.
        model: The model; None if it is not there, or not needed.
        posed: The element with its pose.
    """

    element: _Source
    name: str
    model: _Source | None
    posed: _Source


# Returns the models in a world or in a model.
_Members = Callable[[_Source], Sequence[_Member]]


class _Frames:
    """The poses of what is in a model or a world, in its frame."""

    def __init__(self, source: _Source, members: _Members) -> None:
        """Lists the frames."""
        self._named: dict[str, tuple[RigidTransform, str, _Source]] = {}
        self._models: dict[str, _Source] = {}
        self._members = members
        for it in source.children("link", "frame", "joint"):
            X, frame = it.pose()
            attached = it.element.attributes.get("attached_to", "")
            if it.element.tag == "joint":
                attached = it.text("child")
            self._named.setdefault(it.name, (X, frame or attached, it))
        for member in members(source):
            X, frame = member.posed.pose()
            if member.model is not None:
                self._models.setdefault(member.name, member.model)
                X = X @ _placement(member, members).inverse()
            self._named.setdefault(member.name, (X, frame, member.element))

    def pose_of(self, name: str) -> RigidTransform:
        """Returns the pose of what has a name."""
        return self.resolve(*self._named[name])

    def resolve(
        self, X: RigidTransform, frame: str, source: _Source
    ) -> RigidTransform:
        """Returns a pose that is given in some frame."""
        seen = set()
        while frame not in ("", "__model__", "world"):
            head, _, rest = frame.partition("::")
            if rest and head in self._models:
                inner = _Frames(self._models[head], self._members)
                X = inner.resolve(X, rest, source)
                frame = head
            if frame in seen or frame not in self._named:
                what = "leads back to itself" if frame in seen else "is not"
                raise source.fault(
                    f"the frame {shown(frame)} {what}"
                    + " in the model" * (frame not in seen)
                    + "; name a link, model or frame beside it"
                )
            seen.add(frame)
            X_above, frame, source = self._named[frame]
            X = X_above @ X
        return X


def _placement(member: _Member, members: _Members) -> RigidTransform:
    """Returns the pose, in a model, of the frame that its pose is that of."""
    model = member.model
    assert model is not None
    own = model.element.attributes.get("placement_frame", "")
    name = member.element.text("placement_frame") or own
    if not name:
        return RigidTransform()
    return _Frames(model, members).resolve(RigidTransform(), name, model)


@dataclass
class _Reader:
    """Reads one file, with all that it includes."""

    path: Path
    model_path: Sequence[str]
    skip_missing: bool
    visuals: list[Part] = field(default_factory=list)
    collisions: list[Part] = field(default_factory=list)
    actors: list[Actor] = field(default_factory=list)
    losses: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    skipped: Counter[str] = field(default_factory=Counter)
    movable: list[str] = field(default_factory=list)
    files: dict[Path, Element] = field(default_factory=dict)
    included: dict[tuple[str, Path], Path] = field(default_factory=dict)
    members: dict[int, list[_Member]] = field(default_factory=dict)
    count: int = 0

    def read(self) -> GazeboFile:
        """Returns what is in the file."""
        self.folders = Folders(self.path, self.model_path)
        try:
            if not self.path.is_file():
                raise _Fault(
                    f"{self.path.name}: there is no file"
                    f" {shown(str(self.path))}; check the path"
                )
            top = self._open(self.path, ())
            for world in top.children("world"):
                self._world(world)
            for model in top.children("model"):
                member = _Member(model, model.name, model, model)
                X = _placement(member, self._members).inverse()
                self._placed(model, model.pose()[0] @ X, None, model.name)
            if top.child("world") is None and top.child("model") is None:
                raise top.fault("has neither <world> nor <model>; take another")
        except _Fault as fault:
            self.faults.insert(0, str(fault))
        if self.faults:
            first, *others = _grouped(self.faults)
            more = "; ".join(it[:160] for it in others[:3])
            raise ModelFault(
                ("file",),
                f"cannot be read: {first}"
                + f" (and {len(others)} more: {more})" * (len(others) > 0),
            )
        notes = [
            f"{count} <{tag}>: has no meaning here"
            for tag, count in sorted(self.skipped.items())
        ]
        if self.movable:
            few = ", ".join(self.movable[:5]) + ", ..." * (
                len(self.movable) > 5
            )
            notes.append(
                f"{len(self.movable)} models that could move stand still: {few}"
            )
        return GazeboFile(
            *(tuple(self.visuals), tuple(self.collisions), tuple(self.actors)),
            *(_grouped(self.losses), tuple(notes), tuple(self.files)),
        )

    def _open(self, path: Path, above: tuple[Path, ...]) -> _Source:
        """Returns the element <sdf> of a file."""
        path = Path(os.path.realpath(path))
        if path in above:
            names = " -> ".join(it.name for it in (*above, path)[-4:])
            raise _Fault(f"{names}: includes itself; take one <include> out")
        if len(above) > _DEEPEST:
            raise _Fault(
                f"{path.name}: more than {_DEEPEST} files include each other;"
                " take some out"
            )
        if path not in self.files:
            try:
                self.files[path] = parse_markup(path)
            except OSError as error:
                raise _Fault(f"{path.name}: {error.strerror}") from error
            except ValueError as error:
                raise _Fault(f"{error}; correct it") from error
        top = _Source(self.files[path], path, (*above, path))
        sdf = top.child("sdf")
        if sdf is None:
            raise _Source(top.element.children[0], path).fault(
                "must be <sdf>, the format of Gazebo's worlds and models"
            )
        return sdf

    def _world(self, world: _Source) -> None:
        state: dict[str, _Source] = {}
        deleted: set[str] = set()
        for it in world.children("state"):
            state = {model.name: model for model in it.children("model")}
            for gone in it.children("deletions"):
                deleted |= {
                    name.element.text.strip() for name in gone.children("name")
                }
            for added in it.children("insertions"):
                self._add_members(added, RigidTransform(), state, "")
        for actor in world.children("actor"):
            self._actor(actor)
        self._add_members(world, RigidTransform(), state, "", deleted=deleted)
        known = ("model", "include", "state", "actor", "frame", "joint", "link")
        self.skipped.update(
            it.tag for it in world.element.children if it.tag not in known
        )

    def _members(self, source: _Source) -> Sequence[_Member]:
        """Returns the models in a world or in a model."""
        key = id(source.element)
        if key not in self.members:
            found = [
                _Member(it, it.name, it, it) for it in source.children("model")
            ]
            found += map(self._member, source.children("include"))
            self.members[key] = found
        return self.members[key]

    def _member(self, include: _Source) -> _Member:
        model = None
        try:
            model = self._included(include)
        except _Missing as fault:
            missing = self.losses if self.skip_missing else self.faults
            missing.append(str(fault))
        except _Fault as fault:
            self.faults.append(str(fault))
        own = include.text("uri").rstrip("/").rpartition("/")[2]
        name = include.text("name") or (model.name if model else own)
        posed = include
        if model is not None and include.child("pose") is None:
            posed = model
        return _Member(include, name, model, posed)

    def _add_members(
        self,
        source: _Source,
        X_WM: RigidTransform,
        state: Mapping[str, _Source],
        name: str,
        still: bool = False,
        deleted: Container[str] = (),
    ) -> _Frames:
        """Adds the models in a world or in a model, with this pose."""
        frames = _Frames(source, self._members)
        for it in self._members(source):
            if it.model is None or it.name in deleted:
                continue
            path = f"{name}::{it.name}" if name else it.name
            own_still = still
            X = frames.resolve(*it.posed.pose(), it.posed)
            X = X @ _placement(it, self._members).inverse()
            for element in (it.model, it.element):
                own_still |= element.is_true("static")
            self._placed(
                it.model, X_WM @ X, state.get(it.name), path, own_still
            )
        return frames

    def _included(self, include: _Source) -> _Source | None:
        """Returns the model of an include; None for sun and ground."""
        uri = include.text("uri")
        # (Before a version, or the name of the file.)
        ends = re.split(r"[/\\]", unquote(uri).rstrip("/").lower())[-2:]
        if not set(ends).isdisjoint(_SCENERY):
            return None
        key = uri, include.path.parent
        try:
            if key not in self.included:
                self.included[key] = model_file(self.folders.find(*key))
        except (OSError, ValueError) as error:
            raise _Missing(f"{include.place()}: <include>: {error}") from error
        sdf = self._open(self.included[key], include.above)
        for kind in ("model", "actor", "light"):
            for found in sdf.children(kind):
                if kind == "model":
                    return found
                if kind == "actor":
                    self._actor(found, include)
                return None
        raise sdf.fault("has no <model>; include another file")

    def _placed(
        self,
        model: _Source,
        X_WM: RigidTransform,
        state: _Source | None,
        name: str,
        still: bool = True,
    ) -> None:
        """Adds a model with this pose, or that of a state."""
        scale: Triple = (1.0, 1.0, 1.0)
        links: dict[str, _Source] = {}
        inner: dict[str, _Source] = {}
        self.count += 1
        if name.count("::") > _DEEPEST_MODEL or self.count > _MOST_MODELS:
            raise model.fault(
                f"the file must have at most {_MOST_MODELS} models, and"
                f" {_DEEPEST_MODEL} in each other; split it"
            )
        if state is not None:
            # Those of Gazebo's states are poses in the world.
            X_WM = state.pose()[0]
            sx, sy, sz = state.numbers("scale", SIDES, (1.0, 1.0, 1.0))
            scale = sx, sy, sz
            links = {it.name: it for it in state.children("link")}
            inner = {it.name: it for it in state.children("model")}
        frames = self._add_members(model, X_WM, inner, name, still)
        if not still and model.child("link") is not None:
            self.movable.append(name)
        for link in model.children("link"):
            if link.name in links:
                X_WL = links[link.name].pose()[0]
            else:
                X_WL = X_WM @ frames.pose_of(link.name)
            self._link(link, X_WL, scale, f"{name}::{link.name}", frames)
            self.skipped.update(
                it.tag
                for it in link.element.children
                if it.tag in ("sensor", "light")
            )
        self.skipped.update(
            it.tag for it in model.element.children if it.tag == "plugin"
        )

    def _link(
        self,
        link: _Source,
        X_WL: RigidTransform,
        scale: Triple,
        name: str,
        frames: _Frames,
    ) -> None:
        found: dict[str, list[Part]] = {"visual": [], "collision": []}
        failed: dict[str, list[_Fault]] = {"visual": [], "collision": []}
        for it in link.children("visual", "collision"):
            X_LG, frame = it.pose()
            if frame not in ("", link.name, "__link__"):
                X_MG = frames.resolve(X_LG, frame, it)
                X_LG = frames.pose_of(link.name).inverse() @ X_MG
            geometry = it.child("geometry")
            if geometry is None:
                raise it.fault(
                    f"<{it.element.tag}> must have a <geometry>; give it one"
                )
            role = it.element.tag
            X_WG = X_WL @ X_LG
            try:
                shape, size = self._shape(geometry, scale, X_WG)
            except _Fault as fault:
                failed[role].append(fault)
                continue
            if not np.abs(X_WG.translation()).max() <= _FAR:
                self.losses.append(
                    f"{it.place()}: a part of {name.partition('::')[0]} is left"
                    f" out, as it is farther than {_FAR:g} m away; correct its"
                    " <pose>"
                )
            elif shape is not None:
                part = Part(f"{name}::{it.name}", it.place(), X_WG, shape, size)
                color = self._color(it, part) if role == "visual" else None
                found[role].append(replace(part, color=color))
        if failed["visual"]:
            instead = "nothing is shown"
            if not found["visual"] and found["collision"]:
                instead = "its collision shape is shown"
                found["visual"] = [
                    replace(it, color=GREY) for it in found["collision"]
                ]
            self.losses += [f"{it}; {instead}" for it in failed["visual"]]
        elif failed["collision"] and found["visual"]:
            found["collision"] += found["visual"]
            instead = "people and robots walk around what is shown"
            self.losses += [f"{it}; {instead}" for it in failed["collision"]]
            failed["collision"] = []
        for failure in failed["collision"]:
            is_skipped = self.skip_missing and isinstance(failure, _Missing)
            lines = self.losses if is_skipped else self.faults
            lines.append(str(failure) + "; it is left out" * is_skipped)
        self.visuals += found["visual"]
        self.collisions += found["collision"]
        if len(self.visuals) + len(self.collisions) > _MOST:
            raise link.fault(
                f"the file must have at most {_MOST} shapes; split it"
            )

    def _shape(
        self, geometry: _Source, scale: Triple, X_WG: RigidTransform
    ) -> tuple[Shape | MeshFile | None, Triple]:
        """Returns a shape, or None if it has no meaning here, and its scale."""
        for child in geometry.element.children:
            it = geometry.of(child)
            if child.tag == "mesh":
                sizes = it.numbers("scale", _SCALE, (1.0, 1.0, 1.0))
                a, b, c = np.array(sizes * (3 // len(sizes))) * scale
                _check_sizes(it, [a, b, c])
                mesh = self._mesh(it)
                reach = np.abs(mesh.triangles * (a, b, c)).max()
                if reach > _FAR:
                    raise it.fault(
                        f"the mesh reaches farther than {_FAR:g} m; correct"
                        " <scale>"
                    )
                return mesh, (a, b, c)
            if child.tag in _SHAPES:
                make, factors, rules = _SHAPES[child.tag]
                numbers = np.array(
                    [n for tag, rule in rules for n in it.numbers(tag, rule)]
                ) * factors(*scale)
                _check_sizes(it, numbers)
                return make(*numbers), scale
            normal = [0.0, 0.0, 1.0]
            if child.tag == "plane":
                normal = it.numbers("normal", _NORMAL, normal)
            slope = X_WG.rotation() @ np.array(normal)
            # (A trial has a floor; planes that are steeper are walls or ramps.)
            level = abs(slope[2]) > _LEVEL * math.hypot(*slope)
            if child.tag == "empty" or (child.tag == "plane" and level):
                return None, scale
            if child.tag in ("heightmap", "image", "polyline", "plane"):
                self.losses.append(
                    f"{it.place()}: <{child.tag}> is left out; export it as a"
                    " mesh, or take boxes"
                )
                return None, scale
        raise geometry.fault(
            f"<geometry> must have one of {', '.join(_SHAPES)} or mesh; give it"
            " one, or leave the element out"
        )

    def _mesh(self, mesh: _Source) -> MeshFile:
        submesh = mesh.child("submesh")
        part, centered = "", False
        if submesh is not None:
            part, centered = submesh.text("name"), submesh.is_true("center")
        try:
            path = self.folders.find(mesh.text("uri"), mesh.path.parent)
        except (OSError, ValueError) as error:
            raise _Missing(f"{mesh.place()}: <mesh>: {error}") from error
        try:
            found = read_mesh(path, part, centered)
        except (OSError, ValueError) as error:
            raise mesh.fault(f"<mesh>: {error}") from error
        self.files.setdefault(found.path, mesh.element)
        return found

    def _color(self, visual: _Source, part: Part) -> Color | None:
        """Returns the color of a visual; None is that of its mesh."""
        material = visual.child("material")
        see_through = visual.numbers("transparency", Rule(), (0.0,))[0]
        opacity = 1.0 - float(np.clip(see_through, 0.0, 1.0))
        default = None
        if not isinstance(part.shape, MeshFile):
            default = *GREY[:3], opacity
        if material is None:
            return default
        script = material.child("script")
        named = script.text("name").lower().rpartition("/")[2] if script else ""
        if named in _NAMED:
            return *_NAMED[named], opacity
        for texture in material.element.all():
            if texture.tag == "albedo_map":
                color = self._mean_color(texture.text, visual)
                return (*color, opacity) if color else default
        if material.child("diffuse") is None or named:
            return default
        r, g, b, *_ = np.clip(material.numbers("diffuse", _COLOR), 0.0, 1.0)
        return float(r), float(g), float(b), opacity

    def _mean_color(self, uri: str, visual: _Source) -> Triple | None:
        """Returns the mean color of an image; None if it cannot be read."""
        try:
            path = self.folders.find(uri, visual.path.parent)
            return _mean_of(path, path.stat().st_mtime_ns)
        except (OSError, ValueError):
            return None

    def _actor(self, actor: _Source, include: _Source | None = None) -> None:
        """Adds a person: where it stands, and the waypoints of its script."""
        posed = (
            actor if include is None or not include.child("pose") else include
        )
        script = actor.child("script")
        rows: list[tuple[float, float, float, float]] = []
        ways = list(script.children("trajectory")) if script else []
        # One begins when that before it ends, as in Gazebo.
        ways.sort(
            key=lambda it: _number_of(it.element.attributes.get("id", ""))
        )
        for way in ways:
            start = rows[-1][0] if rows else 0.0
            rows += sorted(
                (start + it.numbers("time", _TIME)[0], *_flat(it))
                for it in way.children("waypoint")
            )
        rows = rows or [(0.0, *_flat(posed))]
        loops = script is not None and (
            script.child("loop") is None or script.is_true("loop")
        )
        name = (include.text("name") if include else "") or actor.name
        self.actors.append(Actor(name, actor.place(), tuple(rows), loops))


@functools.lru_cache(maxsize=64)
def _mean_of(path: Path, stamp: int) -> Triple | None:
    from PIL import Image

    try:
        with Image.open(path) as image:
            r, g, b = np.asarray(image.convert("RGB")).mean(axis=(0, 1)) / 255
    except (OSError, ValueError, Image.DecompressionBombError):
        return None
    return float(r), float(g), float(b)


def _grouped(lines: Sequence[str]) -> tuple[str, ...]:
    """Returns lines of which those with the same words are one."""
    places: dict[str, list[str]] = {}
    for line in lines:
        place, _, words = line.partition(": ")
        places.setdefault(words, []).append(place)
    return tuple(
        f"{own[0]}{f' and {len(own) - 1} more' * (len(own) > 1)}: {words}"
        for words, own in places.items()
    )


def _flat(source: _Source) -> Triple:
    """Returns x, y and yaw of the pose of an element, in meters and radians."""
    X = source.pose()[0]
    x, y, _ = X.translation()
    if max(abs(x), abs(y)) > _FAR:
        raise source.fault(
            f"<pose> must be at most {_FAR:g} m away, got ({x:g}, {y:g});"
            " correct it"
        )
    return float(x), float(y), float(RollPitchYaw(X.rotation()).yaw_angle())


def _number_of(text: str) -> float:
    return float(text) if text.strip().isdecimal() else math.inf


def _check_sizes(shape: _Source, sizes: Iterable[float]) -> None:
    """Refuses a shape that is too small or too large with its scale."""
    low, high = _SIZES
    for size in sizes:
        if not low <= abs(size) <= high:
            raise shape.fault(
                f"the sizes of <{shape.element.tag}>, with the scale of"
                f" <state>, must be in [{low:g}, {high:g}], got {size:g};"
                " correct them"
            )


def _cone(radius: float, length: float) -> Convex:
    """Returns a cone with its tip up, and its origin half way up."""
    angles = np.linspace(0.0, 2 * np.pi, 64, endpoint=False)
    x, y = radius * np.cos(angles), radius * np.sin(angles)
    base = [x, y, np.full(64, -length / 2)]
    return Convex(np.column_stack([base, [0.0, 0.0, length / 2]]), "cone")


# Of each shape: what makes it of its sizes, their factors by the scale of its
# model along x, y and z, as Gazebo takes them, and the rules of its elements.
_SHAPES: dict[
    str,
    tuple[
        Callable[..., Shape],
        Callable[[float, float, float], Sequence[float]],
        tuple[tuple[str, Rule], ...],
    ],
] = {
    "box": (Box, lambda x, y, z: (x, y, z), (("size", SIDES),)),
    "sphere": (Sphere, lambda x, y, z: (max(x, y, z),), (("radius", LENGTH),)),
    "cylinder": (
        Cylinder,
        lambda x, y, z: (max(x, y), z),
        (("radius", LENGTH), ("length", LENGTH)),
    ),
    "cone": (
        _cone,
        lambda x, y, z: (max(x, y), z),
        (("radius", LENGTH), ("length", LENGTH)),
    ),
    "capsule": (
        Capsule,
        lambda x, y, z: (max(x, y), z),
        (("radius", LENGTH), ("length", LENGTH)),
    ),
    "ellipsoid": (Ellipsoid, lambda x, y, z: (x, y, z), (("radii", SIDES),)),
}
