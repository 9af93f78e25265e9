"""The files that a scenario names, and the files that these name in turn.

A map has an image, a model has meshes, textures and other models. Behavior
trees do not count as files, since `tree_fingerprint` covers them.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
import contextlib
import dataclasses as dc
import hashlib
import html
import json
import os
from pathlib import Path
import re
from typing import Any
from urllib.parse import unquote

from pydrake.multibody.parsing import PackageMap
import yaml

from hunav_drake.scenario.fleet import robot_parts
from hunav_drake.scenario.population import draw_people
from hunav_drake.scenario.schema import Scenario
from hunav_drake.scenario.writer import plain
from hunav_drake.systems.robot import UrdfRobot
from hunav_drake.systems.world.shapes import Model

_YAML = (".yaml", ".yml")
_WAVEFRONT = (".obj", ".mtl")
_MARKUP = (".urdf", ".sdf", ".world", ".xml", ".xacro", ".config", ".dae")

# The places of file names in texts: attributes and text between tags in markup;
# after some keywords in Wavefront meshes and materials.
_MARKED = (
    re.compile(r"=\s*\"([^\"]{1,500})\""),
    re.compile(r"=\s*'([^']{1,500})'"),
    re.compile(r">([^<>]{1,500})<"),
)
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_REFERENCE = re.compile(
    r"^[ \t]*(?:mtllib|map_\w+|bump|disp|decal|refl|norm)[ \t]([^\n]{1,500})$",
    re.MULTILINE,
)


def files_sha256(scenario: Scenario) -> str:
    """Returns a hash of the contents of all named files; empty without files.

    Their folders do not matter.

    Raises:
        OSError: If one of them cannot be read.
    """
    lines = []
    for path in named_files(scenario):
        with path.open("rb") as file:
            content = hashlib.file_digest(file, "sha256").hexdigest()
        lines.append(f"{path.name} {content}\n")
    if not lines:
        return ""
    return hashlib.sha256("".join(sorted(lines)).encode()).hexdigest()


def behavior_sha256(scenario: Scenario) -> str:
    """Returns a hash of all behavior trees that a scenario names."""
    # Imported here: only reading or writing needs no systems.
    from hunav_drake.systems.behavior import LoadBehavior
    from hunav_drake.systems.behavior.fingerprint import tree_fingerprint

    people = draw_people(scenario)
    # Most people have one of a few behaviors.
    prints = {
        key: tree_fingerprint(
            LoadBehavior(behavior, profile=scenario.crowd.profile)
        )
        for key, behavior in {
            repr(human.behavior): human.behavior for human in people
        }.items()
    }
    all_prints = (prints[repr(human.behavior)] for human in people)
    return hashlib.sha256("".join(all_prints).encode()).hexdigest()


def named_files(scenario: Scenario) -> list[Path]:
    """Returns all files that a scenario names, and those that they name.

    Every text in a scenario that is the name of a file counts, also in
    parameters of user-defined planners, robots and motion models. A folder
    that is a parameter of planner or robot stands for all files in it.
    """
    parts = [
        getattr(scenario, field.name)
        for field in dc.fields(scenario)
        if field.name not in ("humans", "population")
    ]
    parts += [
        tracks.file
        for tracks in (
            scenario.population.tracks,
            *(human.track for human in scenario.humans),
        )
        if tracks is not None
    ]
    here = Path.cwd()
    robots = [part.scenario for part in robot_parts(scenario)]
    packages = _packages([plain(it.robot) for it in robots])
    found: dict[Path, None] = {}
    todo: list[Path] = []
    for text in dict.fromkeys(_texts(parts)):
        todo += _find(text, [here], packages)
    for part in (part for it in robots for part in (it.planner, it.robot)):
        for text in _free_texts(part):
            if re.search(r"\w", text) and os.path.isdir(here / text):
                todo += _files_in(here / text)
    for robot in (it.robot for it in robots):
        if isinstance(robot, UrdfRobot):
            todo += _xacro_files(robot, packages)
    for model in scenario.world.models:
        todo += _of_gazebo(model)
    while todo:
        path = todo.pop()
        if path not in found:
            found[path] = None
            todo += _named_in(path, packages)
    return sorted(found)


def _xacro_files(robot: UrdfRobot, packages: Mapping[str, Path]) -> list[Path]:
    """Returns the files that a robot's file of xacro includes, and meshes."""
    # Imported here: most scenarios do not need Drake's parser.
    from hunav_drake.systems.common.models import apart, reading, xacro

    try:
        found = reading.robot_text(robot.file, robot.packages, robot.arguments)
    except apart.ModelFault:
        found = None
    if found is None or len(found.files) < 2:
        return []
    places = [Path(robot.file), *found.files]
    near = [xacro.nearby_packages(it) for it in places]
    known = {
        name: Path(folder)
        for folders in near
        for name, folder in folders.items()
    } | {**packages}
    folder = Path(robot.file).parent
    named = [it[1] for it in _MARKED[0].finditer(found.text)]
    meshes = (it for name in named for it in _find(name, [folder], known))
    return [*(it.resolve() for it in found.files), *meshes]


