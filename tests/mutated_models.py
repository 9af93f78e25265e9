"""Models with something wrong in them: each is refused in a line, or runs.

`python -m tests.mutated_models --count 600` tries so many, and prints what is
unclean: what is refused other than by a `ScenarioError`, without telling what,
and what passes the checks but does not run. Models of files named as arguments
join those of the tests.
"""

import argparse
from collections.abc import Iterator
import itertools
from pathlib import Path
import random
import re
import tempfile
import warnings

import numpy as np

from hunav_drake import LoadScenario, RunTrial, ScenarioError
from tests.systems.robot.crate import CRATE, FOOTPRINT, STAGES

PMB2 = Path(__file__).parents[1] / "systems/robot/models/pmb2.sdf"

# Each model with its base and its drive.
ROBOTS = {
    "crate.urdf": (CRATE, "chassis", {"type": "omnidirectional"}),
    "turtle.urdf": (
        FOOTPRINT,
        "base_link",
        {
            "left_wheel": "left_joint",
            "right_wheel": "right_joint",
            "wheel_separation": 0.3,
            "wheel_radius": 0.08,
        },
    ),
    "stages.urdf": (
        STAGES,
        "chassis",
        {"type": "omnidirectional", "x": "along_x", "y": "along_y"}
        | {"yaw": "turn"},
    ),
    "pmb2.sdf": (
        PMB2.read_text(),
        "base",
        {
            "left_wheel": "left_wheel_joint",
            "right_wheel": "right_wheel_joint",
            "wheel_separation": 0.4044,
            "wheel_radius": 0.0985,
        },
    ),
}

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
NUMBERS = re.compile(rf"(?<=[\"'> ]){NUMBER}(?=[\"'< ])")
LISTS = re.compile(rf"(?<=[\"'>]){NUMBER}(?: {NUMBER})*(?=[\"'<])")
NAMES = re.compile(r"(?<=\")[A-Za-z_]\w*(?=\")|(?<=>)[A-Za-z_]\w*(?=<)")
ELEMENTS = re.compile(r"<([\w:]+)\b[^<>]*?(?:/>|>(?:(?!<\1\b).)*?</\1>)", re.S)
SHAPES = re.compile(
    r"<(box|sphere|cylinder|ellipsoid)\b[^<>]*?(?:/>|>.*?</\1>)", re.S
)

WRONG_NUMBERS = (
    *("-0.1", "0", "nan", "inf", "-inf", "-20", "1e300", "1e-300", "1e12"),
    *("a", "0x", "1,5", "--1", "${x}", "\N{SUPERSCRIPT TWO}"),
)
WRONG_LISTS = ("", "a 0 0.1", "1 2", "1 2 3 4 5 6 7", "0 0 0", "nan nan nan")
WRONG_NAMES = ("", "nope", "world", "a b", "\N{SNOWMAN}", "::", "x" * 300)
MESHES = (
    *("missing.obj", "part.stl", "part.dae", "broken.obj", "flat.obj"),
    *("broken.gltf", "empty.obj", "package://nope/part.obj", "model://nope"),
    *("/nowhere/part.obj", "", "ftp://nope/part.obj", "."),
)
SCALES = ("1 1 1", "0 0 0", "-1 1 1", "1e30 1 1", "1e-12 1 1", "nan 1 1", "a")

TENT = (
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
)
FILES = {
    "part.obj": TENT,
    "part.stl": "solid part\nendsolid part\n",
    "part.dae": "<COLLADA/>",
    "broken.obj": "v 0 0\nf 1 2 9\n",
    "flat.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n",
    "empty.obj": "",
    "broken.gltf": '{"asset":',
}


def mutants(
    models: dict[str, tuple], seed: int
) -> Iterator[tuple[str, str, str, dict]]:
    """Yields file name, text, base and drive of models with faults."""
    rng = random.Random(seed)
    for name in itertools.cycle(models):
        text, base, drive = models[name]
        kind = rng.choice(
            ["number"] * 4 + ["list", "name", "mesh", "less", "twice", "cut"]
        )
        is_sdf = name.endswith("sdf")
        places = {
            "number": NUMBERS,
            "list": LISTS,
            "name": NAMES,
            "mesh": SHAPES,
            "less": ELEMENTS,
            "twice": ELEMENTS,
        }.get(kind)
        if places is None:
            yield name, text[: rng.randrange(len(text))], base, drive
            continue
        found = list(places.finditer(text))
        if not found:
            continue
        place = rng.choice(found)
        mesh, scale = rng.choice((*MESHES, "part.obj")), rng.choice(SCALES)
        new = {
            "number": rng.choice(WRONG_NUMBERS),
            "list": rng.choice(WRONG_LISTS),
            "name": rng.choice(WRONG_NAMES),
            "mesh": f"<mesh><uri>{mesh}</uri><scale>{scale}</scale></mesh>"
            if is_sdf
            else f'<mesh filename="{mesh}" scale="{scale}"/>',
            "less": "",
            "twice": place[0] * 2,
        }[kind]
        yield (
            name,
            text[: place.start()] + new + text[place.end() :],
            base,
            (drive),
        )


def uncleanness(file: Path, base: str, drive: dict) -> str:
    """Returns what is unclean of a trial with a model; empty if nothing."""
    robot = {"type": "urdf", "file": str(file), "base": base, "drive": drive}
    trial = {"robot": robot | {"goal": [3, 0, 0]}}
    trial["simulation"] = {"duration": 0.5}
    try:
        scenario = LoadScenario(data=repr(trial))
    except ScenarioError as error:
        for fault in error.faults:
            words = fault.message
            if not fault.path.startswith("robot") or "\n" in words:
                return f"no place: {fault}"
            if len(words) > 600 or not re.search(r"[;:']", words):
                return f"no words: {fault}"
        return ""
    except BaseException as error:
        return f"not a ScenarioError: {type(error).__name__}: {error}"
    try:
        recording = RunTrial(scenario).recording
    except BaseException as error:
        return f"passes, but fails: {type(error).__name__}: {error}"
    return "" if np.isfinite(recording.robot).all() else "is not finite"


def try_mutants(
    count: int, seed: int = 0, models: dict[str, tuple] = ROBOTS
) -> list[tuple[str, str]]:
    """Returns what is unclean of so many models: the words, and the text."""
    unclean = []
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name, text in FILES.items():
            (Path(folder) / name).write_text(text)
        for it in itertools.islice(mutants(models, seed), count):
            name, text, base, drive = it
            file = Path(folder) / name
            file.write_text(text)
            if words := uncleanness(file, base, drive):
                unclean.append((words, text))
                print(f"{name}: {' '.join(words.split())[:300]}", flush=True)
    return unclean


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--count", type=int, default=600)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--keep", type=Path, help="a folder for what is unclean"
    )
    options = parser.parse_args()
    models = dict(ROBOTS)
    for file in options.files:
        text = file.read_text()
        links = re.findall(r"<link[^>]*?name=[\"']([^\"']+)", text)
        models[file.name] = text, links[0], {"type": "omnidirectional"}
    unclean = try_mutants(options.count, options.seed, models)
    for i, (words, text) in enumerate(unclean if options.keep else ()):
        options.keep.mkdir(parents=True, exist_ok=True)
        (options.keep / f"{i}.xml").write_text(f"<!-- {words} -->\n{text}")
    print(f"{len(unclean)} of {options.count} unclean")


if __name__ == "__main__":
    main()
