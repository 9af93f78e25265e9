"""A suite whose scenarios change without its version compares nothing."""

import hashlib
from importlib import resources
import json
from pathlib import Path

from hunav_drake.runs import LoadSuite

PINNED = Path(__file__).parents[2] / "data" / "standard_suite.json"


def scenario_hashes(suite):
    folder = resources.files("hunav_drake.scenarios")
    return {
        name: hashlib.sha256(
            (folder / f"{name}.yaml").read_bytes()
        ).hexdigest()[:16]
        for name in suite.scenarios
    }


def test_its_scenarios_are_those_of_its_version():
    suite = LoadSuite(filename="standard")
    now = {"version": suite.version, "scenarios": scenario_hashes(suite)}
    pinned = json.loads(PINNED.read_text())
    changed = pinned["scenarios"].items() ^ now["scenarios"].items()
    names = sorted({name for name, _ in changed})
    assert now == pinned, (
        f"{names} of the suite are not those of version {pinned['version']}:"
        " if a version with them has been published, raise it in"
        " standard.yaml; then write this to"
        f" {PINNED}:\n{json.dumps(now, indent=1)}"
    )
