"""What results are at the prompt: a line that tells what they are of."""

from hunav_drake import Branches, FindSituations, find_encounters
from hunav_drake.runs import Suite, SuiteResult
from tests.hunav_drake.passing_trials import make_result


def test_results_are_a_line():
    result = make_result(seed=3, setting="wide", scenario_name="hall")
    assert repr(result).startswith(
        "<TrialResult of hall, pursuit, wide, seed 3: goal after "
    )
    recording = result.recording
    text = repr(recording)[1:]
    assert repr(FindSituations(recording)) == f"<Situations in the {text}"
    assert repr(find_encounters(recording)) == f"<Encounters in the {text}"
    suite = Suite(name="mine", scenarios=["crossing"], planners=["dwb"])
    assert repr(SuiteResult(suite, [], [])) == (
        "<SuiteResult of mine, 0 runs in 0 cells>"
    )
    branches = Branches(
        start=1.0, until=4.0, reference="same", human_names=(), futures={}
    )
    assert repr(branches) == "<Branches from 1 s to 4 s: >"
