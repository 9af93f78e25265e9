"""Reads the URDF of robots: expands xacro, and replaces meshes in it.

Xacro is expanded without ROS, in a process of its own, by the package `xacro`
of the extra with this name. Files of xacro contain expressions of Python. Those
that could run other code are refused, and so is $(eval ...), which always can;
environment variables are not read, so that a robot follows from its files.
"""

import ast
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
import importlib.util
import math
import os
from pathlib import Path
import re
import resource
from typing import Any

from hunav_drake.systems.common.models.apart import ModelFault, call_apart
from hunav_drake.systems.common.models.mesh_files import obj_of, read_mesh
from hunav_drake.systems.common.suggest import shown, suggestion

# Packages of Drake, whose meshes it can read.
DRAKES = ("drake", "drake_models")

# The endings of meshes that Drake shows, and that bodies may touch.
_SHOWN = (".obj", ".gltf", ".vtk")

# What expressions may not do; and parts of Python's objects that lead to
# others.
_REFUSED = (ast.Lambda, ast.GeneratorExp, ast.Await)
_INNER = re.compile(r"_|(?:gi|f|tb|cr|ag|co|func)_|mro$")

# The largest memory of a process that expands a file, in bytes.
_MEMORY = 8 << 30

_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_LINK = re.compile(r"<link\b[^>]*/>|<link\b.*?</link>", re.DOTALL)
_VISUAL = re.compile(r"<visual\b[^>]*/>|<visual\b.*?</visual>", re.DOTALL)
_COLLISION = re.compile(r"<collision\b[^>]*>(.*?)</collision>", re.DOTALL)
_MATERIAL = re.compile(
    r"<material\b[^>]*/>|<material\b.*?</material>", re.DOTALL
)
_CONTROL = re.compile(r"<ros2_control\b.*?</ros2_control>", re.DOTALL)
_COMMANDED = re.compile(
    r"<joint\b[^>]*\bname=[\"']([^\"']+)[\"'][^>]*(?<!/)>"
    r"(?:(?!</joint>).)*?<command_interface\b",
    re.DOTALL,
)
_NAMED_MATERIAL = re.compile(
    r"<material\b[^>]*\bname=\"([^\"]*)\"[^>/]*(?:/>|>(.*?)</material>)",
    re.DOTALL,
)
_FILE = re.compile(
    r"(<(mesh|texture)\b[^>]*?\bfilename\s*=\s*)([\"'])(.*?)\3", re.DOTALL
)
_SCALE = re.compile(r"(?<=[\s\"'])scale\s*=\s*[\"']([^\"']*)[\"']")


@dataclass(frozen=True)
class RobotText:
    """URDF that Drake reads.

    Attributes:
        name: The name of the file, for messages.
        text: The text.
        files: The files of xacro that it is made of.
        unseen: The meshes that are not there, or that Drake cannot show: the
            collision shapes of their links are shown.
        absent: The packages that are not there; what the files include from
            them is left out.
        is_changed: Whether it differs from what is in the file.
    """

    name: str
    text: str
    files: tuple[Path, ...]
    unseen: tuple[str, ...]
    absent: tuple[str, ...]
    is_changed: bool


def nearby_packages(file: str | Path) -> dict[str, str]:
    """Returns the folders of packages around a file, by name.

    They are the nearest folder above it with a package.xml, and those beside
    it and in repositories beside its own.
    """
    for above in Path(file).resolve().parents:
        if (above / "package.xml").is_file():
            up = above.parent
            # (A repository may itself be a package.)
            depths = ("*/*/package.xml", "*/package.xml")
            found = [
                it
                for depth in depths
                if up.parent.name
                for it in up.parent.glob(depth)
            ]
            found += [*up.glob("*/package.xml"), above / "package.xml"]
            return {it.parent.name: str(it.parent) for it in sorted(found)} | {
                above.name: str(above)
            }
    return {}


