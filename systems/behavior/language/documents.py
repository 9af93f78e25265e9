"""Reads a file of trees and the files that it includes."""

from dataclasses import dataclass, field
import functools
import os
from pathlib import Path
import re

from hunav_drake.systems.behavior.language.blackboard import GIVEN
from hunav_drake.systems.behavior.language.tree_ports import (
    TreePort,
    declared_ports,
)
from hunav_drake.systems.behavior.language.xml_source import (
    MAX_BYTES,
    NOTES,
    XmlElement,
    read_xml,
)
from hunav_drake.systems.behavior.nodes.errors import BehaviorTreeError, Place
from hunav_drake.systems.behavior.nodes.registry import (
    NODE_TYPES,
    RESERVED,
    SUBTREE_TAGS,
)
from hunav_drake.systems.common.suggest import shown

MAX_FILES = 100

# The files of HuNavSim's own trees, which other trees include. They are among
# those of this package, under other names.
_OF_HUNAVSIM = re.compile(
    r"BT(Regular|Impassive|Surprised|Scared|Curious|Threatening)Nav\.xml"
)

_ROOT_ATTRIBUTES = ("BTCPP_format", "main_tree_to_execute", "project_name")


@dataclass(frozen=True)
class TreeElement:
    """A <BehaviorTree>, and the format of the file that it is in."""

    element: XmlElement
    format: int


@dataclass(eq=False)
class Documents:
    """A file of trees and the files that it includes, not to be changed.

    Documents of the same text are equal, and can be the key of a cache.

    Attributes:
        sources: The name and the bytes of each file, in the order of reading.
        trees: The trees by their ID.
        main: The ID of the tree to begin with.
        folder: The folder from which, or from below which, files can be
            included; None for none.
        libraries: Folders that hold included files which are not in `folder`,
            and trees, by ID, that are in none of the files.
        allow_outside: Whether files can be included from anywhere.
        read: The files that were read.
        open: The files that are being read: each includes the next.
        ports: The ports of trees by the ID of the tree and their names.
        models: The <TreeNodesModel> elements that declare these.
        comments: The comments before the root element of the main file.
    """

    sources: list[tuple[str, bytes]] = field(default_factory=list)
    trees: dict[str, TreeElement] = field(default_factory=dict)
    main: str = ""
    folder: Path | None = None
    libraries: tuple[Path, ...] = ()
    allow_outside: bool = False
    read: set[Path] = field(default_factory=set)
    open: list[Path] = field(default_factory=list)
    ports: dict[str, dict[str, TreePort]] = field(default_factory=dict)
    models: list[XmlElement] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)

    @property
    def file(self) -> str:
        """The main file, or its name in messages."""
        return self.sources[0][0]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Documents) and self.sources == other.sources

    def __hash__(self) -> int:
        return hash(tuple(self.sources))

    def main_ports(self) -> dict[str, TreePort]:
        """Returns the ports of the main tree that can be set by the user."""
        ports = self.ports.get(self.main, {})
        return {name: it for name, it in ports.items() if name not in GIVEN}


def read_file(path: Path) -> bytes:
    """Returns the content of a file, at most a byte more than is accepted."""
    try:
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise BehaviorTreeError(
            f"cannot be read: {error.strerror}", Place(str(path))
        ) from error


def load_documents(
    source: bytes,
    file: str,
    folder: Path | None = None,
    *,
    libraries: tuple[Path, ...] = (),
    allow_outside: bool = False,
) -> Documents:
    """Reads a document and those that it includes.

    A subtree that is in none of them comes from the first library that has a
    tree of that ID.

    Args:
        source: The document.
        file: The name of the document in messages.
        folder: The folder that its includes are relative to.
        libraries: Folders with trees of this package, which files in any
            folder may include as if they lay beside them.
        allow_outside: Whether files may be included that are not in the folder
            or below. Leave it False for a tree from elsewhere, which could
            make any file be read.

    Raises:
        BehaviorTreeError: If a document is not a tree file.
    """
    documents = Documents(
        folder=folder.resolve() if folder else None,
        libraries=libraries,
        allow_outside=allow_outside,
    )
    if documents.folder:
        documents.open.append(documents.folder / Path(file).name)
    root = _load(source, file, documents.folder, documents)
    documents.comments = root.comments
    _load_missing(documents)
    own = [
        tree_id
        for tree_id, tree in documents.trees.items()
        if tree.element.place.file == file
    ]
    main = root.attributes.get("main_tree_to_execute")
    if main is None:
        if len(own) != 1:
            raise root.spot.fault(
                "main_tree_to_execute must say which of the trees is the main"
                f" one: there is {', '.join(own) or 'none'}"
            )
        main = own[0]
    if main not in documents.trees:
        raise root.spot.unknown("tree", main, documents.trees)
    documents.main = main
    return documents


