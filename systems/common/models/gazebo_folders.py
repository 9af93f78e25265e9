"""Finds the folders and files that Gazebo's worlds name. Nothing is downloaded.

A name is searched in the given folders, in those of environment variables, in
folders named `models` near the file, and in the caches of Fuel.
"""

from collections.abc import Iterator, Sequence
import os
from pathlib import Path
import re
from urllib.parse import unquote

from hunav_drake.systems.common.models.apart import ModelFault
from hunav_drake.systems.common.suggest import did_you_mean, shown

VARIABLES = (
    "GAZEBO_MODEL_PATH",
    "GAZEBO_RESOURCE_PATH",
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "ROS_PACKAGE_PATH",
)

# The number of folders above a file beside which folders of models are found.
_ABOVE = 3

# A model of Fuel: host, owner, name, and perhaps a version, and a file of it.
_FUEL = re.compile(
    r"https?://([^/]+)/(?:[\d.]+/)?([^/]+)/models/([^/]+)"
    r"(?:/(\d+|tip))?(?:/files/(.*))?/?$"
)


class Folders:
    """The folders in which the models of one file are searched."""

    def __init__(self, file: Path, given: Sequence[str]) -> None:
        """Lists the folders.

        Args:
            file: The file that names models.
            given: Folders that are searched first.

        Raises:
            ModelFault: If there is no such folder.
        """
        for folder in given:
            if not os.path.isdir(folder):
                raise ModelFault(
                    ("file",),
                    f"there is no folder {shown(folder)}; correct it in"
                    " model_path",
                )
        listed = [*map(Path, given)]
        for name in VARIABLES:
            listed += map(
                Path, filter(None, os.environ.get(name, "").split(os.pathsep))
            )
        for above in [file.parent, *file.parents[1:_ABOVE]]:
            listed += [above / "models", *sorted(above.glob("*/models"))]
            if (above / "model.config").is_file():
                listed.append(above.parent)
        # (Those of file://models/... are in the folder of a repository.)
        self._above = [file.parent, *file.parents[1:_ABOVE]]
        self._roots = [it for it in dict.fromkeys(listed) if it.is_dir()]
        home = Path.home()
        fuel = os.environ.get("GZ_FUEL_CACHE_PATH")
        self._fuel = [home / ".gz" / "fuel", home / ".ignition" / "fuel"]
        if fuel:
            self._fuel.insert(0, Path(fuel))

    def find(self, uri: str, beside: Path) -> Path:
        """Returns the path of a model's folder, or of a file.

        Args:
            uri: Its name: "model://NAME/...", "package://NAME/...",
                "file://...", the address of a model of Fuel, or a path.
            beside: The folder of the file with the name.

        Raises:
            ValueError: If there is none; the text says how to get it.
        """
        uri = uri.strip().replace("\\", "/")
        if not uri:
            raise ValueError("has no file; name one in <uri>")
        if fuel := _FUEL.match(uri):
            host, owner, name, version, rest = fuel.groups()
            owner, name = unquote(owner), unquote(name)
            for folder in self._fuel_models(host, owner, name, version):
                if (found := folder / (rest or "")).exists():
                    return found
            named = f"{name}/{rest}" if rest else name
            return self._below_roots(
                named, uri, f"`gz fuel download -u {uri.split('/files/')[0]}`"
            )
        scheme, mark, rest = uri.partition("://")
        if mark and scheme in ("model", "package"):
            return self._below_roots(rest.strip("/"), uri, "")
        if mark and scheme != "file":
            raise ValueError(
                f"{shown(uri)} is no address of a model of Fuel; give a file"
            )
        path = Path(rest if mark else uri)
        for place in (
            path,
            *(it / path for it in (beside, *self._roots, *self._above)),
        ):
            if (place.is_absolute() or place != path) and os.path.exists(place):
                return place
        places = [it / path for it in (beside, *self._roots, *self._above)]
        near = next((it for it in places if it.parent.is_dir()), places[0])
        return _in_other_case(uri, near.parent, path.name)

    def _below_roots(self, rest: str, uri: str, how: str) -> Path:
        name, _, inner = rest.partition("/")
        owned = None
        for root in self._roots:
            for folder in (root / name, root):
                if folder.name != name or not folder.is_dir():
                    continue
                if (folder / inner).exists():
                    return folder / inner
                owned = owned or folder
        if not how:
            for folder in self._fuel_models("*", "*", name, None):
                if (folder / inner).exists():
                    return folder / inner
        if owned is not None:
            place = owned / inner
            return _in_other_case(uri, place.parent, place.name)
        names = {it.name for root in self._roots for it in root.iterdir()}
        how = how or (
            "`git clone` of the repository that has it, or `gz fuel download -u"
            f" https://fuel.gazebosim.org/1.0/OpenRobotics/models/{name}`"
        )
        raise ValueError(
            f"there is no model {shown(name)}{did_you_mean(name, names)} in"
            f" {len(self._roots)} folders; get it by {how}, and give the folder"
            " that it is in: --model-path DIR, or model_path of the model"
        )

    def _fuel_models(
        self, host: str, owner: str, name: str, version: str | None
    ) -> Iterator[Path]:
        """Yields the folders of a model of Fuel on the disk, newest first."""
        if any(c in name + owner for c in "[?") or ".." in (name, owner):
            return
        pattern = f"{host}/{owner.lower()}/models/{name.lower()}/"
        for cache in self._fuel:
            found = [
                it for it in cache.glob(pattern + "*") if it.name.isdecimal()
            ]
            found.sort(key=lambda it: -int(it.name))
            exact = [it for it in found if it.name == version]
            yield from exact if (version or "").isdecimal() else found


def model_file(folder: Path) -> Path:
    """Returns the file of a model's folder: that of its newest version of SDF.

    Raises:
        ValueError: If it has none.
    """
    if folder.is_file():
        return folder
    best = folder / "model.sdf", (0, 0)
    config = folder / "model.config"
    if config.is_file():
        text = config.read_text(encoding="utf-8", errors="replace")
        text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
        for attributes, name in re.findall(r"<sdf([^>]*)>([^<]*)</sdf>", text):
            number = re.search(r"version\s*=\s*[\"'](\d+)\.(\d+)", attributes)
            version = (int(number[1]), int(number[2])) if number else (1, 0)
            if version > best[1]:
                best = folder / name.strip(), version
    if not best[0].is_file():
        raise ValueError(
            f"the folder {shown(folder.name)} has no {best[0].name}; take a"
            " whole copy of the model"
        )
    return best[0]


def _in_other_case(uri: str, folder: Path, name: str) -> Path:
    """Returns the file of a folder whose name differs in case only.

    Worlds are made also on systems for which that is the same name.
    """
    names = os.listdir(folder) if folder.is_dir() else []
    same = [it for it in names if it.lower() == name.lower()]
    if len(same) == 1:
        return folder / same[0]
    raise ValueError(
        f"there is no file {uri[:200]!r}{did_you_mean(name, names)}; take a"
        " whole copy of the model, or correct the path"
    )