def read_robot(
    path: Path, packages: Mapping[str, str], arguments: Mapping[str, str]
) -> RobotText | None:
    """Returns the URDF of a file; None if it has another format.

    Args:
        path: The file.
        packages: The folders of all packages, by name.
        arguments: The values of xacro's arguments.

    Raises:
        ModelFault: If it cannot be expanded.
        OSError: If it cannot be read.
    """
    if path.suffix not in (".urdf", ".xacro"):
        if arguments:
            raise ModelFault(
                ("arguments",),
                f"are for files of xacro, and {path.name} is none; take them"
                " out",
            )
        return None
    values = dict(arguments)
    raw = path.read_text(encoding="utf-8", errors="replace")
    text, files, absent = raw, [str(path)], list[str]()
    name = path.name
    if "<xacro:" in raw or path.suffix == ".xacro":
        text, files, absent = _expand(path, dict(packages), values)
        # Lines are those of what the command xacro prints.
        name = f"{name} (expanded)"
    else:
        known = {"namespace": "", **values}
        asked = set(re.findall(r"\$\{(\w+)\}", raw))
        _refuse_unknown(values, asked)
        text = re.sub(r"\$\{(\w+)\}", lambda it: known.get(it[1], it[0]), raw)
    folder = path.resolve().parent
    text, unseen = _with_meshes(text, folder, packages)
    text = _with_motors(text)
    named = [it[4].lower() for it in _FILE.finditer(text) if it[2] == "mesh"]
    if text != raw or not all(it.endswith(_SHOWN) for it in named):
        text = _with_paths(text, folder, packages)
    return RobotText(
        name,
        text,
        tuple(map(Path, files)),
        tuple(dict.fromkeys(unseen)),
        tuple(absent),
        text != raw,
    )


def _refuse_unknown(values: Mapping[str, str], asked: set[str]) -> None:
    for name in values:
        if name not in asked:
            raise ModelFault(
                ("arguments", name),
                f"the file has no argument {shown(name)};"
                f" {suggestion(name, sorted(asked))}",
            )


# What files expanded to, with the times and sizes of their parts.
_expanded: dict[str, tuple[tuple[str, list[str], list[str]], list[Any]]] = {}


def _expand(
    path: Path, packages: dict[str, str], values: dict[str, str]
) -> tuple[str, list[str], list[str]]:
    """Returns what `expand` returns in another process."""
    if importlib.util.find_spec("xacro") is None:
        raise ModelFault(
            ("file",),
            "is a file of xacro, which takes the package xacro to read: pip"
            " install 'hunav_drake[xacro]'",
        )
    request = [str(path.resolve()), packages, values]
    key = repr(request)
    stamps = _expanded[key][1] if key in _expanded else _stamps([str(path)])
    if key not in _expanded or stamps != _stamps([it[0] for it in stamps]):
        text, files, absent = call_apart(
            (key, repr(_stamps([it[0] for it in stamps]))),
            f"{__name__}:expand",
            *request,
        )
        _expanded[key] = (text, files, absent), _stamps(files)
    return _expanded[key][0]


def _stamps(files: list[str]) -> list[Any]:
    found = []
    for file in files:
        stat = os.stat(file) if os.path.isfile(file) else None
        found.append((file, stat and (stat.st_mtime_ns, stat.st_size)))
    return found


