"""Whether the names in a suite are names of something."""

from collections.abc import Iterable, Iterator, Sequence
import re

from hunav_drake.benchmark.formula import formula_name, names_in
from hunav_drake.benchmark.suite import Relation, Suite, planner_overrides
from hunav_drake.scenario import Fault, Scenario
from hunav_drake.scenario.error import Finding
from hunav_drake.scenario.population import draw_people
from hunav_drake.scenario.shipped import shipped_names
from hunav_drake.systems.behavior import BEHAVIORS
from hunav_drake.systems.common.suggest import did_you_mean, shown, suggestion
from hunav_drake.systems.evaluation.metrics import METRICS, select_metrics
from hunav_drake.systems.people.behavior_choice import behavior_name
from hunav_drake.systems.planning import PLANNERS

# Numbers of a run besides its metrics: see `extra_values`.
_EXTRAS = re.compile(
    "lowest_speed_near_people|cruising_speed|walked_per_person"
    r"|min_dist_to_person_\d+"
)


def formula_findings(suite: Suite) -> Iterator[Finding]:
    """Yields what formulas about planners call by no planner's name.

    Planners that are registered are known, also where a suite lacks them: then
    its relations are not tested.
    """
    labels = [planner_overrides(choice)[0] for choice in suite.planners]
    known = list(map(formula_name, dict.fromkeys([*labels, *PLANNERS])))
    for i, relation in enumerate(suite.relations):
        if relation.by != "planner":
            continue
        valid = known
        if len(relation.scenarios) > 1:
            valid = [
                formula_name(f"{planner}_{scenario}")
                for planner in known
                for scenario in relation.scenarios
            ]
        loc = "relations", i, "holds"
        for name in names_in(relation.holds):
            if name not in valid:
                told = _unknown("planner", name, valid)
                yield Finding(loc, f"{told}, in {relation.holds!r:.80}")


def name_faults(suite: Suite, scenarios: Sequence[Scenario]) -> Iterator[Fault]:
    """Yields the names of scenarios, metrics and behaviors that nothing has.

    What is shipped is known, also where a suite lacks it.

    Args:
        suite: The suite.
        scenarios: Those of its cells.
    """
    by_name = {scenario.name: scenario for scenario in scenarios}
    valid = list(dict.fromkeys([*by_name, *shipped_names()]))
    for name in suite.seeds_of:
        if name not in valid:
            yield _fault("seeds_of", _unknown("scenario", name, valid))
    if suite.until:
        for scenario in by_name.values():
            told = _metric_fault(suite.until.metric, [scenario])
            if told:
                yield _fault("until.metric", told)
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
        told = "" if is_extra else _metric_fault(relation.metric, own)
        if told:
            yield _fault(f"{place}.metric", told)
        if relation.by != "planner" and own:
            yield from _behavior_faults(f"{place}.holds", relation, own[0])


def _behavior_faults(
    place: str, relation: Relation, scenario: Scenario
) -> Iterator[Fault]:
    people = (behavior_name(it.behavior) for it in draw_people(scenario))
    valid = list(map(formula_name, dict.fromkeys([*people, *BEHAVIORS])))
    for name in names_in(relation.holds):
        ends = name if relation.by == "behavior" else name.partition("_")[2]
        is_known = name in valid
        if relation.by == "both":
            is_known = any(name.endswith(f"_{it}") for it in valid)
        if not is_known:
            told = _unknown("behavior", ends or name, valid)
            yield _fault(place, f"{told}, in {relation.holds!r:.80}")


def _metric_fault(name: str, scenarios: Sequence[Scenario]) -> str:
    """Returns why a metric is unknown where it is to be; nothing if it is."""
    if name not in METRICS:
        near = did_you_mean(name, METRICS) or "; see `hunav metrics`"
        return f"there is no metric {shown(name)}{near}"
    for scenario in scenarios:
        computed = [
            it.name for it in select_metrics(scenario.evaluator.metrics)
        ]
        if name not in computed:
            return (
                f"{shown(name)} is not computed in {scenario.name}; add it to"
                " evaluator.metrics there"
            )
    return ""


def _unknown(kind: str, name: str, valid: Iterable[str]) -> str:
    return f"there is no {kind} {shown(name)}; {suggestion(name, list(valid))}"


def _fault(path: str, message: str) -> Fault:
    return Fault("suite", 0, path, message)
