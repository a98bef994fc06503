"""Trials in a batch, the tuning problems on them, and the filters' errors."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple, get_args

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter, Batched, ImuSample, Lanes, assembled, run
from objectives import AttitudeRmse, Data, Records, attitude_error
from objectives.attitude import Part
from studies.broad.contestants import LEVEL, SPACES, Build, filter_of, group, takes_field
from studies.broad.trials import Trial
from tuner.data.source import Source
from tuner.names import counted
from tuner.problem.problem import Problem


@dataclass(frozen=True)
class Error:
    """Root mean square error of one trial's attitude, deg.

    Attributes:
        part: which error.
    """

    part: Part = "inclination"

    def __call__(self, outputs: Any, truth: Array) -> Array:
        """Of quaternions, or of outputs that have some; in blocks or not."""
        q = getattr(outputs, "att", outputs)
        return AttitudeRmse(self.part)(q.reshape(-1, 4), truth.reshape(-1, 4))


class Outcome(NamedTuple):
    """Errors of a filter on k trials, deg.

    Attributes:
        errors: root mean square errors by trial, ``(k,)``: the inclination's, and for a filter with
            a field the total and the heading's.
        last: inclination error of the last trial in time, ``(N,)``; NaN where no truth is known.
    """

    errors: dict[Part, np.ndarray]
    last: np.ndarray

    @property
    def inclination(self) -> np.ndarray:
        """The errors of inclination by trial, ``(k,)``."""
        return self.errors["inclination"]


@dataclass(frozen=True, eq=False)
class Contest:
    """Trials of one sample rate; filters' data and results are computed once.

    Attributes:
        trials: at least one.
        whole: whether they are complete, so that published errors are those of the same samples.
        samples: they are filled up to so many at least: contests of one length share a compilation.
    """

    trials: tuple[Trial, ...]
    whole: bool = True
    samples: int = 0
    _outcomes: dict[Any, Outcome] = field(default_factory=dict, init=False, repr=False)

    def of(self, trials: Sequence[Trial], samples: int = 0) -> "Contest":
        """The contest on some of the trials, filled up to so many samples at least."""
        return Contest(tuple(trials), self.whole, samples)

    @property
    def rate_hz(self) -> float:
        """The common sample rate."""
        return self.trials[0].rate_hz

    def data(self, name: str) -> Data:
        """The trials as data of a filter."""
        if takes_field(name):
            return self._with_field
        if name.startswith("room"):
            return self._blocks
        return self._groups if group(name, self.rate_hz) > 1 else self._samples

    def problem(self, title: str, name: str) -> Problem:
        """A filter tuned on all trials: by inclination, or with a field by the total error."""
        filter, field = filter_of(name, self.rate_hz), takes_field(name)
        return Problem(
            name=title,
            space=SPACES[name],
            filter=Batched(filter) if field else Lanes(filter, len(self.trials)),
            build=Build(filter, self._starts(name)) if field else None,
            objective=Records(Error("total" if field else "inclination")),
            data=self.data(name),
            source=self.source,
        )

    @cached_property
    def source(self) -> Source:
        """The files."""
        parts = [trial.source for trial in self.trials]
        return Source.joined(f"{counted(len(parts), 'trial')} of BROAD", parts)

    def judged(self, name: str, values: dict[str, Array]) -> Outcome:
        """A filter's errors with parameters that all trials share."""
        return self.judged_each(name, [values] * len(self.trials))

    def judged_each(self, name: str, values: Sequence[dict[str, Array]]) -> Outcome:
        """A filter's errors with parameters for each trial, in one time loop."""
        filter = filter_of(name, self.rate_hz)
        starts = [np.array(q) for q in self._starts(name)]
        rows = [assembled(filter, v | {"q0": q}) for v, q in zip(values, starts, strict=True)]
        # Arrays of NumPy are float64 whatever they were made of, so all share one compilation.
        params = jax.tree.map(lambda *leaves: np.stack(leaves, dtype=float), *rows)
        parts: tuple[Part, ...] = get_args(Part) if takes_field(name) else ("inclination",)
        key = filter, parts, *(leaf.tobytes() for leaf in jax.tree.leaves(params))
        if key not in self._outcomes:
            errors, last = _judged(filter, parts, params, self.data(name))
            found = {part: np.asarray(each) for part, each in zip(parts, errors, strict=True)}
            self._outcomes[key] = Outcome(found, np.asarray(last))
        return self._outcomes[key]

    def _starts(self, name: str) -> tuple[tuple[float, ...], ...]:
        """A filter's initial attitude on each trial: by gravity and field, otherwise level."""
        starts = [trial.start if takes_field(name) else None for trial in self.trials]
        return tuple(LEVEL if q is None else tuple(q.tolist()) for q in starts)

    @cached_property
    def _blocks(self) -> Data:
        return side_by_side("room", self.trials, self.samples)

    @cached_property
    def _groups(self) -> Data:
        return side_by_side("gravity", self.trials, self.samples)

    @cached_property
    def _samples(self) -> Data:
        return side_by_side("mahony", self.trials, self.samples)

    @cached_property
    def _with_field(self) -> Data:
        plain = self._samples
        fields = [trial.field for trial in self.trials if trial.field is not None]
        seen = _cut(fields, len(plain.truth), 1, "edge")[:, :, 0]
        return Data(plain.inputs._replace(mag=seen), plain.truth)


