"""Other implementations of the same filter; each imports its library only when it is called."""

from collections.abc import Callable
from typing import TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.loops import matrix_loop
from benchmarks.timing import Call
from benchmarks.work import DT

Prepare: TypeAlias = Callable[[np.ndarray, float, float], Call]
"""Makes a call that gives the output, ``(N,)``, from the signal, R and Q."""

F = np.array([[1.0, DT], [0.0, 1.0]])
H = np.array([[1.0, 0.0]])


def numpy_loop(z: np.ndarray, R: float, Q: float) -> Call:
    """NumPy matrices and a loop."""
    return lambda: matrix_loop(z, R, Q, DT)


def filterpy(z: np.ndarray, R: float, Q: float) -> Call:
    """FilterPy's KalmanFilter, one predict and one update per sample."""
    from filterpy.kalman import KalmanFilter

    def call() -> np.ndarray:
        kalman = KalmanFilter(dim_x=2, dim_z=1)
        kalman.F, kalman.H, kalman.P = F, H, np.ones((2, 2))
        kalman.Q, kalman.R = Q * DT**2 * np.eye(2), np.array([[R]])
        out = np.empty(len(z))
        for k, sample in enumerate(z):
            kalman.predict()
            kalman.update(sample)
            out[k] = kalman.x.flat[0]
        return out

    return call


def statsmodels(z: np.ndarray, R: float, Q: float) -> Call:
    """statsmodels' filter in Cython; with its default tolerance it would freeze the gains."""
    return _statsmodels(z, R, Q, tolerance=0.0)


def statsmodels_default(z: np.ndarray, R: float, Q: float) -> Call:
    """The same as it comes."""
    return _statsmodels(z, R, Q, tolerance=None)


def dynamax(z: np.ndarray, R: float, Q: float) -> Call:
    """Dynamax's filter, compiled by JAX like ours."""
    from dynamax.linear_gaussian_ssm import LinearGaussianSSM, lgssm_filter

    W = Q * DT**2 * np.eye(2)
    model = LinearGaussianSSM(2, 1)
    params, _ = model.initialize(
        jax.random.key(0),
        initial_mean=jnp.zeros(2),
        initial_covariance=jnp.asarray(F @ np.ones((2, 2)) @ F.T + W),
        dynamics_weights=jnp.asarray(F),
        dynamics_covariance=jnp.asarray(W),
        emission_weights=jnp.asarray(H),
        emission_covariance=jnp.array([[R]]),
    )
    filtered = jax.jit(lambda params, z: lgssm_filter(params, z).filtered_means[:, 0])
    data = jnp.asarray(z)[:, None]
    return lambda: filtered(params, data)


PEERS: dict[str, tuple[Prepare, float | None]] = {
    "statsmodels, tolerance 0": (statsmodels, 75.0),
    "dynamax": (dynamax, 75.0),
    "filterpy": (filterpy, 1000.0),
    "NumPy loop": (numpy_loop, None),
}
"""By name: how to prepare it, and how many times as long it should take as ours."""


def _statsmodels(z: np.ndarray, R: float, Q: float, tolerance: float | None) -> Call:
    from statsmodels.tsa.statespace.kalman_filter import KalmanFilter

    W = Q * DT**2 * np.eye(2)
    kalman = KalmanFilter(k_endog=1, k_states=2)
    if tolerance is not None:
        kalman.tolerance = tolerance
    kalman.bind(np.ascontiguousarray(z))
    kalman["design"], kalman["transition"], kalman["selection"] = H, F, np.eye(2)
    kalman["obs_cov"], kalman["state_cov"] = np.array([[R]]), W
    kalman.initialize_known(np.zeros(2), F @ np.ones((2, 2)) @ F.T + W)
    return lambda: kalman.filter().filtered_state[0]
