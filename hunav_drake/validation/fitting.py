"""Fits the weights of forces to recorded people."""

from collections.abc import Callable, Sequence
import dataclasses
import math
from typing import NamedTuple, get_args

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_choice
from hunav_drake.systems.common.suggest import shown, suggestion
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.parameters import (
    PARAMETERS,
    SocialForceParameters,
)
from hunav_drake.systems.people.profile import own_forces
from hunav_drake.systems.world.obstacles import Obstacles
from hunav_drake.validation.recorded import PAST, CrowdPrediction, Goal

# Weights that only act at walls.
_AT_WALLS = ("obstacle_factor", "obstacle_sigma")
# Weights that only act in groups, which recordings do not tell.
_IN_GROUPS = tuple(name for name in PARAMETERS if name.startswith("group_"))

# Farther off, in meters, a sample counts less (soft_l1): people may have had
# reasons that no model knows.
_OUTLIER = 0.3
# The step of finite differences, as a part of the default. Smaller ones see the
# instants at which somebody passes another on the other side: there, distances
# from the recording jump.
_STEP = 0.1
# For the errors, a derivative is the median of the differences at these parts,
# to both sides: a jump is in some of them only.
_PARTS = (0.1, 0.03, 0.01, 0.003, 0.001)
# A weight of which nothing depends by more, per unit, changes nothing.
_IDLE = 1e-9
# The parts of the present value that are tried first, for the same reason; and
# how often for each weight in turn.
_TRIED = (0.02, 0.06, 0.15, 0.3, 0.5, 0.7, 0.85, 1.2, 1.5, 2.0, 3.0)
_ROUNDS = 2
# From this correlation on, two weights cannot be told apart.
_ALIKE = 0.9


class Fit(NamedTuple):
    """Weights that make simulated people walk like recorded ones.

    Attributes:
        forces: All weights, with the fitted ones.
        values: The fitted weights by name.
        errors: Their standard errors, with whole windows as the independent
            observations (the sandwich estimate); infinite where the recordings
            do not tell them.
        correlation: Shape (k, k), of the errors.
        before: The root mean square distance from the recording with the
            weights before the fit, in meters.
        after: The same with the fitted weights.
        people: The number of paths.
        warnings: What to know about the result, a line each.
        windows: The number of windows that the paths are in.
    """

    forces: SocialForceParameters
    values: dict[str, float]
    errors: dict[str, float]
    correlation: Array
    before: float
    after: float
    people: int
    warnings: tuple[str, ...]
    windows: int


