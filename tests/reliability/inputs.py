"""Inputs of every kind that something is wrong with, and who reads them.

Each kind writes the files of an input that is drawn from a generator, and
returns the commands of `hunav` that are to read it, one after the other: what
one accepts, the next must not refuse.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import functools
import gzip
import json
from pathlib import Path
import shutil

import numpy as np
from PIL import Image
import yaml

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SaveContext,
)
from hunav_drake.runs import LoadSuite, RunSuite
from hunav_drake.runs.recording_files import ReadRecording
from hunav_drake.runs.result_files import WriteResult
from hunav_drake.scenarios import shipped_names, shipped_text
from hunav_drake.systems import behavior
from hunav_drake.trial.context_file import _digest
from hunav_drake.trial.simulation import RunTrial
from tests.agents import AGENTS
from tests.maps import write_map
from tests.reliability.mutations import (
    mutate_array,
    mutate_bytes,
    mutate_json,
    mutate_lines,
    mutate_model,
    mutate_table,
    mutate_text,
    pick,
)
from tests.reliability.recordings import hunavsim_messages, table_rows
from tests.robot_models import FILES, ROBOTS

# Words of a command, or what reads a file here and raises a ValueError that
# begins with its path.
Step = list[str] | Callable[[], None]
Kind = Callable[[np.random.Generator, Path], list[Step]]

_SHORT = ["--set", "simulation.duration=0.5"]
_TREES = Path(behavior.__file__).parent / "trees"
_SUITE = {
    "name": "small",
    "scenarios": ["free_run"],
    "planners": ["pursuit", {"type": "dwb", "label": "other"}],
    "overrides": ["simulation.duration=0.2"],
    "settings": {"a": ["robot.radius=0.3"]},
    "seeds": 1,
    "seeds_of": {"free_run": [3]},
    "repetitions": 1,
    "until": {"metric": "path_length", "half_width": 1.0, "least": 3},
    "relations": [
        {"scenarios": ["free_run"], "metric": "path_length", "holds": "dwb < 3"}
    ],
}
_METRICS = {
    "hunav_evaluator_node": {
        "ros__parameters": {
            "frequency": 10.0,
            "experiment_tag": "night",
            "metrics": {"time_to_reach_goal": True, "path_length": False},
        }
    }
}


def _check_and_run(path: Path) -> list[Step]:
    short = [str(path), *_SHORT]
    return [["check", *short], ["run", *short, "--json"]]


def _write_yaml(path: Path, data: object) -> Path:
    path.write_text(yaml.safe_dump(data, allow_unicode=True))
    return path


def _mutate_yaml(rng, text: str) -> bytes:
    kind = rng.integers(4)
    if kind == 0:
        return mutate_bytes(rng, text.encode())
    if kind == 1:
        return mutate_lines(rng, text).encode()
    if kind == 2:
        return mutate_text(rng, text).encode(errors="replace")
    data = yaml.safe_load(text)
    for _ in range(rng.integers(1, 3)):
        mutate_json(rng, data)
    return yaml.safe_dump(data).encode()


def scenario(rng: np.random.Generator, folder: Path) -> list[Step]:
    """A scenario file, of those that are shipped."""
    path = folder / "scenario.yaml"
    text = shipped_text(pick(rng, shipped_names()))
    path.write_bytes(_mutate_yaml(rng, text))
    return _check_and_run(path)


def suite(rng: np.random.Generator, folder: Path) -> list[Step]:
    """A suite file."""
    path = folder / "suite.yaml"
    path.write_bytes(_mutate_yaml(rng, yaml.safe_dump(_SUITE)))
    words = [*("--out", str(folder / "out")), "--quiet", "--workers", "1"]
    return [["bench", str(path), *words, *_SHORT]]


def world_map(rng: np.random.Generator, folder: Path) -> list[Step]:
    """A map with its picture."""
    rows = rng.choice(np.array([0, 205, 254], np.uint8), (20, 30))
    rows[5:16] = 254
    name = pick(rng, ("map.pgm", "map.png"))
    path = write_map(folder, rows, origin=[-1.0, -1.0, 0.0])
    settings = path.read_text().replace("map.pgm", name)
    Image.fromarray(rows).save(folder / name)
    if rng.random() < 0.5:
        path.write_bytes(_mutate_yaml(rng, settings))
    else:
        path.write_text(settings)
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(mutate_bytes(rng, data))
    robot = {"start": [-0.5, 0.1, 0.0], "goal": [1.5, 0.1, 0.0]}
    data = {"world": {"map": "map.yaml"}, "robot": robot}
    return _check_and_run(_write_yaml(folder / "scenario.yaml", data))


def robot(rng: np.random.Generator, folder: Path) -> list[Step]:
    """A robot's model, beside meshes that it may name."""
    name = pick(rng, list(ROBOTS))
    text, base, drive = ROBOTS[name]
    change = pick(rng, (mutate_model, mutate_model, mutate_text, mutate_lines))
    files = {**FILES, name: change(rng, text)}
    for file, content in files.items():
        (folder / file).write_text(content, errors="replace")
    model = {"type": "urdf", "file": name, "base": base}
    data = {"robot": {**model, "drive": drive, "goal": [3.0, 0.0, 0.0]}}
    return _check_and_run(_write_yaml(folder / "scenario.yaml", data))


def tree(rng: np.random.Generator, folder: Path) -> list[Step]:
    """A behavior tree."""
    text = pick(rng, sorted(_TREES.glob("[!n]*.xml"))).read_text()
    change = pick(rng, (mutate_text, mutate_lines))
    path = folder / "tree.xml"
    path.write_text(change(rng, text), errors="replace")
    human = {"pose": [2.0, 1.0, 0.0], "goals": [[5, 1]], "behavior": str(path)}
    data = {"humans": [human], "robot": {"goal": [3.0, 0.0, 0.0]}}
    return _check_and_run(_write_yaml(folder / "scenario.yaml", data))


