"""Adds models of files (SDF, URDF, model directives) to a plant."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import hashlib
from html import escape
import logging
from pathlib import Path
import re
from typing import Any

from pydrake.geometry import (
    HalfSpace,
    MakeRenderEngineVtk,
    RenderEngineVtkParams,
    Role,
    SceneGraph,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import PackageMap, Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from hunav_drake.systems.common.models.apart import (
    ModelFault,
    drake_words,
    try_apart,
)
from hunav_drake.systems.common.models.markup import find_markup_fault
from hunav_drake.systems.common.models.xacro import (
    DRAKES,
    RobotText,
    drakes_mesh,
    mesh_path,
    nearby_packages,
    read_robot,
    without_comments,
)
from hunav_drake.systems.common.suggest import shown, suggestion

# The endings of files that a world may be made of.
_ENDINGS = (".sdf", ".urdf", ".dmd.yaml", ".world")

_MARKUP = (".sdf", ".world")

# Models below this folder are those of the package, which are sound.
_OWN = Path(__file__).resolve().parents[2]

# A plane among collision shapes, and elements for simulators, of which Drake
# knows few; the name of a mesh; and a file that is named relative to the text.
_LEFT_OUT = re.compile(
    r"<collision\b(?:(?!</collision>).)*?<plane\b.*?</collision>"
    r"|<(sensor|plugin)\b[^>]*(?:/>|(?<!/)>(?:(?!<\1\b).)*?</\1\s*>)",
    re.DOTALL,
)
_MESH = re.compile(
    r"(<mesh\b(?:(?!</mesh>).)*?<uri>\s*)([^<>]*?)(\s*</uri>)", re.DOTALL
)
_RELATIVE = re.compile(r"(<uri>\s*)([^<>:/\s][^<>:]*?)(\s*</uri>)")


def AddModels(
    plant: MultibodyPlant,
    file: str,
    packages: Mapping[str, str] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> list[ModelInstanceIndex]:
    """Adds the models of a file to a plant.

    Args:
        plant: The plant, which is not finalized.
        file: A path, or "package://name/...": of a package that Drake knows,
            of "hunav_drake", or of one in ROS_PACKAGE_PATH.
        packages: Folders of further packages by name.
        arguments: The values of xacro's arguments.

    Returns:
        The instances of the models.

    Raises:
        ModelFault: If the file or a folder is not there, or the file cannot be
            read.
    """
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    known = parser.package_map()
    _AddPackages(known, file, packages or {})
    path = _path_of(known, file)
    robot = None
    try:
        text = _sdf_text(known, path)
        robot = _robot_text(known, path, arguments)
        if robot is not None and robot.is_changed:
            # (Drake repeats what it warns of at each reading.)
            with _quiet():
                found = parser.AddModelsFromString(robot.text, "urdf")
        elif text is not None:
            with _quiet():
                found = parser.AddModelsFromString(text, "sdf")
        elif file.startswith("package://"):
            found = parser.AddModels(url=file)
        else:
            found = parser.AddModels(file)
    except ModelFault:
        raise
    except (RuntimeError, ValueError, SystemExit, OSError) as error:
        name = path.name if robot is None else robot.name
        words = re.sub(
            r"<literal-string>\.(?:urdf|sdf)",
            lambda _: name,
            drake_words(error),
        )
        raise ModelFault(
            ("file",),
            f"cannot be read: {words}; correct that in the file,"
            " a URDF, SDF, MJCF or directives file that Drake reads",
        ) from error
    return list(found)


def check_model_file(
    file: str,
    packages: Mapping[str, str],
    function: str,
    *values: Any,
    arguments: Mapping[str, str] | None = None,
) -> None:
    """Checks a foreign file before this process reads it.

    Its text is checked; and then, once for each content, a function
    ("module:name") tries it in a process of its own, as Drake may crash. It
    takes file, packages (see `AddModels`) and values that JSON can hold, of
    which the `arguments` of xacro are the last one, if there are any.

    Raises:
        ModelFault: If it has a fault.
    """
    known = PackageMap()
    _AddPackages(known, file, packages)
    path = _path_of(known, file)
    if path.resolve().is_relative_to(_OWN):
        return
    try:
        content = path.read_bytes()
        robot = _robot_text(known, path, arguments)
        if robot is not None:
            content = robot.text.encode()
            fault = find_markup_fault(Path(robot.name), robot.text)
        else:
            text = _sdf_text(known, path)
            fault = (
                find_markup_fault(path, text) if path.suffix in _MARKUP else ""
            )
    except OSError as error:
        fault = str(error.strerror)
    if fault:
        raise ModelFault(("file",), f"cannot be read: {fault}")
    # The files that it names may differ for another file of the same content.
    names_files = re.search(rb"filename|uri|file:|include|file=", content)
    key = (
        hashlib.sha256(content).hexdigest(),
        str(path.resolve()) if names_files else path.suffix,
        *map(str, (*sorted(packages.items()), *values)),
    )
    if arguments:
        values = (*values, dict(arguments))
    try_apart(key, function, file, dict(packages), *values)


def AddModelFile(
    plant: MultibodyPlant, filename: str, pose: tuple[float, float, float]
) -> list[ModelInstanceIndex]:
    """Adds the models of a file to a plant, all fixed to the world.

    Planes among collision shapes are left out: a trial has a floor.

    Args:
        plant: The plant, which is not finalized.
        filename: A path or "package://name/...": see `AddModels`.
        pose: The pose of the models: (x, y, yaw) in W, in meters and radians;
            zero if the file fixes its models to the world.

    Returns:
        The instances of the models.

    Raises:
        ValueError: If the file cannot be read, or if it fixes its models to
            the world and another pose is given.
    """
    if not filename.endswith(_ENDINGS):
        raise ValueError(
            f"{filename}: must be one of {', '.join(_ENDINGS)}, by its name"
        )
    try:
        check_model_file(filename, {}, f"{__name__}:try_model_file")
        with _quiet():
            instances = AddModels(plant, filename)
    except ModelFault as fault:
        raise ValueError(f"{filename}: {fault}") from fault
    X_WM = RigidTransform(RollPitchYaw(0, 0, pose[2]), [*pose[:2], 0.0])
    free = list(_free_bodies(plant, instances))
    if not free and tuple(pose) != (0.0, 0.0, 0.0):
        raise ValueError(
            f"{filename}: fixes its models to the world by itself; leave pose"
            " out, or make them free (no static, no weld to the world)"
        )
    for body in free:
        X_MB = plant.GetDefaultFloatingBaseBodyPose(body)
        plant.WeldFrames(plant.world_frame(), body.body_frame(), X_WM @ X_MB)
    return instances


def robot_text(
    file: str,
    packages: Mapping[str, str],
    arguments: Mapping[str, str] | None = None,
) -> RobotText | None:
    """Returns the URDF of a file, and what it is made of.

    It is None if the file has another format. For arguments and errors, see
    `AddModels`.
    """
    known = PackageMap()
    _AddPackages(known, file, packages)
    try:
        return _robot_text(known, _path_of(known, file), arguments)
    except OSError as error:
        raise ModelFault(("file",), f"cannot be read: {error}") from error


def _robot_text(
    known: PackageMap, path: Path, arguments: Mapping[str, str] | None
) -> RobotText | None:
    return read_robot(path, _folders(known), arguments or {})


def check_pictures(
    file: str,
    packages: Mapping[str, str],
    arguments: Mapping[str, str] | None = None,
) -> None:
    """Checks that cameras can take pictures of the models of a file.

    Raises:
        ModelFault: If they cannot.
    """
    function = f"{__name__}:try_model_file"
    check_model_file(file, packages, function, True, arguments=arguments)


def try_model_file(
    filename: str,
    packages: dict[str, str],
    is_seen: bool = False,
    arguments: dict[str, str] | None = None,
) -> None:
    """Reads a file as a world does, and makes a Context with its shapes.

    The arguments are those of `AddModels`, and `is_seen`, whether there is a
    camera. If the file cannot be read, a ModelFault says so.
    """
    scene_graph = SceneGraph()
    if is_seen:
        engine = MakeRenderEngineVtk(RenderEngineVtkParams())
        scene_graph.AddRenderer("pictures", engine)
    plant = MultibodyPlant(time_step=0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    AddModels(plant, filename, packages, arguments)
    refuse_planes(scene_graph)
    plant.Finalize()
    scene_graph.CreateDefaultContext()


def refuse_planes(scene_graph: SceneGraph) -> None:
    """Checks for collision planes, which `AddModels` could not leave out.

    Raises:
        ModelFault: If there is one.
    """
    inspector = scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        if isinstance(inspector.GetShape(geometry), HalfSpace):
            raise ModelFault(
                ("file",),
                "has the plane"
                f" {shown(inspector.GetName(geometry))} among its collision"
                " shapes, which crashes Drake beside many others; take it out:"
                " a trial has a floor",
            )


def file_path(file: str) -> Path:
    """Returns the path of a file, which `AddModels` may be given.

    Raises:
        ModelFault: If the file, or its package, is not there.
    """
    known = PackageMap()
    _AddPackages(known, file, {})
    return _path_of(known, file)


def _AddPackages(
    known: PackageMap, file: str, packages: Mapping[str, str]
) -> None:
    known.PopulateFromRosPackagePath()
    for name, folder in {
        "hunav_drake": str(Path(__file__).parents[3]),
        **packages,
    }.items():
        if not Path(folder).is_dir():
            raise ModelFault(
                ("packages", name),
                f"there is no folder {shown(folder)}; check the path",
            )
        if known.Contains(name):
            known.Remove(name)
        known.Add(name, str(Path(folder).resolve()))
    if not file.startswith("package://"):
        for folder_above in Path(file).resolve().parents:
            if (folder_above / "package.xml").is_file():
                known.AddPackageXml(str(folder_above / "package.xml"))
                break
        for name, folder in nearby_packages(file).items():
            if not known.Contains(name):
                known.Add(name, folder)


def _path_of(known: PackageMap, file: str) -> Path:
    """Returns the path of a file."""
    path = Path(file)
    if file.startswith("package://"):
        name, _, rest = file.removeprefix("package://").partition("/")
        if not known.Contains(name):
            names = [it for it in known.GetPackageNames() if it != "drake"]
            raise ModelFault(
                ("file",),
                f"there is no package {shown(name)};"
                f" {suggestion(name, names)}; put its folder into"
                " ROS_PACKAGE_PATH, or, of a robot, under packages",
            )
        path = Path(known.GetPath(name)) / rest
    if not path.is_file():
        raise ModelFault(
            ("file",), f"there is no file {shown(file)}; check the path"
        )
    return path


def _sdf_text(known: PackageMap, path: Path) -> str | None:
    """Returns SDF that Drake reads; None if it is to be read as is.

    Beside some ten other shapes, planes crash Drake; it shows few formats of
    meshes; and the name of a file must tell Drake its format.
    """
    if path.suffix not in _MARKUP:
        return None
    raw = path.read_text(encoding="utf-8", errors="replace")
    plain = without_comments(raw)
    # (The innermost first: plugins may have plugins.)
    text, count = plain, 1
    while count:
        text, count = _LEFT_OUT.subn(lambda it: "\n" * it[0].count("\n"), text)
    folder, folders = path.resolve().parent, _folders(known)

    def shown_mesh(match: re.Match[str]) -> str:
        named = mesh_path(match[2], folder, folders)
        mesh = drakes_mesh(named)
        uri = (
            match[2] if mesh in (None, named) else f"file://{escape(str(mesh))}"
        )
        return f"{match[1]}{uri}{match[3]}"

    text = _MESH.sub(shown_mesh, text)
    if text == plain and path.suffix == ".sdf":
        return None
    return _RELATIVE.sub(
        lambda it: f"{it[1]}file://{escape(str(folder))}/{it[2]}{it[3]}", text
    )


def _folders(known: PackageMap) -> dict[str, str]:
    # (Drake downloads its packages when their folders are asked for.)
    names = [it for it in known.GetPackageNames() if it not in DRAKES]
    return {name: known.GetPath(name) for name in names}


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppresses warnings of Drake."""
    log = logging.getLogger("drake")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(level)


def _free_bodies(
    plant: MultibodyPlant, instances: list[ModelInstanceIndex]
) -> Any:
    """Yields the bodies of some models that no joint holds."""
    held = {
        int(plant.get_joint(j).child_body().index())
        for j in plant.GetJointIndices()
    }
    for instance in instances:
        for index in plant.GetBodyIndices(instance):
            if int(index) not in held:
                yield plant.get_body(index)
