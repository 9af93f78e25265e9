"""Reads meshes of other programs (.dae, .stl, .obj, .gltf, .glb).

They become triangles in meters, and .obj, which Drake shows. What was read is
kept in a folder on the disk, under a hash of its content.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
import functools
import hashlib
import importlib.util
import io
import itertools
import os
from pathlib import Path
import re
import shutil
import tempfile
from typing import Any
import warnings

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.files import atomic_write

MESHES = (".dae", ".stl", ".obj", ".gltf", ".glb")

# The largest file, in bytes, number of triangles, and coordinate, in units of
# the file: many are in millimeters, and scaled where they are used.
_MOST_BYTES = 200_000_000
_MOST_TRIANGLES = 1_000_000
_FARTHEST = 1e12

# The size of textures that are kept, in pixels: replays hold all of them.
_TEXTURE = 256

# The version of what is kept.
_VERSION = 6

# The names of textures and materials in the text of a mesh.
_ENDING = re.compile(rb"\.(?:png|jpe?g|tga|bmp|tiff?|mtl)\b", re.I)
_BEFORE = re.compile(r"[^<>\"'=\n]*$")

_UNIT = re.compile(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']*)")

# From the frame of glTF, with y upwards.
_Y_UP = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh of a file, or a part of it.

    Attributes:
        path: The file.
        part: The name of the part; empty is the whole.
        is_centered: Whether the middle of its bounds is its origin.
        key: A hash of its content.
        triangles: Shape (t, 3, 3): the corners in its frame, in meters.
    """

    path: Path
    part: str
    is_centered: bool
    key: str
    triangles: Array


def cache_folder() -> Path:
    """Returns the folder of what is kept between runs, which exists.

    It is that of the environment variable HUNAV_CACHE, or else below the usual
    one of the user; without permission, a temporary one.
    """
    usual = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = Path(os.environ.get("HUNAV_CACHE") or usual / "hunav_drake")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass
    return _temporary()


@functools.cache
def _temporary() -> Path:
    return Path(tempfile.mkdtemp(prefix="hunav-"))


def kept(name: str, make: Callable[[], Array]) -> NDArray[Any]:
    """Returns an array that is kept on the disk, or makes it.

    Args:
        name: Its name, which its content follows from.
        make: Returns it.
    """
    path = cache_folder() / f"{name}.npy"
    try:
        with path.open("rb") as file:
            return np.lib.format.read_array(file, allow_pickle=False)
    except (OSError, ValueError, EOFError, MemoryError):
        array: NDArray[Any] = make()
    # (What a full disk does not take is made again.)
    with suppress(OSError), atomic_write(path) as file:
        np.save(file, array)
    return array


def read_mesh(path: Path, part: str = "", centered: bool = False) -> MeshFile:
    """Reads a mesh.

    Args:
        path: The file.
        part: The name of a part of it; empty is the whole.
        centered: Whether to move the middle of its bounds to the origin.

    Raises:
        ValueError: If it cannot be read, in a line; the text has a remedy.
    """
    try:
        stat = path.stat()
    except OSError as error:
        raise ValueError(f"{path.name}: {error.strerror}") from error
    return _read(path, part, centered, stat.st_mtime_ns, stat.st_size)


@functools.lru_cache(maxsize=512)
def _read(
    path: Path, part: str, centered: bool, stamp: int, size: int
) -> MeshFile:
    if path.suffix.lower() not in MESHES:
        raise ValueError(
            f"the mesh {path.name} must be one of {', '.join(MESHES)}; convert"
            " it"
        )
    if size > _MOST_BYTES:
        raise ValueError(
            f"{path.name} must have at most {_MOST_BYTES // 10**6} MB, got"
            f" {size // 10**6}; simplify the mesh"
        )
    content = path.read_bytes()
    key = hashlib.sha256(content)
    key.update(f"{path.suffix} {part} {centered} {_VERSION}".encode())
    for text in sorted(_named_images(content)):
        for place in (path.parent / text, Path(text)):
            if os.path.isfile(place):
                key.update(f"{text} {os.stat(place).st_mtime_ns}".encode())
    name = key.hexdigest()[:40]

    def make() -> Array:
        return _triangles(_scene(path, part, centered))

    return MeshFile(path, part, centered, name, kept(name, make))


