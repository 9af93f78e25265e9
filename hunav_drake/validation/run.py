"""Measures cases for models, in one or several processes."""

from collections.abc import Callable, Iterable, Iterator, Sequence

from hunav_drake.runs.worker_pool import WorkerPool
from hunav_drake.systems.common.suggest import did_you_mean, shown
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
from hunav_drake.validation.case import Outcome, Setting, judge
from hunav_drake.validation.cases import CASES

_Task = tuple[str, Setting]


def select_models(names: Iterable[str] = ()) -> list[str]:
    """Returns the names of motion models, by default of all, in order.

    Raises:
        ValueError: If there is no model of a name.
    """
    return _select(names, sorted(MOTION_MODELS), "motion model")


def select_cases(names: Iterable[str] = ()) -> list[str]:
    """Returns the names of cases, by default of all, in order.

    Raises:
        ValueError: If there is no case of a name.
    """
    return _select(names, list(CASES), "case")


def _select(names: Iterable[str], known: list[str], kind: str) -> list[str]:
    chosen = set(names)
    for name in sorted(chosen):
        if name not in known:
            raise ValueError(
                f"there is no {kind}"
                f" {shown(name)}{did_you_mean(name, known)} (there"
                f" are: {', '.join(known)})"
            )
    return [name for name in known if name in chosen or not chosen]


def run_cases(
    cases: Sequence[str],
    settings: Sequence[Setting],
    *,
    workers: int = 1,
    imports: Sequence[str] = (),
    progress: Callable[[Outcome], object] = lambda outcome: None,
) -> list[Outcome]:
    """Measures each case with each setting.

    The result does not depend on the number of processes.

    Args:
        cases: The names of cases.
        settings: The models, with seed and size.
        workers: The number of processes; with 1, only this process.
        imports: Modules and files that each other process imports first, as
            with `--import`.
        progress: Called with each outcome, in order.

    Returns:
        The outcomes of all settings, case by case.
    """
    tasks = [(case, setting) for case in cases for setting in settings]
    outcomes = []
    for outcome in _outcomes(tasks, min(workers, len(tasks)), imports):
        progress(outcome)
        outcomes.append(outcome)
    return outcomes


def _outcomes(
    tasks: list[_Task], workers: int, imports: Sequence[str]
) -> Iterator[Outcome]:
    if workers <= 1:
        yield from map(_judge, tasks)
        return
    with WorkerPool(workers, imports) as pool:
        yield from pool.map(_judge, tasks)


def _judge(task: _Task) -> Outcome:
    name, setting = task
    return judge(CASES[name], setting)
