"""Which part of the data is held out, and the problems that this makes."""

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import jax
import numpy as np

from filters import Lanes
from tuner.problem.problem import Problem
from tuner.run.sample_terms import sample_terms

HeldOutBy: TypeAlias = Literal["time", "recording", "leave-one-out", "none"]
"""The held-out data: the last part of the time, some recordings, each in turn, or nothing."""
SHARE = 0.7
"""Share of the samples, or of the recordings, that a second fit is tuned on; the rest judges it."""
FEW = 3
"""From so many recordings on, whole recordings are held out instead of the end of each."""
LEAST = 50
"""Of fewer samples nothing is held out unless it is asked for."""


@dataclass(frozen=True, eq=False)
class Parting:
    """The held-out data, in one part or, of recordings that are left out in turn, in several.

    Attributes:
        way: what is held out.
        judges: what each part holds, over samples ``(N, 1)`` or recordings ``(1, k)``, True there.
        tuned: the problem without each part: the filter runs over all, and the truth is NaN there.
        alone: the problem on each part by itself: what could be had there.
    """

    way: HeldOutBy
    judges: tuple[np.ndarray, ...]
    tuned: tuple[Problem, ...]
    alone: tuple[Problem, ...]

    @property
    def words(self) -> str:
        """The judging data, in words."""
        if self.way == "leave-one-out":
            return f"each of {len(self.judges)} recordings in turn"
        count = int(self.judges[0].sum())
        if self.way == "recording":
            return f"{count} recording{'' if count == 1 else 's'}"
        return f"the last {count} samples"


def parting(problem: Problem, way: HeldOutBy | None) -> Parting | None:
    """The held-out data; None for nothing.

    Args:
        problem: on all of the data.
        way: as it is asked for; None: whole recordings from three on, otherwise the last part of
            the time, and nothing where there is too little.

    Raises:
        ValueError: for one recording where several are needed, and a part without samples.
    """
    lanes = _lanes(problem)
    few = lanes < FEW and len(_rows(problem)) < LEAST
    if way == "none" or (way is None and few):
        return None
    chosen: HeldOutBy = way or ("recording" if lanes >= FEW else "time")
    if chosen != "time" and lanes < 2:
        raise ValueError(
            f"held_out={chosen} takes several recordings, and there is one alone; give more, or "
            "hold out its end with held_out=time"
        )
    judges = _judges(problem, chosen)
    _check_samples(problem, chosen, judges)
    name = problem.name
    if chosen == "leave-one-out":
        without = [f"{name}_without_{i + 1}" for i in range(lanes)]
        alone = [replace(_one(problem, i), name=f"{name}_alone_{i + 1}") for i in range(lanes)]
    else:
        without = [f"{name}_part"]
        alone = [replace(only(problem, judges[0]), name=f"{name}_alone")]
    tuned = [replace(only(problem, ~j), name=n) for n, j in zip(without, judges, strict=True)]
    return Parting(chosen, judges, tuple(tuned), tuple(alone))


def _lanes(problem: Problem) -> int:
    return problem.filter.count if isinstance(problem.filter, Lanes) else 1


def _rows(problem: Problem) -> np.ndarray:
    """The samples in which something has a truth."""
    truth = np.asarray(problem.data.truth)
    return np.flatnonzero(~np.isnan(truth).all(axis=tuple(range(1, truth.ndim))))


def _judges(problem: Problem, way: HeldOutBy) -> tuple[np.ndarray, ...]:
    lanes = np.arange(_lanes(problem))[None]
    if way == "leave-one-out":
        return tuple(lanes == i for i in lanes[0])
    if way == "recording":
        return (lanes >= min(round(SHARE * lanes.size), lanes.size - 1),)
    rows, samples = _rows(problem), np.arange(len(np.asarray(problem.data.truth)))[:, None]
    last = rows[int(SHARE * len(rows))] if len(rows) else -1
    return (samples > last,)


def _check_samples(problem: Problem, way: HeldOutBy, judges: tuple[np.ndarray, ...]) -> None:
    """Refuse a part, or a rest, in which nothing counts."""
    found = sample_terms(problem, problem.parameters(problem.space.start()))
    if found is None:
        return
    for i, judge in enumerate(judges):
        for part, where in ((judge, "is held out"), (~judge, "is left to tune on")):
            if found.only(part).counts.any():
                continue
            of = f"recording {i + 1}" if way == "leave-one-out" else "the part"
            what = f"{of} that {where}" if part is judge else f"what {where}"
            raise ValueError(
                f"{what} has no samples that count; hold out otherwise (held_out=time, recording "
                "or leave-one-out), or nothing (held_out=none)"
            )


def only(problem: Problem, mask: np.ndarray) -> Problem:
    """The problem with the samples that count; the others have a truth of NaN."""
    truth = np.asarray(problem.data.truth)
    mask = mask if isinstance(problem.filter, Lanes) else mask[:, 0]
    wide = mask.reshape(mask.shape + (1,) * (truth.ndim - mask.ndim))
    data = problem.data._replace(truth=np.where(wide, truth, np.nan))
    return replace(problem, data=data)


def _one(problem: Problem, lane: int) -> Problem:
    """The problem on one of several recordings."""
    assert isinstance(problem.filter, Lanes)
    data = jax.tree.map(lambda leaf: np.asarray(leaf)[:, lane : lane + 1], problem.data)
    return replace(problem, filter=Lanes(problem.filter.filter, 1), data=data)
