"""The results of runs in a folder: a log, and files for each run."""

from collections.abc import Callable, Iterator
import dataclasses
import errno
import hashlib
import itertools
from pathlib import Path
from typing import Any, Literal, cast, get_args

from hunav_drake.runs.foreign_formats import RESULT_TEXTS
from hunav_drake.runs.run_folders import (
    RUNS,
    find_recording,
    find_runs,
    natural_key,
    write_run_folder,
)
from hunav_drake.runs.run_log import NAME, append_rows, read_rows
from hunav_drake.runs.run_row import (
    NO_RESULT,
    RunRow,
    make_row,
    result_to_json,
    row_from_json,
)
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.common.files import (
    FILE_NAME_RULE,
    file_name_part,
    is_file_name,
)
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.evaluation.metric import base_name
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.provenance import Provenance
from hunav_drake.trial.result import (
    EndReason,
    MakeTrialResult,
    MetricTables,
    TrialResult,
)

Format = Literal["csv", "hunav"]

# The maximum length of a file name that is made of other names.
_LONGEST = 80

# The maximum number of damaged runs in an error message.
_MOST_NAMED = 5


def WriteResult(
    result: TrialResult,
    directory: str | Path,
    *,
    tag: str | None = None,
    label: str | None = None,
    format: Format = "csv",
    add: Callable[[Path], object] | None = None,
) -> Path:
    """Writes a result to a new folder, `<directory>/runs/<tag>/`.

    The folder contains `result.json` (metrics, also by behavior, facts about
    them, provenance, end), `recording.npz`, and the series of metrics in
    `steps.csv` and `steps_beh_<behavior>.csv`. It appears with all its files
    or not at all, and never changes; then the log of the directory,
    `runs.jsonl`, gets a line. Several processes may write to one directory at
    the same time. For tables of all runs see `ReadRuns`.

    A behavior whose name cannot be a file name gets a hash after the valid
    part of its name. JSON has only finite numbers: NaN is null, and infinity
    is the text "Infinity" or "-Infinity".

    Args:
        result: The result.
        directory: The folder of results; it is created if necessary.
        tag: The name of the run's folder. By default scenario, planner and
            seed, and "run2", ... if that is taken.
        label: The setting, instead of the result's own: a name that
            distinguishes this run from runs of the same planner in the same
            scenario that differ in more than the seed. Statistics separate
            settings.
        format: With "hunav", also writes the four kinds of text files of
            HuNavSim: see `hunav_texts`.
        add: Writes more files of the run, such as its report, to the folder
            that it gets, before the folder gets its name.

    Returns:
        The folder of the run.

    Raises:
        OSError: If something cannot be written, or if the tag is taken.
        ValueError: If the tag cannot be the name of a folder.
    """
    check_choice("format", format, get_args(Format))
    if label is not None:
        result = dataclasses.replace(result, setting=label)
    if tag is not None and not is_file_name(tag):
        raise ValueError(f"the tag {FILE_NAME_RULE}, got {shown(tag)}")
    runs = Path(directory) / RUNS
    try:
        runs.mkdir(parents=True, exist_ok=True)
        taken = find_runs(directory)
        for name in _tags(result) if tag is None else [tag]:
            row = make_row(result, name)

            def write(folder: Path, row: RunRow = row) -> None:
                _write_files(result, row, folder, format)
                if add is not None:
                    add(folder)

            if name not in taken and write_run_folder(runs / name, write):
                append_rows(Path(directory), [row])
                return runs / name
        raise FileExistsError(
            errno.EEXIST, f"the tag {tag!r} is taken", str(runs / str(tag))
        )
    except OSError as error:
        raise OSError(
            error.errno,
            f"cannot write the results: {error.strerror or error}",
            str(error.filename or directory),
        ) from error


def LoadResults(
    directory: str | Path, *, damaged: dict[str, str] | None = None
) -> list[TrialResult]:
    """Reads the results in a folder that have recordings.

    These are all results of `WriteResult`, and one of each cell of a suite.
    Metrics have the values of the files; the series and the tables by behavior
    are computed from the recording again.

    Args:
        directory: The folder of results.
        damaged: Receives the faults of damaged runs, by their tags, and these
            runs are left out; without it they raise an error.

    Returns:
        The results in the order of their tags; those of a suite come first,
        by scenario and planner.

    Raises:
        OSError: If there are no results, or results of an old version.
        ValueError: If runs are damaged. Then no metric is computed, and no
            recording is read unless all rows are valid.
    """
    folder = Path(directory)
    kept = {
        row.tag or f"{path.parent.name}/{path.name}": (row, path)
        for row in sorted(read_folder(folder, damaged), key=run_order)
        if row.end_reason not in NO_RESULT
        and (path := find_recording(folder, row)) is not None
    }
    recordings = _read(
        {name: path for name, (_, path) in kept.items()},
        Recording.load,
        damaged,
    )
    return [
        _make_result(kept[name][0], recording)
        for name, recording in recordings.items()
    ]


