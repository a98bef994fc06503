"""The linear models that filters say they are the Kalman filters of."""

import jax.numpy as jnp
import numpy as np
import pytest

from filters import (
    ConstantAcceleration,
    ConstantVelocity,
    LevelSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    PositionSample,
    Sample,
    Vertical,
    VerticalSample,
    run,
)
from filters.declared import assembled

N, DT = 120, 0.5


def samples():
    draw = np.random.default_rng(1)
    track = np.cumsum(np.cumsum(draw.normal(size=(N, 2)), axis=0), axis=0)
    track[draw.random((N, 2)) < 0.2] = np.nan
    acc, baro = draw.normal(size=N), 100 + draw.normal(size=N)
    acc[draw.random(N) < 0.2], baro[1:][draw.random(N - 1) < 0.5] = np.nan, np.nan
    return track, acc, baro


TRACK, ACC, BARO = samples()
NOISE = {"q": 0.3, "R": 2.0}
VERTICAL = {"q_acc": 0.3, "q_bias": 0.01, "R_baro": 2.0, "climb0": 1.0, "bias0": 1.0}


@pytest.mark.parametrize(
    ("filter", "values", "inputs"),
    [
        (LocalLevel(DT), NOISE, LevelSample(TRACK[:, 0])),
        (ConstantVelocity(DT, "xy"), NOISE, PositionSample(TRACK[:, 0], TRACK[:, 1])),
        (ConstantAcceleration(DT), NOISE, PositionSample(TRACK[:, 0])),
        (Vertical(DT), VERTICAL, VerticalSample(ACC, BARO)),
        (Vertical(DT, "included"), VERTICAL, VerticalSample(ACC + 9.80665, BARO)),
    ],
)
def test_their_kalman_filter_comes_to_the_same(filter, values, inputs):
    """From any start: what is left of it has died out in the second half."""
    params = assembled(type(filter), {k: jnp.asarray(v) for k, v in values.items()})
    form, record = filter.linear(params), filter.measured(inputs)
    n = len(form.transition.F)
    model = LinearModel(form.transition, form.H, form.R, 1e6 * jnp.eye(n), jnp.zeros(n))
    u = None if record.u is None else jnp.asarray(record.u)
    general = run(LinearKalman(), model, Sample(jnp.asarray(record.z), u))[1]
    own = run(filter, params, inputs)[1]
    late = slice(N - 20, None)
    np.testing.assert_allclose(own.variance[late], general.variance[late], rtol=1e-5)
    np.testing.assert_allclose(own.innovation[late], general.innovation[late], atol=1e-4)


def test_deviations_of_measurements_are_told():
    sigma = np.full(N, 2.0)
    level = LocalLevel(DT).measured(LevelSample(TRACK[:, 0], sigma))
    assert level.sigma.shape == (N, 1)
    both = ConstantVelocity(DT, "xy").measured(
        PositionSample(TRACK[:, 0], TRACK[:, 1], None, sigma)
    )
    assert both.sigma.shape == both.z.shape == (N, 2)
