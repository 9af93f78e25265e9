"""Paths in scenarios: relative to the file, or absolute in a Scenario.

The functions change plain data in place, which need not fit the schema.
"""

from collections.abc import Callable
import itertools
import os
from pathlib import Path
from typing import Any

from hunav_drake.scenario.error import child
from hunav_drake.systems.common.old_words import TAG
from hunav_drake.systems.people.behavior_choice import is_path

Change = Callable[[str], str]


def find_files(data: Any, folder: Path) -> None:
    """Makes paths absolute that are relative to an absolute folder."""
    _change_paths(data, lambda path: os.path.normpath(folder / path))


def relate_files(data: Any, folder: Path) -> None:
    """Makes absolute paths relative to an absolute folder.

    Paths that have only the root in common with it stay absolute.
    """

    def relate(path: str) -> str:
        if not os.path.isabs(path):
            return path
        if Path(path).parts[:2] != folder.parts[:2]:
            return path
        return os.path.relpath(path, folder)

    _change_paths(data, relate)


def _change_paths(data: Any, change: Change) -> None:
    _change_trees(data, change)
    _change_tracks(data, change)
    _change_world_files(data, change)
    _change_model(data, change)


def _change_trees(data: Any, change: Change) -> None:
    """Changes the paths of behavior trees."""
    humans = data.get("humans") if isinstance(data, dict) else None
    for human in humans if isinstance(humans, list) else []:
        holder, key = human, "behavior"
        if isinstance(child(human, key), dict):
            holder, key = human[key], TAG
        tree = child(holder, key)
        if isinstance(tree, str) and is_path(tree):
            holder[key] = change(tree)
    population = child(data, "population")
    lists = [child(population, key) for key in ("cohorts", "sources")]
    parts = [part for part in lists if isinstance(part, list)]
    for members in itertools.chain(*parts):
        behaviors = child(members, "behaviors")
        if isinstance(behaviors, dict):
            members["behaviors"] = {
                change(tree)
                if isinstance(tree, str) and is_path(tree)
                else tree: weight
                for tree, weight in behaviors.items()
            }


def _change_tracks(data: Any, change: Change) -> None:
    """Changes the paths of recorded people."""
    humans = child(data, "humans")
    holders = [child(data, "population")]
    holders += humans if isinstance(humans, list) else []
    for holder in holders:
        for key in ("track", "tracks"):
            track = child(holder, key)
            file = child(track, "file")
            if isinstance(file, str) and file:
                track["file"] = change(file)


def _change_world_files(data: Any, change: Change) -> None:
    """Changes the paths of maps and models."""
    world = child(data, "world")
    models = child(world, "models")
    holders = [(world, "map")]
    if isinstance(models, list):
        holders += [(model, "file") for model in models]
    for holder, key in holders:
        path = child(holder, key)
        if isinstance(path, str) and path and "://" not in path:
            holder[key] = change(path)
        folders = child(holder, "model_path")
        if isinstance(folders, list):
            holder["model_path"] = [
                change(it) if isinstance(it, str) and it else it
                for it in folders
            ]


def _change_model(data: Any, change: Change) -> None:
    """Changes the paths of the robots' models."""
    members = child(data, "robots")
    for holder in (data, *(members if isinstance(members, list) else [])):
        robot = child(holder, "robot")
        file = child(robot, "file")
        if isinstance(file, str) and file and not file.startswith("package://"):
            robot["file"] = change(file)
        packages = child(robot, "packages")
        if isinstance(packages, dict):
            robot["packages"] = {
                name: change(path) if isinstance(path, str) else path
                for name, path in packages.items()
            }
