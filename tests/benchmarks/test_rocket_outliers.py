import numpy as np

from benchmarks.rocket_outliers import THINNED, Span, heights, masked


def test_heights_are_those_of_the_pressure_and_intervals_are_masked():
    draw = np.random.default_rng(1)
    t = np.arange(4000) / 250
    climb = -9 + np.cumsum(0.3 * draw.standard_normal(4000))
    true = 900 + np.cumsum(climb) / 250 + 0.07 * draw.standard_normal(4000)
    span = Span("made", -1.0, 100.0, tuple((a, a + 0.1) for a in (3.0, 5.0, 8.0, 11.0)))
    wrong = np.isnan(masked(t, true, span))
    h = np.where(wrong, true + draw.uniform(-40, 40, 4000), true)
    ground, scale, power = 101325.0, 44330.77, 0.190263
    pressure = np.concatenate([np.full(200, ground), ground * (1 - h / scale) ** (1 / power)])
    times, found = heights(np.concatenate([np.full(200, -9.0), t]), pressure, span)
    np.testing.assert_allclose(found, h[::THINNED], rtol=1e-9)
    assert np.isnan(masked(times, found, span)).sum() == wrong[::THINNED].sum() > 5
