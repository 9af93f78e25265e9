"""Checks of the names in a suite."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
import re

from hunav_drake.runs.formula import formula_name, names_in
from hunav_drake.runs.suite import Suite, planner_overrides
from hunav_drake.scenario import Fault, Scenario
from hunav_drake.scenario.error import Finding
from hunav_drake.scenario.population import draw_people, has_recorded_people
from hunav_drake.scenarios import shipped_names
from hunav_drake.systems.behavior import BEHAVIORS
from hunav_drake.systems.common.suggest import did_you_mean, shown, suggestion
from hunav_drake.systems.evaluation.metric import REPLAY_FAMILY
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.people.behavior_choice import behavior_name
from hunav_drake.systems.planning import PLANNERS

# Numbers of a run besides its metrics: see `extra_values`.
_EXTRAS = re.compile(
    "lowest_speed_near_people|cruising_speed|walked_per_person"
    r"|min_dist_to_person_\d+"
)


def formula_findings(suite: Suite) -> Iterator[Finding]:
    """Yields names in formulas about planners that are unknown or ambiguous.

    Registered planners are known even if the suite does not have them: then
    its relations are not tested.
    """
    planners = _known_planners(suite)
    for i, relation in enumerate(suite.relations):
        if relation.by == "planner":
            several = len(relation.scenarios) > 1
            parts = [planners, relation.scenarios] if several else [planners]
            for told in _formula_faults("planner", relation.holds, parts):
                yield Finding(("relations", i, "holds"), told)


def name_faults(suite: Suite, scenarios: Sequence[Scenario]) -> Iterator[Fault]:
    """Yields unknown names of scenarios, metrics and behaviors.

    Shipped ones are known even if the suite does not have them.

    Args:
        suite: The suite.
        scenarios: The scenarios of its cells.
    """
    by_name = {scenario.name: scenario for scenario in scenarios}
    valid = list(dict.fromkeys([*by_name, *shipped_names()]))
    for name in suite.seeds_of:
        if name not in valid:
            yield _fault("seeds_of", _unknown("scenario", name, valid))
    if suite.until:
        for told in _metric_faults(suite.until.metric, by_name.values()):
            yield _fault("until.metric", told)
    # LoadSuite has checked those of a file, but not of other suites.
    for found in formula_findings(suite):
        yield _fault(f"relations[{found.loc[1]}].holds", found.message)
    planners = _known_planners(suite)
    for i, relation in enumerate(suite.relations):
        place = f"relations[{i}]"
        for name in relation.scenarios:
            if name not in valid:
                told = _unknown("scenario", name, valid)
                yield _fault(f"{place}.scenarios", told)
        own = [by_name[it] for it in relation.scenarios if it in by_name]
        is_extra = relation.by == "planner" and _EXTRAS.fullmatch(
            relation.metric
        )
        if not is_extra:
            for told in _metric_faults(relation.metric, own):
                yield _fault(f"{place}.metric", told)
        for scenario in own if relation.by != "planner" else ():
            people = (
                behavior_name(it.behavior) for it in draw_people(scenario)
            )
            behaviors = _with_shipped(people, BEHAVIORS)
            parts, kind = [behaviors], "behavior"
            if relation.by == "both":
                parts, kind = [planners, behaviors], "planner and behavior"
            for told in _formula_faults(kind, relation.holds, parts):
                yield _fault(f"{place}.holds", told)


def _known_planners(suite: Suite) -> list[str]:
    labels = (planner_overrides(choice)[0] for choice in suite.planners)
    return _with_shipped(labels, PLANNERS)


def _with_shipped(own: Iterable[str], shipped: Iterable[str]) -> list[str]:
    """Returns labels, and shipped ones with other names in formulas."""
    own = list(dict.fromkeys(own))
    names = set(map(formula_name, own))
    return [*own, *(it for it in shipped if formula_name(it) not in names)]


def _formula_faults(
    kind: str, formula: str, parts: Iterable[Iterable[str]]
) -> Iterator[str]:
    """Yields names in a formula that are unknown or ambiguous.

    Args:
        kind: What the names are of, for the message.
        formula: The formula.
        parts: The parts of its names: one of each, in this order.
    """
    called: dict[str, list[str]] = {}
    for place in dict.fromkeys(product(*parts)):
        name = formula_name("_".join(place))
        called.setdefault(name, []).append("/".join(place))
    for name in names_in(formula):
        meant = called.get(name, ())
        if len(meant) == 1:
            continue
        told = _unknown(kind, name, called)
        if meant:
            told = (
                f"{shown(name)} is the name in formulas of"
                f" {' and '.join(map(shown, meant))}; give them labels that"
                " differ in letters or digits"
            )
        yield f"{told}, in {formula!r:.80}"


def _metric_faults(name: str, scenarios: Iterable[Scenario]) -> Iterator[str]:
    """Yields a message if a metric is unknown, or not computed."""
    if name not in METRICS:
        near = did_you_mean(name, METRICS) or "; see `hunav metrics`"
        yield f"there is no metric {shown(name)}{near}"
        return
    for scenario in scenarios:
        chosen = scenario.evaluator.metrics
        lacks = METRICS[name].family == REPLAY_FAMILY and name not in chosen
        if name not in (it.name for it in select_metrics(chosen)) or (
            lacks and not has_recorded_people(scenario)
        ):
            yield (
                f"{shown(name)} is not computed in {scenario.name}; add it to"
                " evaluator.metrics there"
            )


def _unknown(kind: str, name: str, valid: Iterable[str]) -> str:
    return f"there is no {kind} {shown(name)}; {suggestion(name, list(valid))}"


def _fault(path: str, message: str) -> Fault:
    return Fault("suite", 0, path, message)
