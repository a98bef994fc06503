"""What hypothesis draws from: models, covariances and records that a filter has to bear."""

import numpy as np
from hypothesis import strategies as st

from tests.oracles import Model


def seeds():
    """A generator of random numbers; hypothesis shrinks and repeats its seed."""
    return st.integers(0, 2**32 - 1).map(np.random.default_rng)


def covariance(rng, n, rank):
    """A positive semi-definite matrix of the given rank, of order 1."""
    root = rng.normal(size=(n, rank))
    return root @ root.T


@st.composite
def stable_models(draw, n=3, m=2, N=12, *, missing=True):
    """A stable model with n states and m measurements, and N samples, some of them missing.

    P0 and W have any rank, zero included; R is well conditioned, for the textbook's solve has to
    keep ten digits. The sizes are fixed: they are shapes, and each new shape is a compilation.
    """
    rng = draw(seeds())
    F = rng.normal(size=(n, n))
    F *= draw(st.floats(0.0, 0.99)) / np.abs(np.linalg.eigvals(F)).max()
    R = covariance(rng, m, m) + np.eye(m)
    W, P0 = (covariance(rng, n, draw(st.integers(0, n))) for _ in range(2))
    z = rng.normal(size=(N, m))
    if missing:
        hole = draw(st.lists(st.booleans(), min_size=N * m, max_size=N * m))
        z[np.reshape(hole, (N, m))] = np.nan
    scale = 10.0 ** draw(st.integers(-6, 6))  # covariances in whatever unit
    root = np.sqrt(scale)
    H = rng.normal(size=(m, n))
    model = Model(F, scale * W, H, scale * R, scale * P0, root * rng.normal(size=n))
    return model, root * z


def noise_ratios():
    """Q/R of an inertial filter, over everything that a tuner may try."""
    return st.floats(-6, 7).map(lambda exponent: 10.0**exponent)
