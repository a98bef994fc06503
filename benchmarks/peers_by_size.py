"""Gradients of likelihoods in other libraries: ``python -m benchmarks.peers_by_size``.

The filters of :mod:`benchmarks.gradients` in all variances, by the gradient each library has: JAX's
through dynamax and cuthbert, and differences of likelihoods in statsmodels, which has no other.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.gradients import by_c, gradient_call, oscillators
from benchmarks.table import Row, duration
from benchmarks.timing import Call, interleave
from tuner.compiler import NoCodeError

PART = "Gradients of likelihoods in other libraries"
SIZES = ((4, 2, 20.0), (9, 3, 20.0), (15, 3, 7.0), (24, 6, 7.0))
"""States, measurements, and how many times as long as ours a library should take."""
ROUNDS, OWN_ROUNDS = 3, 25
STEP = 1e-6
AGREED = 1e-4  # of differences


def rows() -> list[Row]:
    """The shortest time of each library over ours; its gradient is compared first."""
    return [row for size in SIZES for row in _of(*size)]


def dynamax(n: int, m: int) -> Call:
    """Its filter, differentiated backwards by JAX."""
    from dynamax.linear_gaussian_ssm import LinearGaussianSSM, lgssm_filter

    F, H, z = map(jnp.asarray, oscillators(n, m))
    model = LinearGaussianSSM(n, m)

    def likelihood(at: Any) -> Any:
        every = jnp.exp(at)
        W = jnp.diag(every[:n])
        params, _ = model.initialize(
            jax.random.key(0),
            initial_mean=jnp.zeros(n),
            initial_covariance=F @ F.T + W,
            dynamics_weights=F,
            dynamics_covariance=W,
            emission_weights=H,
            emission_covariance=jnp.diag(every[n:]),
        )
        return -lgssm_filter(params, z).marginal_loglik / z.size

    both = jax.jit(jax.value_and_grad(likelihood))
    return lambda: both(jnp.zeros(n + m))


def cuthbert(n: int, m: int) -> Call:
    """Its square-root filter in sequence, differentiated backwards by JAX."""
    from cuthbert import filter as run
    from cuthbert.gaussian import kalman

    F, H, z = map(jnp.asarray, oscillators(n, m))

    def likelihood(at: Any) -> Any:
        root = jnp.exp(at / 2)
        made = kalman.build_filter(
            jnp.zeros(n),
            jnp.eye(n),
            lambda _: (F, jnp.zeros(n), jnp.diag(root[:n])),
            lambda k: (H, jnp.zeros(m), jnp.diag(root[n:]), z[k]),
        )
        states = run(made, jnp.arange(len(z)), made.init_prepare())
        return -states.log_normalizing_constant[-1] / z.size

    both = jax.jit(jax.value_and_grad(likelihood))
    return lambda: both(jnp.zeros(n + m))


def statsmodels(n: int, m: int) -> Call:
    """Forward differences of its filter in Cython, which takes measurements one by one."""
    from statsmodels.tsa.statespace.kalman_filter import KalmanFilter

    F, H, z = oscillators(n, m)
    kalman = KalmanFilter(k_endog=m, k_states=n)
    kalman.tolerance = 0.0
    kalman.bind(np.ascontiguousarray(z))
    kalman.set_filter_method(filter_univariate=True)
    kalman["design"], kalman["transition"], kalman["selection"] = H, F, np.eye(n)

    def likelihood(at: np.ndarray) -> float:
        every = np.exp(at)
        W = np.diag(every[:n])
        kalman["obs_cov"], kalman["state_cov"] = np.diag(every[n:]), W
        kalman.initialize_known(np.zeros(n), F @ F.T + W)
        return float(-kalman.loglike() / z.size)

    def both() -> tuple[float, np.ndarray]:
        value = likelihood(np.zeros(n + m))
        ahead = [likelihood(STEP * unit) for unit in np.eye(n + m)]
        return value, (np.array(ahead) - value) / STEP

    return both


LIBRARIES: dict[str, Callable[[int, int], Call]] = {
    "dynamax": dynamax,
    "cuthbert": cuthbert,
    "statsmodels, differences": statsmodels,
}


def _ours(n: int, m: int) -> Call:
    """By compiled C, or without a compiler by XLA."""
    try:
        return by_c(n, m)["gradient"]
    except NoCodeError:
        return gradient_call(n, m)


def _of(n: int, m: int, target: float) -> list[Row]:
    ours = _ours(n, m)
    calls: dict[str, Call] = {}
    found = []
    for name, made in LIBRARIES.items():
        what = f"{n} states, {n + m} parameters: {name}"
        try:
            calls[name] = made(n, m)
        except ImportError as error:
            note = f"not installed ({error.name})"
            found.append(Row(PART, what, target=target, sense="least", note=note))
            continue
        _check(what, ours(), calls[name]())
    own = interleave({"ours": ours}, OWN_ROUNDS).best("ours")
    times = interleave(calls, ROUNDS)
    for name in calls:
        ratio = times.best(name) / own
        found.append(
            Row(
                part=PART,
                what=f"{n} states, {n + m} parameters: {name}",
                ours=duration(own),
                against=duration(times.best(name)),
                figure=ratio,
                best=ratio,
                target=target,
                sense="least",
                why="its time is that of the products of its matrices, as is ours",
            )
        )
    return found


def _check(what: str, ours: Any, theirs: Any) -> None:
    apart = np.abs(np.asarray(theirs[1]) - np.asarray(ours[1])).max()
    if not apart <= AGREED * np.abs(np.asarray(ours[1])).max():
        raise AssertionError(f"{what}: its gradient differs by {apart:.2g}")


if __name__ == "__main__":
    from rich.console import Console

    from benchmarks.table import markdown, show

    measured = rows()
    show(measured, Console(width=150))
    print(markdown(measured))
