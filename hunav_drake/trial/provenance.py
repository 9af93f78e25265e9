"""The provenance of a result: what must be equal to reproduce it."""

from collections.abc import Sequence
import hashlib
from importlib import metadata
from pathlib import Path
import platform

from hunav_drake.trial.machine import machine_traits

Provenance = dict[str, str | int]

# What computes: this package, and others that give numbers to it.
_COMPUTES = (
    *("hunav_drake", "drake", "numpy", "numba", "llvmlite", "scipy"),
    "shapely",
)

# What is told as drawn by the seed of a run if nothing is: all its seeds are
# the same trial.
NOTHING_DRAWN = "nothing"


def MakeProvenance(
    scenario_text: str,
    seed: int,
    *,
    planner: str = "",
    behavior_sha256: str = "",
    files_sha256: str = "",
    drawn: Sequence[str] | None = None,
) -> Provenance:
    """Returns what must be equal for a trial to repeat bit for bit.

    Args:
        scenario_text: The scenario, as `SaveScenario` writes it.
        seed: The seed of everything random.
        planner: The name of the planner that drove the robot.
        behavior_sha256: The SHA-256 hash of the behavior trees, of which the
            scenario tells only the names. It is left out if empty.
        files_sha256: That of the files that a scenario names, alike.
        drawn: What the seed draws, if that is known: see `drawn_by_seed`.

    Returns:
        The versions of this package and of what it computes with, what of the
        machine matters (`MACHINE_TRAITS`), the SHA-256 hashes of the scenario,
        of the behavior trees and of the named files, the seed, the planner,
        and what the seed draws, or "nothing".
    """
    contents = {
        "behavior_sha256": behavior_sha256,
        "files_sha256": files_sha256,
    }
    return {
        **program_versions(),
        **machine_traits(),
        "scenario_sha256": hashlib.sha256(scenario_text.encode()).hexdigest(),
        **{name: sha256 for name, sha256 in contents.items() if sha256},
        "seed": seed,
        "planner": planner,
        **({} if drawn is None else {"drawn": drawn_text(drawn)}),
    }


def drawn_text(drawn: Sequence[str]) -> str:
    """Returns what a seed draws in words, as results and tables tell it."""
    return ", ".join(drawn) or NOTHING_DRAWN


def MakeSourceProvenance(filename: str | Path) -> Provenance:
    """Returns what must be equal for a recording's metrics to be the same.

    It is versions and machine as in `MakeProvenance`, the name of the file, and
    the SHA-256 hash of its content.

    Raises:
        OSError: If the file cannot be read.
    """
    path = Path(filename)
    return {
        **program_versions(),
        **machine_traits(),
        "source": path.name,
        "source_sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
    }


def MakeValidationProvenance(seed: int, quick: bool) -> Provenance:
    """Returns what must be equal for a validation to find the same.

    Args:
        seed: The seed of places and speeds.
        quick: Whether it was the short form.
    """
    form = "quick" if quick else "full"
    return {
        **program_versions(),
        **machine_traits(),
        "seed": seed,
        "form": form,
    }


def program_versions() -> Provenance:
    """Returns the versions that results follow from, and the kind of machine.

    On another processor of that kind results agree to rounding.
    """
    versions = {name: metadata.version(name) for name in _COMPUTES}
    return {
        **versions,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
    }
