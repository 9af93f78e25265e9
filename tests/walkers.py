"""People who walk side by side."""

from hunav_drake.systems.people.human_config import HumanConfig


def make_walkers(n, *, xs=(6.0, 0.0), spacing=2.0, cyclic=True, **kwargs):
    """Returns people who start at x = 0 and walk along the x-axis.

    Args:
        n: How many.
        xs: The x of each goal, in turn, in meters.
        spacing: How far they are from each other, in meters.
        cyclic: Whether the first goal follows the last.
        kwargs: Attributes of each HumanConfig.
    """
    return [
        HumanConfig(
            pose=[0, spacing * i, 0],
            goals=[[x, spacing * i] for x in xs],
            cyclic=cyclic,
            **kwargs,
        )
        for i in range(n)
    ]