def _named_images(content: bytes) -> Iterator[str]:
    """Yields names of textures and materials in the text of a mesh."""
    for it in _ENDING.finditer(content):
        text = content[max(0, it.start() - 200) : it.end()].decode("latin-1")
        found = _BEFORE.search(text)
        yield found[0].removeprefix("mtllib").strip() if found else ""


def obj_of(
    mesh: MeshFile,
    color: tuple[float, ...] | None = None,
    cut: tuple[Any, float] | None = None,
    signs: tuple[float, float, float] = (1.0, 1.0, 1.0),
    is_plain: bool = False,
) -> Path | None:
    """Returns an .obj file of a mesh, with small textures.

    Args:
        mesh: The mesh.
        color: Red, green, blue and opacity instead of its own, in [0, 1].
        cut: A matrix (4, 4) from its frame to another one, and the height in
            the latter above which it is cut off.
        signs: -1 for each axis along which it is mirrored then, else 1.
            (Renderers light meshes with a negative scale from inside.)
        is_plain: Whether what has no color in the file gets none, so that it
            has that of the model; else it is grey.

    Returns:
        The file; None if nothing is left of the mesh.
    """
    name = mesh.key
    is_mirrored = min(signs) < 0
    if color is not None or cut is not None or is_mirrored or is_plain:
        text = f"{color} {cut and (cut[0].round(6).tolist(), cut[1])}"
        text += f" {signs}" * is_mirrored + " plain" * is_plain
        name += f"_{hashlib.sha256(text.encode()).hexdigest()[:32]}"
    folder = cache_folder() / name
    file = folder / "model.obj"
    if not folder.is_dir():
        draft = Path(tempfile.mkdtemp(dir=folder.parent))
        try:
            scene = _scene(mesh.path, mesh.part, mesh.is_centered)
            parts = _cut(scene, cut)
            for part in parts if is_mirrored else ():
                part.apply_transform(np.diag([*signs, 1.0]))
            _write_obj(draft, parts, color, is_plain)
            # (Another process may have been faster.)
            with suppress(OSError):
                os.replace(draft, folder)
        finally:
            shutil.rmtree(draft, ignore_errors=True)
    return file if file.is_file() else None