def side_by_side(name: str, trials: Sequence[Trial], samples: int = 0) -> Data:
    """Trials as data of a filter, up to the last sample that counts in any, or to ``samples``.

    Shorter ones are filled up with their last sample at rest.
    For the room filter samples are in blocks, for the gravity filters averaged in groups, whose
    truth is that of their last sample.
    """
    length = group(name, trials[0].rate_hz)
    count = -(-max(samples, *(end(trial) for trial in trials)) // length)
    acceleration = _cut([trial.acceleration for trial in trials], count, length, "edge")
    rate = _cut([trial.rate for trial in trials], count, length, "zero")
    truth = _cut([trial.truth for trial in trials], count, length, "nan")
    if name.startswith("room"):
        return Data(ImuSample(acceleration, rate), truth)
    means = ImuSample(acceleration.mean(axis=2), rate.mean(axis=2))
    return Data(means, truth[:, :, -1])


def end(trial: Trial) -> int:
    """Number of samples up to the last that counts."""
    return int(np.flatnonzero(~np.isnan(trial.truth).any(axis=1))[-1]) + 1


def _cut(
    parts: list[np.ndarray], count: int, length: int, fill: Literal["edge", "zero", "nan"]
) -> Array:
    """Records ``(N, d)`` as ``(count, k, length, d)``."""
    whole = []
    for part in parts:
        last = {"edge": part[-1], "zero": 0 * part[-1], "nan": np.nan * part[-1]}[fill]
        rest = np.broadcast_to(last, (max(count * length - len(part), 0), part.shape[1]))
        filled = np.concatenate([part[: count * length], rest])
        whole.append(filled.reshape(count, length, -1))
    return jnp.asarray(np.stack(whole, axis=1))


# Run a few times only: optimised less it takes a third longer, and half the time to compile.
@jax.jit(static_argnums=(0, 1), compiler_options={"xla_backend_optimization_level": 1})
def _judged(
    filter: AnyFilter, parts: tuple[Part, ...], params: Any, data: Data
) -> tuple[list[Array], Array]:
    """The errors by part, each ``(k,)``, and the last trial's inclination error in time."""
    found = run(Batched(filter), params, data.inputs)[1]
    q = getattr(found, "att", found)
    end, truth = q[:, -1].reshape(-1, 4), data.truth[:, -1].reshape(-1, 4)
    angle = jnp.degrees(jax.vmap(attitude_error)(end, truth).inclination)
    last = jnp.where(jnp.isnan(truth).any(axis=1), jnp.nan, angle)
    return [Records(Error(part)).each(q, data.truth) for part in parts], last