def expand(
    file: str, packages: dict[str, str], values: dict[str, str]
) -> tuple[str, list[str], list[str]]:
    """Expands a file of xacro, in a process that does nothing else with xacro.

    The arguments are those of `read_robot`.

    Returns:
        The text, the files that it is made of, and packages that are absent.

    Raises:
        ModelFault: If that is not possible.
    """
    import xacro
    from xacro import substitution_args

    with suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    asked: set[str] = set()
    absent: list[str] = []

    class Arguments(dict[str, str]):
        """The arguments, which remembers those that are asked for."""

        def __contains__(self, name: object) -> bool:
            asked.add(str(name))
            return super().__contains__(name)

    def find(name: str) -> str:
        if name not in packages:
            raise ModelFault(
                ("file",),
                f"{_place(xacro)} needs the package {_missing([name])}",
            )
        return packages[name]

    include_file = xacro.process_include

    def include(element: Any, macros: Any, symbols: Any, function: Any) -> None:
        """Includes a file, unless it is in a package that is not there."""
        words = re.match(
            r"\$\(find ([^\s)]+)\)", element.getAttribute("filename")
        )
        if words is None or words[1] in packages:
            include_file(element, macros, symbols, function)
            return
        absent.append(words[1])
        xacro.replace_node(element, by=None)

    xacro.process_include = include

    def variable(name: str, default: str | None = None) -> str:
        asked.add(name)
        value = values.get(name, default)
        if value is None:
            raise ModelFault(
                ("file",),
                f"{_place(xacro)} asks for the environment variable"
                f" {shown(name)}, and none is read; give it as one of the"
                f" arguments: {{{name}: VALUE}}",
            )
        return value

    def refuse(text: str, context: Any) -> str:
        raise ModelFault(
            ("file",),
            f"{_place(xacro)} has $(eval {text}), which can run any code; write"
            " it as ${...}",
        )

    changes: dict[str, Any] = {
        "_eval_find": find,
        "_eval_env": variable,
        "_eval_optenv": lambda name, default="": variable(name, default),
        "_eval": refuse,
    }
    for name, function in changes.items():
        setattr(substitution_args, name, function)
    evaluate = xacro.safe_eval

    def check_and_evaluate(text: str, *tables: Any) -> Any:
        for node in ast.walk(ast.parse(text.strip(), mode="eval")):
            name = getattr(node, "attr", "")
            if isinstance(node, _REFUSED) or _INNER.match(name):
                raise ModelFault(
                    ("file",),
                    f"{_place(xacro)} has the expression {shown(text)}, which"
                    " could run other code; write it with numbers, texts and"
                    " lists alone",
                )
        return evaluate(text, *tables)

    xacro.safe_eval = check_and_evaluate
    # These lead to others, and values of hash() differ from run to run.
    for name in ("type", "vars", "hash"):
        xacro._global_symbols["python"].pop(name, None)
    xacro.all_includes.clear()
    try:
        document = xacro.process_file(
            file, mappings=(known := Arguments(values)), verbosity=0
        )
        text = document.documentElement.toprettyxml(indent=" ")
    except Exception as error:
        while not isinstance(error, ModelFault):
            inner = getattr(error, "exc", None) or error.__cause__
            if not isinstance(inner, Exception):
                break
            error = inner
        if isinstance(error, ModelFault):
            raise error from None
        words = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, RecursionError):
            words = "includes or macros are in each other without an end"
        remedy = "correct that in the file"
        if absent:
            remedy = f"that may be from the package {_missing(absent)}"
        raise ModelFault(
            ("file",),
            f"cannot be expanded: {_place(xacro)}: {words[:300]}; {remedy}",
        ) from None
    _refuse_unknown(values, asked | (set(known) - set(values)))
    files = [file, *map(str, xacro.all_includes)]
    return text, list(dict.fromkeys(files)), list(dict.fromkeys(absent))


def _missing(names: list[str]) -> str:
    """Returns what is to be done about packages that are not there."""
    words = ", ".join(map(shown, dict.fromkeys(names)))
    return (
        f"{words}, not there; clone its repository beside that of the file, or"
        f" name its folder: packages: {{{names[0]}: FOLDER}}"
    )


def _place(module: Any) -> str:
    """Returns the name of the file that xacro is at."""
    return Path((module.filestack or ["it"])[-1]).name


def without_comments(text: str) -> str:
    """Returns markup without comments; lines stay what they are."""
    return _COMMENT.sub(lambda it: "\n" * it[0].count("\n"), text)


