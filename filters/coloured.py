"""First-order coloured measurement noise: each error resembles the one before."""

from functools import cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.added_parameters import WithParameters, require_channel, with_parameters
from filters.declared import Param
from filters.diffuse import AnyEstimate, advance, begin, take
from filters.linear import LinearForm, LinearModel, Transition


def coloured(model: LinearModel, tau: Array, dt: Array) -> LinearModel:
    """A linear model whose measurement noise is a first-order Markov process, as more states.

    Noise of the covariance R and the time constant tau is v' = phi v + e with phi = exp(-dt / tau)
    and cov e = (1 - phi^2) R: m states more, which are measured with the others, and nothing is
    left of R. As tau goes to 0 it is white again. Source: Gelb, Applied Optimal Estimation, 1974,
    4.5; Bryson and Johansen, IEEE Transactions on Automatic Control 10, 1965.

    Args:
        model: with n states and m measurements.
        tau: time constant, s, ``()`` or ``(m,)``.
        dt: the sample time of the model's transition, s.

    Returns:
        A model of n + m states, those of the noise last, stationary at the start.

    >>> from filters import transitions
    >>> one = jnp.ones((1, 1))
    >>> walk = LinearModel(Transition(one, one, one), one, jnp.array([4.0]), one, jnp.zeros(1))
    >>> noisy = coloured(walk, jnp.array(0.5), jnp.array(0.5))
    >>> noisy.transition.F.round(3).tolist(), noisy.P0.tolist()
    ([[1.0, 0.0], [0.0, 0.368]], [[1.0, 0.0], [0.0, 4.0]])
    """
    move, R = model.transition, jnp.diag(model.R) if model.R.ndim == 1 else model.R
    m = len(R)
    phi = jnp.broadcast_to(jnp.exp(-dt / tau), (m,))
    each = jnp.eye(m, dtype=R.dtype)
    grown = Transition(
        _blocks(move.F, jnp.diag(phi)),
        _blocks(move.G, each),
        _blocks(move.Q, R * (1 - jnp.outer(phi, phi))),
        None if move.B is None else jnp.concatenate([move.B, jnp.zeros((m, move.B.shape[1]))]),
    )
    x0 = jnp.concatenate([model.x0, jnp.zeros((m, *model.x0.shape[1:]), model.x0.dtype)])
    H = jnp.concatenate([model.H, each], axis=1)
    return LinearModel(grown, H, jnp.zeros(m, R.dtype), _blocks(model.P0, R), x0)


class ColouredState(NamedTuple):
    """Estimate of states and noises, and whether anything was measured yet, ``()``."""

    estimate: AnyEstimate
    begun: Array


class _Coloured(WithParameters):
    """A filter whose measurement noise is a first-order Markov process of the variance R.

    It is the Kalman filter of the same model with the noise among its states (:func:`coloured`),
    and begins as that filter does, with nothing known of its states. A second measurement at
    exactly the time of another adds nothing, and is taken as missing.
    """

    def init(self, params: Any) -> ColouredState:
        """The start, at which only the variance of the noise is known."""
        model = self._model(params)
        n = len(model.x0) - len(model.H)
        return ColouredState(begin(model.x0, model.P0, range(n)), jnp.zeros((), bool))

    def step(self, params: Any, state: ColouredState, inputs: Any) -> tuple[ColouredState, Any]:
        """Move on, and take the measurements one after another."""
        model = self._model(params)
        move, n = model.transition, len(model.x0) - len(model.H)
        parts = [v for name, v in inputs._asdict().items() if v is not None and name != "sigma"]
        sigma = jnp.ones_like(parts[0]) if inputs.sigma is None else inputs.sigma
        fresh = (jnp.asarray(self.dt) > 0) | ~state.begun  # type: ignore[attr-defined]
        z = jnp.where(fresh & (sigma > 0), jnp.stack(parts), jnp.nan)
        noise = move.G @ move.Q @ move.G.T
        ahead = advance(state.estimate, move.F, noise)
        # Before the first measurement nothing moves: the filter inside does not either.
        estimate: Any = jax.tree.map(
            lambda moved, still: jnp.where(state.begun, moved, still), ahead, state.estimate
        )
        innovations = []
        for i in range(len(z)):
            row = jnp.concatenate([model.H[i, :n], model.H[i, n:] * jnp.where(sigma > 0, sigma, 1)])
            estimate, innovation = take(estimate, row, model.R[i], z[i])
            innovations.append((innovation.value, innovation.variance))
        begun = state.begun | ~jnp.isnan(z).all()
        value, variance = (jnp.stack(part) for part in zip(*innovations, strict=True))
        return ColouredState(estimate, begun), self._outputs(estimate.x[:n], value, variance)

    def _model(self, params: Any) -> LinearModel:
        form: LinearForm = self.inner().linear(self.within(params))
        n = form.H.shape[1]
        nothing = jnp.zeros((n, n), form.R.dtype)
        plain = LinearModel(*form, nothing, nothing[0])
        return coloured(plain, params.tau, jnp.asarray(self.dt))  # type: ignore[attr-defined]

    def _outputs(self, x: Array, value: Array, variance: Array) -> Any:
        """As the filter inside has them: one after another, of each axis."""
        kind = self.base.outputs
        known = len(kind._fields) - 2
        rows = x.reshape(-1, known).T
        if "axes" not in self._fields():
            rows = rows[:, 0]
        return kind(*rows, innovation=value, variance=variance)


@cache
def coloured_noise(base: type[Any], step: float) -> type[Any]:
    """A filter with coloured measurement noise, as a class with one more number, ``tau``.

    Args:
        base: class of a filter that is a linear model of its measurements alone.
        step: sample time of the data, s: tau is searched from a tenth of it to ten thousand.

    Raises:
        ValueError: for another filter.

    >>> from filters import LevelSample, LocalLevel, run
    >>> slower = coloured_noise(LocalLevel, 1.0)
    >>> params = slower.params(jnp.array(0.0), jnp.array(1.0), tau=jnp.array(1e9))
    >>> run(slower(dt=1.0), params, LevelSample(jnp.array([3.0, 4.0])))[1].level.round(6).tolist()
    [3.0, 3.5]
    """
    require_channel(base, "sigma", "its noise cannot be coloured")
    tau = Param(
        "s",
        "time constant of the measurement noise, a first-order Markov process of the variance R",
        typical=step,
        low=step / 10,
        high=1e4 * step,
        smaller="the noise is white",
        larger="an error stays for long, and samples in a row say little more than one",
    )
    return with_parameters(base, _Coloured, {"tau": (Array, tau)}, (coloured_noise, (step,)))


def _blocks(one: Array, other: Array) -> Array:
    """A matrix of two blocks along its diagonal."""
    above = jnp.concatenate([one, jnp.zeros((one.shape[0], other.shape[1]), one.dtype)], axis=1)
    below = jnp.concatenate([jnp.zeros((other.shape[0], one.shape[1]), one.dtype), other], axis=1)
    return jnp.concatenate([above, below])