def agents(rng: np.random.Generator, folder: Path) -> list[Step]:
    """The files of HuNavSim."""
    texts = {"agents.yaml": AGENTS, "metrics.yaml": yaml.safe_dump(_METRICS)}
    changed = pick(rng, list(texts))
    for name, text in texts.items():
        data = _mutate_yaml(rng, text) if name == changed else text.encode()
        (folder / name).write_bytes(data)
    result = str(folder / "scenario.yaml")
    words = ["--metrics", str(folder / "metrics.yaml"), "-o", result]
    return [
        ["import", str(folder / "agents.yaml"), *words, "--force"],
        *_check_and_run(Path(result))[:1],
    ]


@functools.cache
def _bases() -> Path:
    """Returns a folder of sound results, made once."""
    import tempfile

    folder = Path(tempfile.mkdtemp())
    trial = LoadScenario(
        filename="passing", overrides=["simulation.duration=1.0"]
    )
    WriteResult(RunTrial(trial), folder / "results", tag="run")
    RunSuite(
        LoadSuite(data=yaml.safe_dump({**_SUITE, "until": None})),
        out=folder / "bench" / "small",
        workers=1,
    )
    diagram = _diagram()
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(1.0)
    SaveContext(diagram, simulator.get_context(), folder / "context.npz")
    return folder


@functools.cache
def _diagram():
    return MakeTrialDiagram(LoadScenario(filename="reaction_scared"))


def _mutate_npz(rng, source: Path, path: Path, *, sealed: bool = False) -> None:
    if rng.random() < 0.3:
        path.write_bytes(mutate_bytes(rng, source.read_bytes()))
        return
    with np.load(source) as archive:
        arrays = dict(archive)
    for _ in range(rng.integers(1, 3)):
        name = pick(rng, list(arrays))
        try:
            with np.errstate(all="ignore"):
                arrays[name] = mutate_array(rng, arrays[name])
        except (ValueError, TypeError):
            del arrays[name]
    if sealed:
        arrays.pop("sha256", None)
        arrays["sha256"] = np.array(_digest(arrays))
    np.savez(path, **arrays)


def recording(rng: np.random.Generator, folder: Path) -> list[Step]:
    """A recording: of this package, as a table, or of HuNavSim."""
    source = _bases() / "results/runs/run/recording.npz"
    kind = pick(rng, ("a.npz", "a.csv", "a.csv.gz", "a.json"))
    path = folder / kind
    if kind == "a.npz":
        _mutate_npz(rng, source, path)
        return [["evaluate", str(path)]]
    whole = ReadRecording(source)
    if kind == "a.json":
        document = hunavsim_messages(whole)
        mutate_json(rng, document)
        text = json.dumps(document)
    else:
        rows = table_rows(whole)
        for _ in range(rng.integers(1, 3)):
            rows = mutate_table(rng, rows)
        text = "\n".join(map(",".join, rows))
    if rng.random() < 0.3:
        text = mutate_text(rng, text)
    data = text.encode(errors="replace")
    if kind.endswith(".gz"):
        data = gzip.compress(data)
        data = mutate_bytes(rng, data) if rng.random() < 0.5 else data
    path.write_bytes(data)
    return [["evaluate", str(path)]]


def context(rng: np.random.Generator, folder: Path) -> list[Step]:
    """A saved Context, in one of two whose checksum is right."""
    path = folder / "context.npz"
    sealed = bool(rng.random() < 0.5)
    _mutate_npz(rng, _bases() / "context.npz", path, sealed=sealed)

    def go_on() -> None:
        loaded = LoadContext(_diagram(), path)
        with _no_refusal():
            simulator = MakeTrialSimulator(_diagram(), loaded)
            simulator.AdvanceTo(loaded.get_time() + 0.5)

    return [go_on]


@contextmanager
def _no_refusal() -> Iterator[None]:
    try:
        yield
    except ValueError as error:
        raise RuntimeError(f"accepted, but then: {error}") from error


def rows(rng: np.random.Generator, folder: Path) -> list[Step]:
    """What reports and suites that go on read."""
    base = shutil.copytree(_bases(), folder / "base", dirs_exist_ok=True)
    path = pick(
        rng,
        (
            base / "results/runs/run/result.json",
            base / "results/runs/run/recording.npz",
            base / "bench/small/runs.jsonl",
        ),
    )
    if path.suffix == ".npz":
        _mutate_npz(rng, path, path)
    elif path.suffix == ".json" and rng.random() < 0.7:
        document = json.loads(path.read_text())
        mutate_json(rng, document)
        path.write_text(json.dumps(document))
    else:
        lines = path.read_bytes().splitlines(keepends=True)
        at = int(rng.integers(len(lines)))
        if rng.random() < 0.5 and path.suffix == ".jsonl":
            document = json.loads(lines[at])
            mutate_json(rng, document)
            lines[at] = json.dumps(document).encode() + b"\n"
        else:
            lines[at] = mutate_bytes(rng, lines[at])
        path.write_bytes(b"".join(lines))
    if path.suffix == ".jsonl":
        suite = {**_SUITE, "until": None}
        name = _write_yaml(folder / "suite.yaml", suite)
        out = ["--out", str(base / "bench"), "--quiet", "--workers", "1"]
        return [["bench", str(name), *out]]
    return [["report", str(base / "results"), "-o", str(folder / "a.html")]]


KINDS: dict[str, Kind] = {
    kind.__name__: kind
    for kind in (
        *(scenario, suite, world_map, robot, tree),
        *(agents, recording, context, rows),
    )
}