def _of_gazebo(model: Model) -> Sequence[Path]:
    """Returns the files that a world of Gazebo names."""
    # Imported here: most scenarios have no such world.
    from hunav_drake.systems.common.models import apart, gazebo

    with contextlib.suppress(apart.ModelFault):
        if gazebo.is_gazebo_file(model.file):
            return gazebo.read_gazebo(
                model.file, model.model_path, model.skip_missing
            ).files
    return ()


def _texts(data: Any) -> Iterator[str]:
    """Yields all texts in data except keys of mappings."""
    if isinstance(data, str):
        yield data
    elif isinstance(data, Mapping):
        data = list(data.values())
    elif dc.is_dataclass(data):
        data = [getattr(data, field.name) for field in dc.fields(data)]
    if isinstance(data, list | tuple):
        for item in data:
            yield from _texts(item)


def _free_texts(value: Any, kind: Any = None) -> Iterator[str]:
    """Yields the texts of a configuration that are not of a fixed choice."""
    if dc.is_dataclass(value):
        for field in dc.fields(value):
            # Of a package, only the files that other files name count.
            if field.name != "packages":
                yield from _free_texts(getattr(value, field.name), field.type)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _free_texts(item, kind)
    elif "Literal" not in str(kind):
        yield from _texts(value)


def _files_in(folder: Path) -> Iterator[Path]:
    """Yields the files of a folder, except for those of Python's cache."""
    for path in folder.rglob("*"):
        if path.is_file() and "__pycache__" not in path.parts:
            yield path.resolve()


def _packages(robots: Iterable[Any]) -> dict[str, Path]:
    """Returns the folders of packages, as for models of robots and worlds."""
    known = PackageMap.MakeEmpty()
    known.PopulateFromRosPackagePath()
    given: dict[str, str] = {}
    for robot in robots:
        if isinstance(robot, Mapping):
            given |= robot.get("packages") or {}
    return {
        **{name: Path(known.GetPath(name)) for name in known.GetPackageNames()},
        "hunav_drake": Path(__file__).resolve().parents[1],
        **{name: Path(it) for name, it in given.items()},
    }


def _named_in(path: Path, packages: Mapping[str, Path]) -> Iterator[Path]:
    """Yields the files that the text of a file names."""
    names = _names_in(path)
    folders = [path.parent]
    if path.suffix.lower() == ".xml":
        # MJCF gives the folder of its meshes separately.
        folders += [
            folder
            for name in names
            if re.search(r"\w", name)
            and os.path.isdir(folder := path.parent / name)
        ]
    own = dict(packages)
    for above in path.parents if names else ():
        if (above / "package.xml").is_file():
            known = PackageMap.MakeEmpty()
            known.AddPackageXml(str(above / "package.xml"))
            own = dict.fromkeys(known.GetPackageNames(), above) | own
            break
    for name in names:
        yield from _find(name, folders, own)


def _names_in(path: Path) -> list[str]:
    """Returns the possible file names in a text file, each once."""
    kind = path.suffix.lower()
    if kind not in (*_YAML, *_WAVEFRONT, *_MARKUP, ".gltf"):
        return []
    text = path.read_text(encoding="utf-8", errors="replace")
    names: list[str] = []
    if kind in _YAML:
        with contextlib.suppress(yaml.YAMLError, RecursionError):
            tokens = yaml.scan(text)
            names = [
                it.value for it in tokens if isinstance(it, yaml.ScalarToken)
            ]
    elif kind in _WAVEFRONT:
        for line in _REFERENCE.findall(text):
            # A name may follow options, and contain spaces.
            words = line.split()
            names += [line, *words]
            names += [" ".join(words[i:]) for i in range(1, len(words))]
    elif kind == ".gltf":
        with contextlib.suppress(ValueError, RecursionError):
            names = list(map(unquote, _texts(json.loads(text))))
    else:
        text = _COMMENT.sub("", text)
        found = (it for pattern in _MARKED for it in pattern.findall(text))
        names = list(map(html.unescape, found))
        if kind == ".dae":
            names += list(map(unquote, names))
    return list(dict.fromkeys(filter(None, map(str.strip, names))))


def _find(
    text: str, folders: list[Path], packages: Mapping[str, Path]
) -> Iterator[Path]:
    """Yields the files that a text names, if any."""
    scheme, mark, rest = text.partition("://")
    if mark and scheme in ("package", "model"):
        name, _, rest = rest.partition("/")
        places = [packages[name] / rest] if name in packages else []
    elif mark:
        places = [Path(rest)] if scheme == "file" else []
    elif re.search(r"\w", text):
        places = [folder / text for folder in folders]
    else:
        places = []
    for place in places:
        # Unlike the methods of Path, these accept any text.
        if os.path.isfile(place):
            yield place.resolve()
        # The folder of a model has a file that describes it.
        elif os.path.isdir(place):
            yield from _find("model.config", [place], packages)