def FitForces(
    windows: Sequence[Array],
    free: Sequence[str] = ("social_factor",),
    *,
    config: CrowdConfig | None = None,
    goal: Goal = "true",
    obstacles: Obstacles | None = None,
) -> Fit:
    """Fits weights of the social force model to recorded people.

    It minimizes the distances of predicted from recorded positions, over all
    windows together (least squares, with less weight for outliers). It starts
    from the weights of the profile of `config`, and the others keep them.

    Args:
        windows: Those of `windows_of`, of one recording or several.
        free: The names of the weights to fit, fields of
            `SocialForceParameters`.
        config: How people perceive the world; by default, `CrowdConfig()`.
        goal: What the model is told of each: see `recorded`.
        obstacles: The walls; none by default.

    Raises:
        ValueError: If a name is unknown or there twice, or the recording can
            tell nothing about it.
    """
    from scipy.optimize import least_squares, minimize

    check_choice("goal", goal, get_args(Goal))
    names = list(free)
    _check(names, windows, obstacles)
    config = config or CrowdConfig()
    model = CrowdPrediction(config, obstacles=obstacles)
    runs = [model.prepare(window, goal) for window in windows]
    truth = [window[:, PAST:] for window in windows]

    def residuals(values: Array) -> Array:
        weights = dict(zip(names, values.tolist(), strict=True))
        parts = [
            (run(weights) - real).ravel()
            for run, real in zip(runs, truth, strict=True)
        ]
        return np.concatenate(parts)

    begin = own_forces(HumanConfig(pose=(0.0, 0.0, 0.0)), config.profile)
    start = np.array([getattr(begin, name) for name in names])
    scales = np.maximum(np.abs(start), _STEP)
    sizes = [real.size for real in truth]
    low, high = np.array([_bounds(name) for name in names]).T

    def jacobian(values: Array) -> Array:
        columns = []
        for k, step in enumerate(_STEP * scales):
            more, less = values.copy(), values.copy()
            more[k] = min(more[k] + step, high[k])
            less[k] = max(less[k] - step, low[k])
            change = residuals(more) - residuals(less)
            columns.append(change / (more[k] - less[k]))
        return np.column_stack(columns)

    near = least_squares(
        residuals,
        _scan(residuals, start, low, high),
        jac=jacobian,
        bounds=(low, high),
        loss="soft_l1",
        f_scale=_OUTLIER,
        x_scale=scales,
        xtol=1e-3,
    ).x
    # (So coarse differences lead near the least only.)
    found = minimize(
        lambda values: _cost(residuals(values * scales)),
        near / scales,
        method="Nelder-Mead",
        bounds=np.column_stack([low, high]) / scales[:, None],
        options={"xatol": 1e-3, "fatol": math.inf},
    ).x
    found = np.clip(found * scales, low, high)
    slopes = _slopes(residuals, found, scales, low, high)
    idle = np.abs(slopes).max(axis=0) < _IDLE
    slopes[:, idle] = 0.0
    back = np.where(idle, start, found)
    # (Their steps were noise, unless they have led away from what fits worse.)
    if _cost(residuals(back)) <= _cost(residuals(found)) + _IDLE:
        found = back
    offsets = residuals(found)
    covariance, warnings = _covariance(slopes, offsets, names, sizes)
    errors = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore"):
        correlation = covariance / np.outer(errors, errors)
    np.fill_diagonal(correlation, 1.0)
    for i in range(len(names)):
        if min(found[i] - low[i], high[i] - found[i]) < 1e-6:
            warnings.append(
                f"{names[i]} is at its bound, {found[i]:g}: the recording"
                " wants even more; its error does not count"
            )
        for j in range(i):
            if abs(correlation[i, j]) > _ALIKE:
                warnings.append(
                    f"{names[j]} and {names[i]} cannot be told apart"
                    f" (correlation {correlation[i, j]:.2f}): keep one of them"
                    " at its default, or add other recordings"
                )
    values = dict(zip(names, found.tolist(), strict=True))
    return Fit(
        dataclasses.replace(begin, **values),
        values,
        dict(zip(names, errors.tolist(), strict=True)),
        correlation,
        _rms(residuals(start)),
        _rms(offsets),
        sum(map(len, windows)),
        tuple(warnings),
        len(windows),
    )


def _scan(
    residuals: Callable[[Array], Array], start: Array, low: Array, high: Array
) -> Array:
    """Returns the best of some values of one weight after the other.

    Each weight is the first once.
    """
    best, least = start, _cost(residuals(start))
    for first in range(len(start)):
        now, lowest = start, math.inf
        for k in [*range(first, len(start)), *range(first)] * _ROUNDS:
            base = now
            for part in (1.0, *_TRIED):
                tried = base.copy()
                tried[k] = np.clip(part * base[k], low[k], high[k])
                cost = _cost(residuals(tried))
                if cost < lowest:
                    now, lowest = tried, cost
        if lowest < least:
            best, least = now, lowest
    return np.clip(best, low + 1e-9, high - 1e-9)


def _slopes(
    residuals: Callable[[Array], Array],
    values: Array,
    scales: Array,
    low: Array,
    high: Array,
) -> Array:
    """Returns the derivatives of the residuals, but for their jumps."""
    here, columns = residuals(values), []
    for k, scale in enumerate(scales):
        slopes = []
        for part in (*_PARTS, *(-it for it in _PARTS)):
            moved = values.copy()
            moved[k] = np.clip(moved[k] + part * scale, low[k], high[k])
            if moved[k] != values[k]:
                change = residuals(moved) - here
                slopes.append(change / (moved[k] - values[k]))
        columns.append(np.median(slopes, axis=0))
    return np.column_stack(columns)


def _cost(offsets: Array) -> float:
    """Returns half the sum of `soft_l1` of the offsets."""
    z = (offsets / _OUTLIER) ** 2
    return float(_OUTLIER**2 * np.sum(np.sqrt(1 + z) - 1))


def _rms(offsets: Array) -> float:
    """Returns the root mean square distance of offsets (x, y, x, ...)."""
    return math.sqrt(2 * float(np.mean(offsets**2)))


