"""The scenarios that come with the package, as package data."""

from importlib import resources
from pathlib import Path


def shipped_names() -> list[str]:
    """Returns the names of the scenarios that come with the package."""
    folder = resources.files(__name__)
    names = (Path(entry.name) for entry in folder.iterdir())
    return sorted(path.stem for path in names if path.suffix == ".yaml")


def hard_names() -> list[str]:
    """Returns the names, "hard/...", of scenes in which a planner fails.

    They are those of the suite "hard", and are not listed with the others.
    """
    folder = resources.files(__name__) / "hard"
    return sorted(f"hard/{Path(it.name).stem}" for it in folder.iterdir())


def shipped_text(name: str) -> str:
    """Returns the text of a scenario that comes with the package."""
    file = resources.files(__name__) / f"{name}.yaml"
    return file.read_text(encoding="utf-8")
