"""Prints the lowest versions that pyproject.toml allows, as constraints.

    python -m tests.lowest > constraints.txt
    pip install -c constraints.txt -e '.[editor]'

`make test-lowest` installs them into an environment of their own and runs the
fast tests there.
"""

from pathlib import Path
import re
import sys
import tomllib

ROOT = Path(__file__).resolve().parents[1]

# Extras that a user may install. What only builds and tests the project may be
# as new as there is.
EXTRAS = ("completion", "dask", "editor", "film", "notebook")

_BOUND = re.compile(r"([\w.-]+?)(?:\[[^]]*\])?\s*>=\s*([\w.]+)")


def lowest_versions(project: dict) -> dict[str, str]:
    """Returns the lower bound of each dependency of a user, by name.

    Args:
        project: The table `project` of a pyproject.toml.

    Raises:
        ValueError: One has no lower bound.
    """
    wanted = list(project["dependencies"])
    for extra in EXTRAS:
        wanted += project["optional-dependencies"].get(extra, [])
    lowest = {}
    for requirement in wanted:
        bound = _BOUND.fullmatch(requirement)
        if bound is None:
            raise ValueError(f"{requirement!r} has no lower bound: add >=")
        lowest[bound[1]] = bound[2]
    return lowest


def main() -> int:
    """Prints one constraint per line."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    for name, version in lowest_versions(project).items():
        print(f"{name}=={version}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
