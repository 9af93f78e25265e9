"""All that a suite tells, but for what its runs have cost."""

from hunav_drake.runs.comparison.latex import to_latex
from hunav_drake.runs.comparison.relations import judge
from hunav_drake.runs.comparison.tables import behavior_tables, scenario_tables
from hunav_drake.runs.suite_tables import suite_json


def texts_of(result):
    """Returns tables and statistics as texts, by what they are."""
    tables = (*scenario_tables(result), *behavior_tables(result))
    return {
        "runs": result.runs().to_csv(),
        "by_behavior": result.runs(by_behavior=True).to_csv(),
        "extras": result.runs(extras=True).to_csv(),
        "json": suite_json(result, judge(result)),
        "latex": "\n".join(map(to_latex, tables)),
    }
