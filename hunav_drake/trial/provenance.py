"""The provenance of a result: all that must be equal to reproduce it."""

from collections.abc import Sequence
import functools
import hashlib
from importlib import metadata
from pathlib import Path
import platform

from hunav_drake.trial.machine import machine_traits

Provenance = dict[str, str | int]

# This package, and those that it computes with.
_COMPUTES = (
    *("hunav_drake", "drake", "numpy", "numba", "llvmlite", "scipy"),
    "shapely",
)

# (Each reads a file.)
_version = functools.cache(metadata.version)

# The text for a trial without random draws: all its seeds give the same trial.
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
    """Returns all that must be equal for a trial to repeat bit for bit.

    Args:
        scenario_text: The scenario, as `SaveScenario` writes it.
        seed: The seed of all random draws.
        planner: The name of the planner that drove the robot.
        behavior_sha256: The SHA-256 hash of the behavior trees, which the
            scenario only names. It is left out if empty.
        files_sha256: That of the files that the scenario names.
        drawn: The random draws, if known: see `drawn_by_seed`.

    Returns:
        The versions of this package and its numeric dependencies, the traits
        of the machine (`MACHINE_TRAITS`), the SHA-256 hashes of the scenario,
        of the behavior trees and of the named files, the seed, the planner,
        and the random draws, or "nothing".
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
    """Returns the draws of a seed as text for results and tables."""
    return ", ".join(drawn) or NOTHING_DRAWN


def MakeSourceProvenance(filename: str | Path) -> Provenance:
    """Returns all that must be equal for equal metrics of a recording.

    These are versions and machine as in `MakeProvenance`, the name of the file
    and the SHA-256 hash of its content; of a folder, that of its files.

    Raises:
        OSError: If the file cannot be read.
    """
    path = Path(filename)
    files = [path]
    if path.is_dir():
        files = sorted(it for it in path.iterdir() if it.is_file())
    sha256 = hashlib.sha256()
    for file in files:
        sha256.update(file.read_bytes())
    return {
        **program_versions(),
        **machine_traits(),
        "source": path.name,
        "source_sha256": sha256.hexdigest(),
    }


def MakeValidationProvenance(seed: int, quick: bool) -> Provenance:
    """Returns all that must be equal for equal results of a validation.

    `quick` says whether it was the short form.
    """
    form = "quick" if quick else "full"
    machine = machine_traits()
    return {**program_versions(), **machine, "seed": seed, "form": form}


def program_versions() -> Provenance:
    """Returns the versions that results depend on, and the type of machine.

    On another processor of that type, results agree up to rounding.
    """
    versions = {name: _version(name) for name in _COMPUTES}
    return {
        **versions,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
    }