class _Textures:
    """Finds the textures of a mesh, as trimesh asks for them."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def get(self, name: str) -> bytes:
        """Returns the content of a file near the mesh."""
        name = name.strip().removeprefix("file://").replace("\\", "/")
        last = name.rpartition("/")[2]
        textures = self._folder.parent / "materials" / "textures"
        for place in (self._folder / name, textures / last):
            if place.is_file():
                return place.read_bytes()
        raise FileNotFoundError(name)

    # (So trimesh asks for the materials of .obj.)
    __getitem__ = get


def _load(path: Path, part: str) -> Any:
    """Returns the scene of a file, or a part of it, as trimesh reads it."""
    needed = ["trimesh"] + ["collada"] * (path.suffix.lower() == ".dae")
    for name in needed:
        if importlib.util.find_spec(name) is None:
            raise ValueError(
                f"to read {path.name} takes trimesh and pycollada: pip install"
                " 'hunav_drake[gazebo]'"
            )
    import trimesh

    textures: Any = _Textures(path.parent)
    kind = path.suffix.lower()[1:]
    options = {"split_objects": True} if part and kind == "obj" else {}
    content = path.read_bytes()
    if part and kind == "dae":
        content = _collada_part(path.name, content, part)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(
                io.BytesIO(content),
                file_type=kind,
                resolver=textures,
                # (Otherwise, what is not finite is left out in silence.)
                process=False,
                **options,
            )
    # Readers of damaged files raise anything.
    except Exception as error:
        words = " ".join(f"{error}".split())[:200] or type(error).__name__
        raise ValueError(
            f"the mesh {path.name} cannot be read: {words}; export it anew"
        ) from error
    return scene


def _collada_part(name: str, content: bytes, part: str) -> bytes:
    """Returns a file of COLLADA without the geometry of other nodes.

    A part has the name or id of a node, as in Gazebo, or of a geometry.
    """
    from defusedxml.common import DefusedXmlException
    from defusedxml.ElementTree import ParseError, fromstring, tostring

    try:
        top = fromstring(content)
    except (ParseError, DefusedXmlException, ValueError) as error:
        raise ValueError(
            f"the mesh {name} cannot be read: {error}; export it anew"
        ) from error
    ids = {part} | {
        it.get("id")
        for it in top.iter()
        if it.tag.endswith("}geometry") and it.get("name") == part
    }
    names, kept_ones = [], 0
    for node in top.iter():
        for it in list(node):
            if not it.tag.endswith("}instance_geometry"):
                continue
            url = it.get("url", "").removeprefix("#")
            names.append(node.get("name") or url)
            if url in ids or part in (node.get("name"), node.get("id")):
                kept_ones += 1
            else:
                node.remove(it)
    if not kept_ones:
        raise ValueError(_no_part(name, part, names))
    text: bytes = tostring(top)
    return text


def _no_part(name: str, part: str, names: Iterable[str]) -> str:
    known = ", ".join(itertools.islice(names, 5))
    have = f"; it has {known}" * bool(known)
    return (
        f"the mesh {name} has no part {part!r} with triangles{have};"
        " export it anew"
    )


def _scene(path: Path, part: str, centered: bool) -> Any:
    """Returns a scene in meters, of checked geometry."""
    subject = f"the mesh {path.name}"
    scene, unit = _load(path, part), _unit(path)
    import trimesh

    result = trimesh.Scene()
    names = []
    is_chosen = not part or path.suffix.lower() == ".dae"
    for mesh, (node, name), X in _meshes(scene):
        names.append(node)
        given = (node, name, mesh.metadata.get("name"))
        if not is_chosen and part not in given:
            continue
        mesh = mesh.copy()
        mesh.apply_transform(X)
        if path.suffix.lower() in (".gltf", ".glb"):
            mesh.apply_transform(_Y_UP)
        mesh.apply_scale(unit)
        result.add_geometry(mesh)
    triangles = _triangles(result)
    if not len(triangles):
        raise ValueError(
            _no_part(path.name, part, names)
            if part
            else f"{subject} has no triangles; export it anew"
        )
    if len(triangles) > _MOST_TRIANGLES:
        raise ValueError(
            f"{subject} must have at most {_MOST_TRIANGLES} triangles, got"
            f" {len(triangles)}; simplify it"
        )
    if not np.abs(triangles).max() <= _FARTHEST:
        raise ValueError(
            f"{subject} has corners that are not finite, or farther than"
            f" {_FARTHEST:g} from its origin; correct them, or its unit"
        )
    if centered:
        middle = result.bounds.mean(axis=0)
        for mesh in result.geometry.values():
            mesh.apply_translation(-middle)
    return result


def _meshes(scene: Any) -> Iterator[tuple[Any, tuple[str, str], Array]]:
    """Yields the meshes of a scene, with those of nodes in it.

    Each comes with the names of its node and of itself, and its pose (4, 4).
    """
    for node in scene.graph.nodes_geometry:
        X, name = scene.graph[node]
        mesh = scene.geometry[name]
        if getattr(mesh, "faces", None) is not None and len(mesh.faces):
            yield mesh, (str(node), str(name)), X


def _unit(path: Path) -> float:
    """Returns the length of a mesh's unit, in meters: only .dae have one."""
    if path.suffix.lower() != ".dae":
        return 1.0
    plain = re.sub(rb"<!--.*?-->", b"", path.read_bytes(), flags=re.DOTALL)
    given = _UNIT.search(plain)
    text = given[1].decode(errors="replace") if given else "1"
    try:
        unit = float(text)
    except ValueError:
        unit = 0.0
    if not 1e-9 < unit < 1e9:
        raise ValueError(
            f"the mesh {path.name} must have a unit above 0 m, got"
            f" {text!r:.60}; correct <unit meter=...>"
        )
    return unit


