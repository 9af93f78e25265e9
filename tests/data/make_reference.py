"""Makes the compact set of recorded results out of the full one.

Run it as `python -m tests.data.make_reference` after a change of `CASES`.
"""

import gzip
import json
import lzma
from typing import Any

from tests.recorded import COMPACT, FULL

CASES = (
    "forces",
    "crowd/00_regular_pass",
    "crowd/03_impassive_pass",
    "crowd/06_surprised_pass",
    "crowd/09_scared_pass",
    "crowd/12_curious_pass",
    "crowd/15_threatening_pass",
    "crowd/27_group3_regular",
    "crowd/30_regular5_obstacles",
    "crowd/32_mix6",
    "metrics/06_surprised_pass",
    "metrics/12_curious_pass",
    "metrics/30_regular5_obstacles",
    *(
        f"metrics_hand/{path.name.removesuffix('.json.gz')}"
        for path in sorted((FULL / "metrics_hand").glob("*.json.gz"))
    ),
)

# How many steps of a crowd are kept where it is not all of them.
STEPS = {"crowd/30_regular5_obstacles": 400}


def reduce(name: str, document: Any) -> Any:
    """Leaves out of a case, in place, what no test compares."""
    if name == "forces":
        for case in document["cases"]:
            case["expected"] = {
                form: {"forces": case["expected"][form]["forces"]}
                for form in ("all", "single")
            }
    if name.startswith("crowd/"):
        trace = document["trace"]
        trace["steps"] = trace["steps"][: STEPS.get(name)]
        for step in trace["steps"]:
            del step["forces"]
    return document


def read_full(name: str) -> Any:
    """Returns a case of the full set."""
    return json.loads(gzip.decompress((FULL / f"{name}.json.gz").read_bytes()))


def main() -> None:
    """Writes the files."""
    for name in CASES:
        document = reduce(name, read_full(name))
        text = json.dumps(document, separators=(",", ":"))
        path = COMPACT / f"{name}.json.xz"
        path.parent.mkdir(parents=True, exist_ok=True)
        preset = 9 | lzma.PRESET_EXTREME
        path.write_bytes(lzma.compress(text.encode(), preset=preset))


if __name__ == "__main__":
    main()
