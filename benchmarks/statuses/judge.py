"""Verdicts on a solver's statements about its end."""

import re
from dataclasses import dataclass

import numpy as np

from benchmarks.statuses.case import Case
from tuner import Solution, Status

AROUND = 0.5
"""Distance from an end, in z, within which a lower point is sought."""
END = 0.011
"""A coordinate this close to an end of its box lies on it."""


@dataclass(frozen=True)
class Verdict:
    """One end of one solver.

    Attributes:
        family, case, solver: the problem and its solver.
        status: how it ended, in words; the error's first words where there was one.
        gap: value less the best, over the tolerance: above 1 the optimum was missed.
        agreed: whether more than half of several starts came to the same end.
        wrong: trusted, and worse than the best point of the box.
        near: trusted, and worse than a point close by, or than one beyond an end that holds it.
        alarm: the optimum, inside the box, and not trusted.
        differs: an alarm because starts differ, where there are wells of different depth.
        lies: number of sentences that wrongly say that a step changes nothing.
        silent: a trusted optimum without a sentence about its flat direction.
        raised: whether the solver raised an error.
    """

    family: str
    case: str
    solver: str
    status: str
    gap: float
    agreed: bool = False
    wrong: bool = False
    near: bool = False
    alarm: bool = False
    differs: bool = False
    lies: int = 0
    silent: bool = False
    raised: bool = False


def judge(case: Case, solver: str, solution: Solution) -> Verdict:
    """Compare a solution with the known one."""
    z, trusted = solution.z, solution.status.trusted
    value = float(case.values(z[None])[0])
    gap = (value - case.best) / case.tolerance if case.tolerance else np.sign(value - case.best)
    ends = _ends(case, z)
    held = bool(ends.any())
    good = abs(gap) <= 1 and not held and not case.beyond
    starts = solution.certificate.starts
    lowest = min(_around(case, z), _outside(case, z, ends))
    alarm = good and not trusted
    return Verdict(
        case.family,
        case.name,
        solver,
        solution.status.value,
        float(gap),
        agreed=starts.count > 1 and 2 * starts.agreeing > starts.count,
        wrong=bool(trusted and gap > 1),
        near=bool(trusted and value - lowest > case.tolerance),
        alarm=bool(alarm),
        differs=bool(alarm) and case.several and solution.status.name == "STARTS_DIFFER",
        lies=sum(_untrue(case, z, value, told) for told in solution.certificate.flat_directions),
        silent=bool(case.flat) and good and trusted and not solution.certificate.flat_directions,
    )


def raised(case: Case, solver: str, error: Exception) -> Verdict:
    """A solver that broke off."""
    words = f"{type(error).__name__}: {error}"[:70]
    return Verdict(case.family, case.name, solver, words, np.inf, raised=True, alarm=True)


def _ends(case: Case, z: np.ndarray) -> np.ndarray:
    """The ends of the search box on which z lies, -1, 0 or 1, ``(n,)``; limits are none."""
    low, high = case.problem.space.box()
    ends = 1.0 * (np.abs(z - high) <= END) - (np.abs(z - low) <= END)
    return np.where(case.problem.space.limited(), 0.0, ends)


def _outside(case: Case, z: np.ndarray, ends: np.ndarray) -> float:
    """The lowest value further out, up to a factor e^2 beyond the ends that z lies on."""
    return float(np.nanmin(case.values(z + np.linspace(0, 2, 21)[:, None] * ends)))


def _around(case: Case, z: np.ndarray) -> float:
    """The lowest value close to z: at random points of all sizes, and on the way to the optimum."""
    rng, (low, high) = np.random.default_rng(0), case.problem.space.box()
    directions = rng.standard_normal((3000, len(z)))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    far = AROUND * 10 ** rng.uniform(-4, 0, (3000, 1))
    way = case.where - z
    reach = min(1.0, AROUND / max(float(np.linalg.norm(way)), 1e-12))
    steps = np.vstack([directions * far, np.linspace(0, reach, 101)[:, None] * way])
    inside = np.clip(z + steps, np.minimum(low, z), np.maximum(high, z))
    return float(np.nanmin(case.values(inside)))


def steps(labels: list[str], sentence: str) -> np.ndarray:
    """The step in z ``(n,)`` that a sentence names.

    >>> steps(["ln R", "ln Q", "x"], "R x 10 with x +0.5 changes nothing: ...").round(3).tolist()
    [2.303, 0.0, 0.5]
    """
    told = sentence.split(" change", maxsplit=1)[0]
    step = np.zeros(len(labels))
    for i, label in enumerate(labels):
        if label.startswith("ln "):
            found = re.search(rf"(?<!\w){re.escape(label[3:])} x ([\d.e+-]+)", told)
            step[i] = np.log(float(found[1])) if found else 0.0
        else:
            found = re.search(rf"(?<!\w){re.escape(label)} ([+-][\d.e+-]+)", told)
            step[i] = float(found[1]) if found else 0.0
    return step


def _untrue(case: Case, z: np.ndarray, value: float, sentence: str) -> bool:
    step = steps(case.problem.space.coordinates, sentence)
    if not step.any():
        raise ValueError(f"{case.name}: no step is found in {sentence!r}")
    low, high = case.problem.space.box()
    limited = case.problem.space.limited()
    moved = np.where(limited, np.clip(z + step, low, high), z + step)
    changed = abs(float(case.values(moved[None])[0]) - value)
    # Half as much again: the sentence gives the step to three digits.
    felt = max(case.felt, 1e-2 * abs(value) if case.count is None else 0.0)
    return bool(changed > 1.5 * felt)


def is_threshold_refusal(case: Case, solver: str) -> bool:
    """Whether a solver has to refuse a case: gradients where there is a threshold."""
    declared = bool(case.problem.space.thresholds().any())
    return declared and solver not in ("nelder-mead", "alternating")


TRUSTED = tuple(status.value for status in Status if status.trusted)
"""The trusted statuses, in words."""