def _with_meshes(
    text: str, folder: Path, packages: Mapping[str, str]
) -> tuple[str, list[str]]:
    """Returns URDF without visual meshes that cannot be read, and their names.

    Lines stay what they are. In their place are the collision shapes of the
    link; and these but meshes, if the file has no visual at all.
    """
    unseen: list[str] = []
    plain = without_comments(text)
    is_bare = not _VISUAL.search(plain)

    def is_seen(visual: str) -> bool:
        names = [it[4] for it in _FILE.finditer(visual) if it[2] == "mesh"]
        bad = [name for name in names if not _is_seen(name)]
        unseen.extend(bad)
        return not bad

    def _is_seen(name: str) -> bool:
        if name.strip().startswith(tuple(f"package://{it}/" for it in DRAKES)):
            return True
        path = mesh_path(name, folder, packages)
        return drakes_mesh(path) is not None

    def link(match: re.Match[str]) -> str:
        looks: list[str] = []

        def visual(match: re.Match[str]) -> str:
            if is_seen(match[0]):
                return _unmirrored(match[0], folder, packages)
            found = _MATERIAL.search(match[0])
            looks.append(found[0].replace("\n", " ") if found else "")
            return "\n" * match[0].count("\n")

        rest = _VISUAL.sub(visual, match[0])
        instead = "".join(
            f"<visual>{it[1]}{''.join(looks[:1])}</visual>".replace("\n", " ")
            for it in _COLLISION.finditer(rest)
            if looks or (is_bare and "<mesh" not in it[1])
        )
        return rest.replace("</link>", f"{instead}</link>")

    result = _LINK.sub(link, plain)
    defined = {
        it[1] for it in _NAMED_MATERIAL.finditer(result) if "<" in (it[2] or "")
    }
    result = _NAMED_MATERIAL.sub(
        lambda it: it[0] if it[1] in defined else "", result
    )
    return (text if result == plain else result), unseen


def _unmirrored(visual: str, folder: Path, packages: Mapping[str, str]) -> str:
    """Returns a visual with a mesh that is mirrored itself, not by its scale.

    Drake lights meshes with a negative scale from inside.
    """
    scale = _SCALE.search(visual)
    try:
        x, y, z = map(float, scale[1].split() if scale else ())
        if min(x, y, z) >= 0:
            return visual
        (file,) = (it for it in _FILE.finditer(visual) if it[2] == "mesh")
        signs = math.copysign(1, x), math.copysign(1, y), math.copysign(1, z)
        mesh = read_mesh(mesh_path(file[4], folder, packages))
        path = obj_of(mesh, signs=signs, is_plain=True)
    # What cannot be read otherwise is shown as it is.
    except ValueError:
        return visual
    instead = f"{file[1]}{file[3]}file://{path}{file[3]}"
    visual = visual.replace(file[0], instead)
    return _SCALE.sub(f'scale="{abs(x)} {abs(y)} {abs(z)}"', visual, count=1)


def _with_paths(text: str, folder: Path, packages: Mapping[str, str]) -> str:
    """Returns URDF with absolute paths of meshes, as files that Drake reads."""

    def absolute(match: re.Match[str]) -> str:
        path = mesh_path(match[4], folder, packages)
        path = (drakes_mesh(path) if match[2] == "mesh" else None) or path
        if not path.is_file():
            return match[0]
        return f"{match[1]}{match[3]}file://{path}{match[3]}"

    return _FILE.sub(absolute, text)


def _with_motors(text: str) -> str:
    """Adds motors for the joints that ros2_control commands, if none has one.

    Drake reads motors from <transmission> alone; without one, an arm would hang
    down.
    """
    moved = {
        name
        for block in _CONTROL.findall(text)
        for name in _COMMANDED.findall(block)
        if re.search(
            rf"<joint\b(?=[^>]*\btype=)[^>]*\bname=.{re.escape(name)}[\"']",
            text,
        )
    }
    if not moved or "<transmission" in _CONTROL.sub("", text):
        return text
    motors = "".join(
        f'<transmission name="{name}_motor"><type>SimpleTransmission</type>'
        f'<joint name="{name}"/><actuator name="{name}"/></transmission>'
        for name in sorted(moved)
    )
    return text.replace("</robot>", f"{motors}</robot>")


def mesh_path(name: str, folder: Path, packages: Mapping[str, str]) -> Path:
    """Returns the path of a mesh that a file in a folder names."""
    scheme, mark, rest = name.strip().partition("://")
    if not mark:
        return folder / scheme
    if scheme == "file":
        return Path(rest)
    package, _, rest = rest.partition("/")
    return Path(packages.get(package, "/nowhere")) / rest


def drakes_mesh(path: Path) -> Path | None:
    """Returns a file that Drake reads for a mesh; None if there is none."""
    if path.suffix.lower() in _SHOWN:
        return path if path.is_file() else None
    try:
        return obj_of(read_mesh(path), is_plain=True)
    except ValueError:
        return None
