"""A design expressed for the model as it was given: gains, poles, covariance."""

from collections.abc import Iterator
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from filters import GainedSample, StoredGains
from objectives import LinearSystem, tracker_gains
from tuner.export.tuned import Quantity
from tuner.observers.gains import Observer
from tuner.problem.exported import Exported, Trial, Weighed
from tuner.problem.steady_form import steady_form

SHORTEST, LONGEST = 100, 2000
"""Limits of the samples of an observer's test, which takes eight of its time constants."""
LARGEST = 1e12
"""Largest simulated measurement of an unstable model."""


@dataclass(frozen=True, eq=False)
class Designed:
    """A system, and the part of it that is designed for.

    Attributes:
        full: the system.
        error: weights of the error that counts, ``(n,)``.
        part: without undriven modes, where the design is for the steady state.
        T: from the part's states to the system's, ``(n, r)``.
        unit: of the error that counts.
        seed: of the simulated noise.
    """

    full: LinearSystem
    error: np.ndarray
    part: LinearSystem
    T: np.ndarray
    unit: str
    seed: int

    def gain(self, observer: Observer) -> np.ndarray:
        """L for the system, ``(n, m)``."""
        return np.asarray(self.T @ np.asarray(observer.L))

    def covariance(self, observer: Observer) -> np.ndarray:
        """Steady covariance of the error, ``(n, n)``; zero along undriven modes."""
        P = self.part.covariance(np.asarray(observer.L))
        return np.asarray(self.T @ P @ self.T.T)

    def sample_gain(self, observer: Observer) -> np.ndarray | None:
        """K with L = A K, ``(n, m)``; None where there is none."""
        if not self.full.discrete or not np.linalg.cond(self.full.A) < 1e12:
            return None
        return np.linalg.solve(self.full.A, self.gain(observer))

    def tracker(self, K: np.ndarray) -> dict[str, float]:
        """A gain on a sample as alpha, beta and gamma, where the model is a tracker's."""
        full = self.full
        return {} if full.dt is None else tracker_gains(full.A, full.C, K, full.dt)

    @property
    def exported(self) -> Exported:
        """Model, gain, poles and covariance; a discrete observer is run on simulated samples."""
        dt = self.full.dt or 0.0
        return Exported(
            "Observer",
            self.full.states,
            dt,
            self._quantities,
            runs=self._runs,
            machine=self._machine,
        )

    def _quantities(self, observer: Observer) -> tuple[Quantity, ...]:
        return (*self._gains(observer), *self._noise(observer))

    def _gains(self, observer: Observer) -> Iterator[Quantity]:
        full, L = self.full, self.gain(observer)
        poles = full.poles(L)
        per = "" if full.discrete else "1/s"
        yield Quantity("A", full.A, per, "the model's dynamics")
        yield Quantity("C", full.C, "", "the model's measurements")
        yield Quantity("L", L, "", "gain of the observer x' = A x + L (y - C x)")
        yield Quantity("poles_re", poles.real.copy(), per, "real parts of the poles of A - L C")
        yield Quantity("poles_im", poles.imag.copy(), per, "their imaginary parts")
        K = self.sample_gain(observer)
        if K is not None:
            yield Quantity("K", K, "", "gain on a sample: x+ = x + K (y - C x), L = A K")
            for name, value in self.tracker(K).items():
                yield Quantity(name, np.array(value), "", "the same gain, as trackers name it")

    def _noise(self, observer: Observer) -> Iterator[Quantity]:
        full, P = self.full, self.covariance(observer)
        variance = np.array(self.error @ P @ self.error)
        density = "density of the process noise; discrete: covariance a sample"
        yield Quantity("W", full.W, "", density)
        yield Quantity("V", full.V, "", "the same of the measurement noise")
        yield Quantity("error", self.error, "", "weights of the error that counts")
        yield Quantity("P", P, "", "steady covariance of the error; discrete: before a measurement")
        yield Quantity("variance", variance, self.squared, "of the error that counts")

    @property
    def squared(self) -> str:
        """The unit of the error's variance."""
        return f"({self.unit})^2" if self.unit else ""

    def _runs(self, observer: Observer) -> dict[str, Trial]:
        K = self.sample_gain(observer)
        if K is None or self.full.dt is None:
            return {}
        span = 8 / self.part.decay(np.asarray(observer.L)) / self.full.dt
        z = self._simulated(int(np.clip(span, SHORTEST, LONGEST)))
        filter = Weighed(StoredGains(), tuple(self.error.tolist()))
        samples = GainedSample(jnp.asarray(z), jnp.broadcast_to(K, (len(z), *K.shape)))
        return {"fixed gain": Trial(filter, self.full.filter_model(self.full.W), samples)}

    def _machine(self, observer: Observer) -> dict[str, Trial]:
        """The test of a discrete observer, with all its states."""
        K = self.sample_gain(observer)
        if K is None or self.full.dt is None:
            return {}
        return {"fixed gain": steady_form(self.full, K, self.full.states)}

    def _simulated(self, count: int) -> np.ndarray:
        """Simulated measurements of the model, from zero on, ``(N, m)``."""
        full, draw = self.full, np.random.default_rng(self.seed)
        w, v = (
            draw.standard_normal((count, len(noise))) @ _root(noise).T for noise in (full.W, full.V)
        )
        x, z = np.zeros(len(full.A)), []
        for k in range(count):
            z.append(full.C @ x + v[k])
            x = full.A @ x + w[k]
            if not np.abs(x).max() < LARGEST:
                break
        return np.array(z)


def _root(covariance: np.ndarray) -> np.ndarray:
    """A root R with R R' = the covariance, which may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