def _load(
    source: bytes, file: str, folder: Path | None, documents: Documents
) -> XmlElement:
    root = read_xml(source, file)
    documents.sources.append((file, source))
    if root.tag != "root":
        raise root.spot.fault(
            "the outermost element of a tree file must be <root>"
        )
    for attribute in root.attributes:
        if attribute not in _ROOT_ATTRIBUTES:
            raise root.spot.unknown("attribute", attribute, _ROOT_ATTRIBUTES)
    form = root.attributes.get("BTCPP_format", "3")
    if form not in ("3", "4"):
        raise root.spot.fault(f"BTCPP_format must be 3 or 4, got {shown(form)}")
    trees = [child for child in root.children if child.tag == "BehaviorTree"]
    for child in root.children:
        if child.tag == "include":
            _include(child, folder, documents)
        elif child.tag not in ("BehaviorTree", "TreeNodesModel"):
            known = ("BehaviorTree", "TreeNodesModel", "include")
            raise child.spot.unknown("element", child.tag, known)
    for tree in trees:
        _add_tree(tree, int(form), len(trees) == 1, documents)
    if form == "4":
        models = [it for it in root.children if it.tag == "TreeNodesModel"]
        own = {tree.attributes.get("ID") for tree in trees}
        for tree_id, ports in declared_ports(models).items():
            # The file that holds the tree has precedence.
            if tree_id in own or tree_id not in documents.ports:
                documents.ports[tree_id] = ports
        documents.models += models
    return root


def _include(
    element: XmlElement, folder: Path | None, documents: Documents
) -> None:
    fault = element.spot.fault
    if set(element.attributes) != {"path"}:
        raise fault(
            "an include must have the attribute path, and no other, got"
            f" {', '.join(element.attributes) or 'none'}"
        )
    path = _included_path(element, folder, documents)
    if path in documents.open:
        names = [*documents.open[documents.open.index(path) :], path]
        chain = " -> ".join(name.name for name in names)
        raise fault(f"a file cannot include itself: {chain}")
    if path in documents.read:
        return
    if len(documents.read) == MAX_FILES:
        raise fault(f"more than {MAX_FILES} files are included")
    if not os.path.isfile(path):
        raise fault(f"there is no file {path}")
    _read(path, documents)


def _included_path(
    element: XmlElement, folder: Path | None, documents: Documents
) -> Path:
    """Returns the path of an include, its own or that in a library.

    Raises:
        BehaviorTreeError: If the file may not be read, or is no path.
    """
    fault = element.spot.fault
    text = element.attributes["path"]
    try:
        own = (folder / text).resolve() if folder else None
        names = [text]
        if (named := _OF_HUNAVSIM.fullmatch(text)) is not None:
            names.append(f"{named[1].lower()}.xml")
        shared = [
            (folder / name).resolve()
            for folder in documents.libraries
            for name in names
        ]
    except (OSError, ValueError, RuntimeError) as error:
        raise fault(f"{shown(text)} is no path: {error}") from error
    # (Their own files include each other in the same way.)
    found = [it for it in shared if _is_in_library(it, documents)]
    if own is None or documents.folder is None:
        if found:
            return found[0]
        raise fault(
            f"{shown(text)} cannot be found from a text; load a file instead,"
            " or include one that comes with the package, such as regular.xml"
        )
    if found and not os.path.isfile(own):
        return found[0]
    if not (
        documents.allow_outside
        or own.is_relative_to(documents.folder)
        or _is_in_library(own, documents)
    ):
        raise fault(
            f"{shown(text)} is outside {documents.folder}; files are included"
            " from the folder of the main file and below, unless"
            " allow_outside=True"
        )
    return own


def _is_in_library(path: Path, documents: Documents) -> bool:
    return os.path.isfile(path) and any(
        path.is_relative_to(folder) for folder in documents.libraries
    )


def _read(path: Path, documents: Documents) -> None:
    """Reads a file, and those that it includes."""
    documents.read.add(path)
    documents.open.append(path)
    _load(read_file(path), str(path), path.parent, documents)
    documents.open.pop()


def _load_missing(documents: Documents) -> None:
    """Reads the files of libraries that have the subtrees still missing."""
    known = [
        (tree_id, path)
        for folder in documents.libraries
        for tree_id, path in _library_trees(folder)
    ]
    while True:
        missing = {
            each.attributes.get("ID", "")
            for tree in documents.trees.values()
            for each in tree.element.all()
            if each.tag in SUBTREE_TAGS
        }.difference(documents.trees)
        found = [path for tree_id, path in known if tree_id in missing]
        if not found or found[0] in documents.read:
            return
        _read(found[0], documents)


@functools.cache
def _library_trees(folder: Path) -> tuple[tuple[str, Path], ...]:
    """Returns the IDs of the trees in a folder, each with its file."""
    return tuple(
        (tree.attributes["ID"], path)
        for path in sorted(folder.glob("*.xml"))
        for tree in read_xml(read_file(path), str(path)).children
        if tree.tag == "BehaviorTree"
    )


def _add_tree(
    tree: XmlElement, form: int, alone: bool, documents: Documents
) -> None:
    fault = tree.spot.fault
    tree_id = tree.attributes.get("ID", "BehaviorTree" if alone else "")
    if not tree_id:
        raise fault("a tree must have an ID")
    for attribute in tree.attributes:
        if attribute != "ID" and attribute not in NOTES:
            raise tree.spot.unknown("attribute", attribute, ("ID",))
    if tree_id in NODE_TYPES or (
        tree_id in RESERVED and "ID" in tree.attributes
    ):
        raise fault(
            f"the ID {shown(tree_id)} is the name of a node; choose another"
        )
    if tree_id in documents.trees:
        first = documents.trees[tree_id].element.place
        raise fault(
            f"the ID {shown(tree_id)} is already that of the tree at {first}"
        )
    if len(tree.children) != 1:
        raise fault(
            f"a tree must have exactly 1 node at its top, {shown(tree_id)} has"
            f" {len(tree.children)}"
        )
    documents.trees[tree_id] = TreeElement(tree, form)
