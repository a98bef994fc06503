"""The parameters of a solution with their intervals, of the kind that the objective allows."""

import math
from collections.abc import Sequence

import numpy as np

from tuner.certificate.profile import limit
from tuner.certificate.sandwich import LongRun, sandwich
from tuner.certificate.solution import Interval, TunedParameter
from tuner.certificate.yardstick import NATS_95_ONE_SIDED, Yardstick
from tuner.problem.problem import Problem

WIDE = math.log(1e3)
"""A 95 % range of a mean square that is wider than this factor carries no information."""
RATIO, SANDWICH, SHARE = "95 %, likelihood ratio", "95 %, sandwich", "1 % of the cost"


def estimates(
    problem: Problem,
    z: np.ndarray,
    yard: Yardstick,
    hessian: np.ndarray | None,
    undetermined: Sequence[np.ndarray] = (),
) -> dict[str, TunedParameter]:
    """The parameters at z ``(n,)`` with their units and intervals.

    Args:
        problem: the problem.
        z: the best point.
        yard: how differences of its values are measured.
        hessian: in units of the yardstick, ``(n, n)``; None where it was not computed: then
            nothing has an interval.
        undetermined: directions ``(n,)`` along which nothing is determined; a parameter that only
            others determine together has no interval.
    """
    tied = {int(i) for d in undetermined if (np.abs(d) > 0).sum() > 1 for i in np.flatnonzero(d)}
    values, at = problem.parameters(z), 0
    usable = hessian is not None and np.isfinite(hessian).all()
    scatter = _scatter(problem, z, yard, hessian) if usable and hessian is not None else None
    found = {}
    for name, parameter in problem.space.parameters:
        interval = robust = None
        if usable and hessian is not None and parameter.size == 1 and at not in tied:
            interval, robust = _intervals(problem, z, yard, hessian, scatter, at, name)
        known = usable and parameter.size > 1 and hessian is not None
        found[name] = TunedParameter(
            values[name],
            parameter.unit,
            None if interval is None else interval.ends,
            "" if interval is None else interval.kind,
            None if robust is None else robust.ends,
            _deviation(problem, z, yard, hessian, scatter, name) if known else None,
        )
        at += parameter.size
    return found


def _deviation(
    problem: Problem,
    z: np.ndarray,
    yard: Yardstick,
    hessian: np.ndarray | None,
    scatter: LongRun | None,
    name: str,
) -> np.ndarray | None:
    """The standard deviation of each entry of a matrix, through its slopes in z."""
    if yard.kind == "likelihood" and hessian is not None:
        curvatures, directions = np.linalg.eigh(hessian)
        if not curvatures[0] * math.log(10) ** 2 > 1:  # not even a factor of ten
            return None
        covariance = (directions / curvatures) @ directions.T
    elif scatter is not None:
        covariance = scatter.covariance
    else:
        return None
    steps = 1e-5 * np.eye(len(z))
    slopes = [
        (problem.parameters(z + h)[name] - problem.parameters(z - h)[name]) / 2e-5 for h in steps
    ]
    gradient = np.stack(slopes, axis=-1)
    variance = np.einsum("...i,ij,...j->...", gradient, covariance, gradient)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


def _scatter(
    problem: Problem, z: np.ndarray, yard: Yardstick, hessian: np.ndarray
) -> LongRun | None:
    """The sandwich covariance of z; None for a cost, and where the record is too short."""
    if yard.kind == "cost" or problem.filter is None:
        return None
    if yard.kind == "likelihood":
        return sandwich(problem, z, hessian)
    # The mean of squares m and its root r: m = c r^2, so that N m has the Hessian 2 N c r r'' at
    # the best point, where r' = 0; the sum's own scale c N = sum of squares / r^2.
    from tuner.problem.samples import added

    total, value = float(added(problem, z).amounts.sum()), abs(problem.value(z))
    power = 2.0 if yard.kind == "root mean square" else 1.0
    return sandwich(problem, z, hessian * yard.unit / value * power * total) if value else None


def _intervals(
    problem: Problem,
    z: np.ndarray,
    yard: Yardstick,
    hessian: np.ndarray,
    scatter: LongRun | None,
    at: int,
    name: str,
) -> tuple[Interval | None, Interval | None]:
    """The interval of the parameter at a coordinate, and the robust one beside it."""
    if yard.kind in ("mean square", "root mean square"):
        return _of_scatter(problem, z, scatter, at, name), None
    kind = RATIO if yard.kind == "likelihood" else SHARE
    ends = [limit(problem, yard, z, hessian, at, side, yard.rise) for side in (-1, 1)]
    if not any(end.reached for end in ends):
        return None, None
    if yard.kind == "likelihood" and not all(end.reached for end in ends):
        side = -1 if ends[0].reached else 1
        one = limit(problem, yard, z, hessian, at, side, NATS_95_ONE_SIDED)
        ends[0 if side < 0 else 1] = one
    limits = [
        end.z if end.reached else unlimited
        for end, unlimited in zip(ends, _extremes(problem, at), strict=True)
    ]
    interval = Interval(_in_parameter(problem, z, at, name, limits), kind)
    return interval, _robust(problem, z, hessian, scatter, at, name, limits)


def _extremes(problem: Problem, at: int) -> tuple[float, float]:
    """Ends of an interval where none was reached: the parameter's own limits, or infinity."""
    low, high = problem.space.box()
    if problem.space.limited()[at]:
        return float(low[at]), float(high[at])
    return -np.inf, np.inf


def _robust(
    problem: Problem,
    z: np.ndarray,
    hessian: np.ndarray,
    scatter: LongRun | None,
    at: int,
    name: str,
    limits: list[float],
) -> Interval | None:
    """A likelihood ratio's interval, as much wider as the sandwich's deviation is than its own.

    Source: Kent, Biometrika 69, 1982.
    """
    if scatter is None or scatter.freedom < 3:
        return None
    own = np.linalg.pinv(hessian, rcond=1e-12, hermitian=True)[at, at]
    if not own > 0 or not scatter.covariance[at, at] > 0:
        return None
    wider = np.sqrt(scatter.covariance[at, at] / own) * _quantile(scatter.freedom) / 1.959964
    low, high = _extremes(problem, at)
    ends = [float(np.clip(z[at] + wider * (end - z[at]), low, high)) for end in limits]
    return Interval(_in_parameter(problem, z, at, name, ends), SANDWICH)


def _of_scatter(
    problem: Problem, z: np.ndarray, scatter: LongRun | None, at: int, name: str
) -> Interval | None:
    if scatter is None or scatter.freedom < 3:
        return None
    reach = _quantile(scatter.freedom) * float(np.sqrt(scatter.covariance[at, at]))
    if not 0 < reach < WIDE:
        return None
    ends = [float(z[at]) - reach, float(z[at]) + reach]
    tried = [problem.value(_moved(z, at, end)) for end in ends]
    if not np.isfinite(tried).all():
        return None
    return Interval(_in_parameter(problem, z, at, name, ends), SANDWICH)


def _quantile(freedom: float) -> float:
    """Of Student's distribution, 97.5 %."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.975))


def _in_parameter(
    problem: Problem, z: np.ndarray, at: int, name: str, ends: list[float]
) -> tuple[float, float]:
    """Ends of a coordinate as parameter values; an end that is not reached is the farthest one."""
    low, high = (float(problem.parameters(_moved(z, at, end))[name]) for end in ends)
    return low, high


def _moved(z: np.ndarray, at: int, to: float) -> np.ndarray:
    point = z.copy()
    point[at] = to
    return point
