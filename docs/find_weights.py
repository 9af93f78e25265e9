"""Draws weights of people at random, and judges them: see `calibration.md`.

python docs/find_weights.py zara01.txt eth.csv students003.txt ... --count 300

The files are those of the page. It prints a row for the present default and for
each draw: the larger of the relative differences of ADE and FDE over all files
- told nothing, from constant velocity, and the number of files in which both
  are better;
- told the true goal, from people without a social force;
- told the true goal, from version 0.1 (that of ADE, and that of FDE);
and then the first case of `hunav validate` that fails, of those that the
default passes. A draw that is too far off constant velocity, or from people
without a social force, meets no case. Rows are the same for the same options.
"""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import numpy as np

from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.crowd.social_force.model import SocialForceModel
from hunav_drake.systems.people.profile import RECORDED
from hunav_drake.validation.case import Setting, judge
from hunav_drake.validation.cases import CASES
from hunav_drake.validation.recorded import (
    BODY,
    PAST,
    CrowdPrediction,
    Goal,
    Predict,
    constant_velocity,
    read_windows,
)

# The limits of the relative differences.
AHEAD, TRUE, OLD_ADE, OLD_FDE = 0.02, 0.10, -0.15, -0.25

# The ranges, of which logarithms are drawn evenly: weights, the push of two who
# stand 0.5 m apart (in m/s^2), and the ratio of n' to n. Wider ones have few
# draws that are near recorded people.
RANGES = {
    "gamma": (0.05, 0.09),
    "push": (0.008, 0.3),
    "lambda_importance": (2.0, 4.5),
    "n": (2.0, 14.0),
    "ratio": (1.0, 2.0),
    "time_gap": (0.55, 1.0),
    "speed_matching": (0.3, 0.65),
}
MOST = 1000.0


class Draw(NamedTuple):
    """The weights of everybody, and how they follow."""

    weights: dict[str, float]
    model: SocialForceModel


def draws(seed: int) -> Iterator[Draw]:
    """Yields the present default, and then draws without an end."""
    names = ("social_factor", "lambda_importance", "gamma", "n", "n_prime")
    yield Draw(
        {name: getattr(RECORDED, name) for name in names}, SocialForceModel()
    )
    generator = np.random.default_rng(seed)
    while True:
        own = {
            name: float(np.exp(generator.uniform(*np.log(ends))))
            for name, ends in RANGES.items()
        }
        weights = {
            "social_factor": own["push"] * np.exp(0.5 / own["gamma"]),
            "lambda_importance": own["lambda_importance"],
            "gamma": own["gamma"],
            "n": own["n"],
            "n_prime": own["n"] * own["ratio"],
        }
        if weights["social_factor"] <= MOST:
            yield Draw(
                {name: float(f"{it:.2g}") for name, it in weights.items()},
                SocialForceModel(
                    time_gap=round(own["time_gap"], 2),
                    speed_matching=round(own["speed_matching"], 2),
                ),
            )


def errors(
    scenes: Sequence[list[np.ndarray]], predict: Predict, goal: Goal
) -> np.ndarray:
    """Returns ADE and FDE of each scene, shape (k, 2), in meters."""
    rows = []
    for windows in scenes:
        off = [it[:, PAST:] - predict(it, goal) for it in windows]
        far = np.hypot(*np.moveaxis(np.concatenate(off), 2, 0))
        rows.append((far.mean(), far[:, -1].mean()))
    return np.array(rows)


class Judge:
    """Tells how far draws are from recorded people, and which case fails."""

    def __init__(
        self, scenes: Sequence[list[np.ndarray]], radius: float, default: Draw
    ) -> None:
        """Finds what does not depend on draws.

        Args:
            scenes: The windows of each file.
            radius: The radius of people, in meters.
            default: The draw whose cases are those to pass.
        """
        self._scenes = scenes
        self._radius = radius
        self._straight = errors(scenes, constant_velocity, "ahead")
        old = CrowdConfig(profile="hunav_drake_0.1")
        self._old = errors(scenes, CrowdPrediction(old, radius=radius), "true")
        with mock.patch.multiple(RECORDED, **default.weights):
            outcomes = [judge(it, setting(default)) for it in CASES.values()]
        self._cases = [it.case for it in outcomes if it.verdict == "passes"]

    def row(self, draw: Draw, *, always: bool) -> str:
        """Returns the row of a draw; `always` with a case."""
        config = CrowdConfig(model=draw.model)

        def relative(goal: Goal, base: np.ndarray) -> np.ndarray:
            model = CrowdPrediction(config, draw.weights, radius=self._radius)
            return errors(self._scenes, model, goal) / base - 1

        free = CrowdPrediction(
            config, {"social_factor": 0.0}, radius=self._radius
        )
        ahead = relative("ahead", self._straight)
        true = relative("true", errors(self._scenes, free, "true"))
        old = relative("true", self._old).max(axis=0)
        better = int((ahead.max(axis=1) < 0).sum())
        near = (
            ahead.max() <= AHEAD
            and better >= 2
            and true.max() <= TRUE
            and old[0] <= OLD_ADE
            and old[1] <= OLD_FDE
        )
        case = self._first_failed(draw) if near or always else "-"
        numbers = [*draw.weights.values()]
        numbers += [draw.model.time_gap, draw.model.speed_matching]
        return " | ".join(
            [
                *(f"{it:g}" for it in numbers),
                *(f"{ahead.max():+.1%}", str(better), f"{true.max():+.1%}"),
                *(f"{it:+.0%}" for it in old),
                case,
            ]
        )

    def _first_failed(self, draw: Draw) -> str:
        with mock.patch.multiple(RECORDED, **draw.weights):
            for name in self._cases:
                if judge(CASES[name], setting(draw)).verdict == "fails":
                    return name
        return "none"


def setting(draw: Draw) -> Setting:
    """Returns the setting of a case with the model of a draw."""
    # (mypy takes the name of the model for any text.)
    return Setting(draw.model)  # type: ignore[arg-type]


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--body-radius", type=float, default=BODY)
    options = parser.parse_args()
    scenes = [read_windows(file) for file in options.files]
    found = draws(options.seed)
    default = next(found)
    told = Judge(scenes, options.body_radius, default)
    print(
        "k_s | lambda | gamma | n | n' | time gap | matching | told nothing |"
        " better in | true goal | ADE, 0.1 | FDE, 0.1 | fails"
    )
    print(told.row(default, always=True), flush=True)
    for _ in range(options.count):
        print(told.row(next(found), always=False), flush=True)


if __name__ == "__main__":
    main()