def read_folder(
    directory: str | Path, damaged: dict[str, str] | None = None
) -> Iterator[RunRow]:
    """Yields the rows of all runs in a folder.

    They come from its log. Folders of runs that the log does not list are
    those of older versions, or of a writer that was killed: their
    `result.json` is read. Runs whose folder was deleted are left out.

    Args:
        directory: The folder of results.
        damaged: See `LoadResults`.

    Raises:
        OSError: If there are no results, or results of an old version.
        ValueError: If runs are damaged.
    """
    folders = _find(directory)
    log = Path(directory) / NAME
    # If a folder was deleted and written again, the last line is valid.
    single: dict[str, RunRow] = {}
    is_empty = True
    for row in read_rows(log) if log.is_file() else ():
        if not row.tag:
            is_empty = False
            yield row
        elif row.tag in folders:
            single[row.tag] = row
    yield from single.values()
    unknown = {tag: it for tag, it in folders.items() if tag not in single}
    if is_empty and not folders:
        raise FileNotFoundError(
            errno.ENOENT, _nothing_there(Path(directory)), str(directory)
        )
    yield from _read(unknown, _read_summary, damaged).values()


def run_order(row: RunRow) -> tuple[Any, ...]:
    """Returns a key that sorts the runs of a folder."""
    names = natural_key(row.tag), row.scenario, row.planner, row.setting
    return *names, -1 if row.seed is None else row.seed, row.repetition


def _read_summary(run: Path) -> RunRow:
    path = run / "result.json"
    try:
        return row_from_json(path.read_bytes())._replace(tag=run.name)
    except ValueError as error:
        raise ValueError(f"{path}: is not a result: {error}") from error


def _find(directory: str | Path) -> dict[str, Path]:
    """Returns the folders of single runs; refuses files of an old version."""
    folder = Path(directory)
    found = find_runs(folder)
    # Recordings of an old version are an error even if there are new runs.
    old = ["recording_*.npz"]
    old += [] if found or (folder / NAME).is_file() else ["metrics*.csv"]
    if any(any(folder.glob(pattern)) for pattern in old):
        raise OSError(
            errno.EINVAL,
            "This folder has results of an old version, which cannot be read."
            " Evaluate each recording again with `hunav evaluate FILE --out"
            " NEW_FOLDER`, or repeat the runs in a new folder",
            str(directory),
        )
    return found


def _nothing_there(folder: Path) -> str:
    inner = sorted(it.parent.name for it in folder.glob(f"*/{NAME}"))
    there = f"There are some in {', '.join(inner[:5])}. " if inner else ""
    return (
        f"No results are there. {there}`hunav run SCENARIO --out {folder}`"
        " writes some"
    )


def _read[Content](
    paths: dict[str, Path],
    read: Callable[[Path], Content],
    damaged: dict[str, str] | None = None,
) -> dict[str, Content]:
    """Reads a file of each run, by its tag: see `LoadResults`."""
    contents, faults = {}, {}
    for tag, path in paths.items():
        try:
            contents[tag] = read(path)
        except OSError as error:
            faults[tag] = f"{error.filename}: {error.strerror}"
        except ValueError as error:
            faults[tag] = str(error)
    texts = [
        f"{fault}. Delete the damaged run, and repeat it."
        for fault in faults.values()
    ]
    if damaged is not None:
        damaged |= zip(faults, texts, strict=True)
    elif texts:
        more = len(texts) - _MOST_NAMED
        end = [f"... and {more} more"] if more > 0 else []
        raise ValueError("\n".join(texts[:_MOST_NAMED] + end))
    return contents


def _make_result(row: RunRow, recording: Recording) -> TrialResult:
    told: Provenance = {"planner": row.planner, "drawn": row.drawn}
    if row.seed is not None:
        told["seed"] = row.seed
    result = MakeTrialResult(
        recording,
        scenario_name=row.scenario,
        # A user's metric may not be registered here.
        metric_names=list(
            dict.fromkeys(
                name for name in map(base_name, row.metrics) if name in METRICS
            )
        ),
        # The provenance of a suite is in its cells.
        provenance=row.provenance or told,
        # Runs without a result have no recording.
        end_reason=cast(EndReason, row.end_reason),
        end_message=row.end_message,
        end_time=row.end_time,
        robot_ends=cast(dict[str, EndReason], row.robot_ends),
    )
    found, attrs = result.tables, row.attrs
    own = found.evaluation._replace(values=row.metrics, units=attrs["units"])
    return dataclasses.replace(
        result,
        tables=MetricTables(own, found.evaluations_by_behavior, attrs),
        setting=row.setting,
        tag=row.tag,
    )


def _write_files(
    result: TrialResult, row: RunRow, folder: Path, format: Format
) -> None:
    texts = {"result.json": result_to_json(row)}
    for behavior, steps in result.tables.step_texts.items():
        of = f"_beh_{_unique(behavior)}" if behavior is not None else ""
        texts[f"steps{of}.csv"] = steps
    if format in RESULT_TEXTS:
        texts |= RESULT_TEXTS[format](result, row.tag)
    result.recording.save(folder / "recording.npz")
    for name, text in texts.items():
        (folder / name).write_bytes(text.encode())


def _tags(result: TrialResult) -> Iterator[str]:
    """Yields tags for a run, of which the first free one is used."""
    parts = [
        result.scenario_name or "trial",
        result.provenance.get("planner"),
        result.provenance.get("seed"),
    ]
    told = "_".join(str(p) for p in parts if p not in (None, ""))
    tag = file_name_part(result.tag or told)[:_LONGEST].lstrip(".-") or "trial"
    yield tag
    yield from (f"{tag}_run{i}" for i in itertools.count(2))


def _unique(text: str) -> str:
    """Returns a unique part of a file name for a text."""
    safe = file_name_part(text)[:_LONGEST]
    if safe == text:
        return text
    return f"{safe}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