def _triangles(scene: Any) -> Array:
    found = [
        mesh.triangles.reshape(-1, 3, 3) for mesh in scene.geometry.values()
    ]
    return np.concatenate([np.zeros((0, 3, 3)), *found])


def _cut(scene: Any, cut: tuple[Any, float] | None) -> list[Any]:
    """Returns the meshes of a scene, cut off at a height: see `obj_of`."""
    parts = list(scene.geometry.values())
    if cut is None:
        return parts
    X, height = cut
    # The plane z = height there, in the frame of the mesh.
    normal = -X[2, :3]
    origin = normal * (X[2, 3] - height) / (normal**2).sum()
    parts = [mesh.slice_plane(origin, normal) for mesh in parts]
    return [mesh for mesh in parts if len(mesh.faces)]


def _write_obj(
    folder: Path,
    parts: list[Any],
    color: tuple[float, ...] | None,
    is_plain: bool,
) -> None:
    """Writes model.obj with its materials; nothing if there are no parts."""
    lines: list[str] = []
    materials: list[str] = []
    start = 1
    # (After a part with a color, one without would have that one.)
    is_plain &= color is None
    is_plain &= all(mesh.visual.kind is None for mesh in parts)
    for i, mesh in enumerate(parts):
        image, own = (None, color) if color else _look(mesh)
        r, g, b, opacity = own
        mesh.merge_vertices()
        if not is_plain:
            lines.append(f"usemtl m{i}")
            materials.append(f"newmtl m{i}\nKd {r:.3f} {g:.3f} {b:.3f}")
            # (Many files have an opacity of 0, and mean 1.)
            if 0.02 < opacity < 1:
                materials.append(f"d {opacity:.3f}")
        if image is not None:
            image.save(folder / f"m{i}.png", optimize=True)
            materials.append(f"map_Kd m{i}.png")
        uv = getattr(mesh.visual, "uv", None)
        if uv is None or not np.isfinite(uv).all():
            uv = np.zeros((len(mesh.vertices), 2))
        lines += [f"v {x:.7g} {y:.7g} {z:.7g}" for x, y, z in mesh.vertices]
        lines += [f"vt {u:.4f} {v:.4f}" for u, v, *_ in uv]
        normals = mesh.vertex_normals
        lines += [f"vn {x:.2f} {y:.2f} {z:.2f}" for x, y, z in normals]
        for a, b, c in (mesh.faces + start).tolist():
            lines.append(f"f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")
        start += len(mesh.vertices)
    if parts:
        if materials:
            lines.insert(0, "mtllib model.mtl")
            (folder / "model.mtl").write_text("\n".join(materials) + "\n")
        (folder / "model.obj").write_text("\n".join(lines) + "\n")


def _look(mesh: Any) -> tuple[Any, Any]:
    """Returns the small texture of a mesh, or None, and its color (4,)."""
    material = getattr(mesh.visual, "material", None)
    if material is None:
        return None, mesh.visual.main_color / 255.0
    image = getattr(material, "image", None)
    if image is None:
        image = getattr(material, "baseColorTexture", None)
    color = np.asarray(material.main_color) / 255.0
    if image is None or getattr(mesh.visual, "uv", None) is None:
        return None, color
    try:
        image = image.convert("RGB")
    except (OSError, ValueError):
        return None, color
    image.thumbnail((_TEXTURE, _TEXTURE))
    return image.quantize(128, method=2), (1.0, 1.0, 1.0, 1.0)