def _bounds(name: str) -> tuple[float, float]:
    """Returns the range of a weight: see `SocialForceParameters`."""
    if name == "epsilon":
        return -1.0, 1.0
    positive = name in ("relaxation_time", "obstacle_sigma", "gamma")
    return (1e-3 if positive else 0.0), 1e3


def _check(
    names: list[str], windows: Sequence[Array], obstacles: Obstacles | None
) -> None:
    known = [name for name in PARAMETERS if name not in _IN_GROUPS]
    for name in names:
        if name in _IN_GROUPS:
            raise ValueError(
                f"free: {name} acts in groups only, which a recording does not"
                f" tell; {suggestion('', known)}"
            )
        if name not in known:
            raise ValueError(
                f"free: there is no weight {shown(name)};"
                f" {suggestion(name, known)}"
            )
        if name in _AT_WALLS and not obstacles:
            raise ValueError(
                f"free: {name} acts at walls only, and there are none; give"
                " walls, or leave it out"
            )
    if len(set(names)) < len(names) or not names:
        raise ValueError(
            f"free: must be some weights, each once, got {', '.join(names)}"
        )
    if not windows:
        raise ValueError("windows: there are none; see `windows_of`")


def _covariance(
    J: Array, offsets: Array, names: list[str], sizes: list[int]
) -> tuple[Array, list[str]]:
    """Returns the covariance of fitted weights, and warnings.

    People of a window act on each other, and a path is one decision: so the
    windows are independent, and not their samples. `J` are the derivatives of
    the offsets, of which each window has as many as `sizes` tells.
    """
    weights = 1 / np.sqrt(1 + (offsets / _OUTLIER) ** 2)
    H = J.T @ (weights[:, None] * J)
    warnings = []
    idle = [name for name, h in zip(names, np.diag(H), strict=True) if h == 0]
    if idle:
        warnings.append(
            f"{', '.join(idle)} changes nothing in these recordings near the"
            " value found; leave it out"
        )
    scores = np.array(
        [
            part.sum(axis=0)
            for part in np.split(
                J * (weights * offsets)[:, None], np.cumsum(sizes)[:-1]
            )
        ]
    )
    inverse = np.linalg.pinv(H)
    count = len(sizes)
    covariance: Array = inverse @ (scores.T @ scores) @ inverse
    if count <= len(names):
        warnings.append(
            f"{count} window{'s' * (count > 1)} of 8 s cannot tell the errors"
            f" of {len(names)} weight{'s' * (len(names) > 1)}; add recordings"
        )
        unknown = np.full_like(covariance, np.nan)
        np.fill_diagonal(unknown, np.inf)
        return unknown, warnings
    covariance *= count / (count - 1)
    for k, name in enumerate(names):
        if name in idle:
            covariance[k, :] = covariance[:, k] = np.nan
            covariance[k, k] = np.inf
    return covariance, warnings


def fit_text(fit: Fit) -> str:
    """Returns a fit as lines for a terminal."""
    from scipy.stats import t as student

    # (Few windows tell the errors themselves with an error.)
    wide = student.ppf(0.975, max(fit.windows - len(fit.values), 1))
    lines = [
        f"{fit.people} paths: {fit.before:.3f} m from the recording before the"
        f" fit, {fit.after:.3f} m after it (root mean square)",
        "",
        "  weight              value   standard error   95 %",
    ]
    for name, value in fit.values.items():
        error = fit.errors[name]
        lines.append(
            f"  {name:18} {value:7.3f} {error:10.3f}         "
            f"{value - wide * error:.3f} to {value + wide * error:.3f}"
        )
    if len(fit.values) > 1:
        lines += ["", "  correlations"]
        for name, row in zip(fit.values, fit.correlation, strict=True):
            cells = ("     -" if math.isnan(c) else f"{c:6.2f}" for c in row)
            lines.append(f"  {name:18} " + " ".join(cells))
    return "\n".join([*lines, *(f"Note: {text}." for text in fit.warnings)])


def forces_yaml(forces: SocialForceParameters) -> str:
    """Returns weights as a scenario has them in `forces` of a person."""
    rows = [f"  {name}: {getattr(forces, name)!r}" for name in PARAMETERS]
    return "\n".join(["forces:", *rows]) + "\n"
