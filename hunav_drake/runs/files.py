"""Writes the results of a run into a folder of its own, and reads them."""

from collections.abc import Callable, Iterator
import dataclasses
import errno
import hashlib
import itertools
from pathlib import Path
from typing import Literal

from hunav_drake.runs.foreign_formats import RESULT_TEXTS
from hunav_drake.runs.run_folders import RUNS, find_runs, write_run_folder
from hunav_drake.runs.run_summary import RunSummary, make_summary, read_summary
from hunav_drake.systems.common.files import (
    FILE_NAME_RULE,
    file_name_part,
    is_file_name,
)
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.trial.result import MakeTrialResult, TrialResult

Format = Literal["csv", "hunav"]

# Numbers in tables: without the rounding of binary digits.
CSV_NUMBERS = "%.12g"

# The longest part of the name of a file that is made of other names.
_LONGEST = 80

# How many damaged runs an error names.
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
    """Writes a result into a folder of its own, `<directory>/runs/<tag>/`.

    The folder has `result.json` (metrics, also by behavior, what is known of
    them, provenance, end), `recording.npz`, and the series of metrics in
    `steps.csv` and `steps_beh_<behavior>.csv`. It appears with all its files
    or not at all, and is never changed; many processes may write into one
    directory at a time. Tables over all runs are made when they are read: see
    `ReadRuns`.

    A behavior whose name is not fit for that of a file is told apart by a hash
    after what is left of it. JSON knows no numbers that are not finite: NaN is
    null, and infinity is the text "Infinity" or "-Infinity".

    Args:
        result: What to write.
        directory: The folder of results; it is made if need be.
        tag: The name of the run's folder. By default scenario, planner and
            seed, and "run2", ... if that is taken.
        label: The setting, instead of the result's own: what tells this run
            from those of the same planner in the same scenario that differ by
            more than the seed. Statistics keep settings apart.
        format: With "hunav", the four kinds of text files of HuNavSim are
            written besides: see `hunav_texts`.
        add: Writes more files of the run, such as its report, into the folder
            that it is given, before the folder gets its name.

    Returns:
        The folder of the run.

    Raises:
        OSError: If something cannot be written, or if the tag is taken.
        ValueError: If the tag is not fit for the name of a folder.
    """
    if label is not None:
        result = dataclasses.replace(result, setting=label)
    if tag is not None and not is_file_name(tag):
        raise ValueError(f"the tag {FILE_NAME_RULE}, got {shown(tag)}")
    runs = Path(directory) / RUNS
    try:
        runs.mkdir(parents=True, exist_ok=True)
        taken = find_runs(directory)
        for name in _tags(result) if tag is None else [tag]:

            def write(folder: Path, name: str = name) -> None:
                _write_files(result, folder, name, format)
                if add is not None:
                    add(folder)

            if name not in taken and write_run_folder(runs / name, write):
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
    """Reads the results that `WriteResult` has written into a folder.

    Metrics have the values that were written; the series and the tables by
    behavior are computed again from the recording.

    Args:
        directory: The folder of results.
        damaged: Gets what is wrong with damaged runs, by their tags, which are
            left out then; without it they are an error.

    Returns:
        The results in the order of their tags.

    Raises:
        OSError: If there are no results, or those of an old version.
        ValueError: If runs are damaged. No metric is computed then, and no
            recording is read unless all summaries are sound.
    """
    found = _find(directory)
    summaries = _read(found, _read_summary, damaged)
    sound = {tag: found[tag] for tag in summaries}
    recordings = _read(
        sound, lambda run: Recording.load(run / "recording.npz"), damaged
    )
    return [
        _make_result(tag, summaries[tag], recording)
        for tag, recording in recordings.items()
    ]


def read_summaries(directory: str | Path) -> dict[str, RunSummary]:
    """Reads the summaries of all runs by their tags, and no recording.

    Raises:
        OSError: If there are no results, or those of an old version.
        ValueError: If runs are damaged.
    """
    return _read(_find(directory), _read_summary)


def _read_summary(run: Path) -> RunSummary:
    return read_summary(run / "result.json")


def _find(directory: str | Path) -> dict[str, Path]:
    found = find_runs(directory)
    # Beside new runs, recordings of an old version must not go unseen.
    old = ["recording_*.npz"] if found else ["recording_*.npz", "metrics*.csv"]
    if any(any(Path(directory).glob(pattern)) for pattern in old):
        raise OSError(
            errno.EINVAL,
            "This folder has results of an old version, which are not read."
            " Evaluate each recording again with `hunav evaluate FILE --out"
            " NEW_FOLDER`, or repeat the runs into a new folder",
            str(directory),
        )
    if not found:
        raise FileNotFoundError(
            errno.ENOENT,
            "No results are there. `hunav run SCENARIO --out"
            f" {directory}` writes some",
            str(directory),
        )
    return found


def _read[Content](
    runs: dict[str, Path],
    read: Callable[[Path], Content],
    damaged: dict[str, str] | None = None,
) -> dict[str, Content]:
    """Reads a part of each run: see `LoadResults`."""
    contents, faults = {}, {}
    for tag, run in runs.items():
        try:
            contents[tag] = read(run)
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


def _make_result(
    tag: str, summary: RunSummary, recording: Recording
) -> TrialResult:
    result = MakeTrialResult(
        recording,
        scenario_name=summary.scenario,
        # A metric of somebody's own may not be registered here.
        metric_names=[name for name in summary.metrics if name in METRICS],
        provenance=summary.provenance,
        end_reason=summary.end_reason,
        end_message=summary.end_message,
        end_time=summary.end_time,
    )
    return dataclasses.replace(
        result,
        metrics=summary.metric_values(),
        setting=summary.setting,
        tag=tag,
    )


def _write_files(
    result: TrialResult, folder: Path, tag: str, format: Format
) -> None:
    texts = {
        "result.json": make_summary(result).model_dump_json(indent=2),
        "steps.csv": result.steps.to_csv(float_format=CSV_NUMBERS),
    }
    for behavior, steps in result.steps_by_behavior.items():
        texts[f"steps_beh_{_unique(behavior)}.csv"] = steps.to_csv(
            float_format=CSV_NUMBERS
        )
    if format in RESULT_TEXTS:
        texts |= RESULT_TEXTS[format](result, tag)
    result.recording.save(folder / "recording.npz")
    for name, text in texts.items():
        (folder / name).write_bytes(text.encode())


def _tags(result: TrialResult) -> Iterator[str]:
    """Gives tags for a run, to take the first that is free."""
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
    """Returns a text that may be part of the name of a file, and no other's."""
    safe = file_name_part(text)[:_LONGEST]
    if safe == text:
        return text
    return f"{safe}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
