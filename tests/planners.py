"""The shipped planners, for tests that all of them pass."""

NAMES = ["pursuit", "dwb", "scl", "sfw", "sfm", "orca", "mppi"]


def planner_override(name: str, parameters: str = "") -> str:
    """Returns the override of a scenario that takes a planner.

    Args:
        name: Of the planner.
        parameters: What else is said of it, as in YAML; without, `mppi` takes
            few samples, with which it decides fast, not as well.
    """
    few = {"mppi": "batch_size: 60, "}.get(name, "")
    return f"planner={{type: {name}, {few}{parameters}}}"
