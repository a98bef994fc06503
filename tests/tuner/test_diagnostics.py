"""Whether innovations say what is wrong with a filter, and nothing where nothing is."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chi2, norm, t

from tuner.diagnostics import Innovations, diagnose
from tuner.diagnostics.size import size
from tuner.diagnostics.spread import scores
from tuner.diagnostics.whiteness import lag_one

ONE = 360.0


def draw(seed, *shape):
    return np.random.default_rng(seed).standard_normal(shape)


def unit(y):
    """With a mean square of 1, as tuned variances make it."""
    return y / np.sqrt(np.mean(y**2))


def failed(y, s=None, **more):
    found = diagnose(Innovations.of(y, np.ones_like(y) if s is None else s, **more))
    return {each.test for each in found.failed}


# Against loops and other people's functions.


def test_nis_and_its_interval_of_white_numbers():
    y, s = 2 * draw(20, 300), np.full(300, 4.0)
    s[:10] = 0.0  # these do not count
    found = diagnose(Innovations.of(y, s))
    nis = np.mean(y[10:] ** 2 / 4)
    low, high = chi2.ppf([0.025, 0.975], 290) / 290
    assert found.numbers == 290
    assert [found.nis, found.factor] == pytest.approx([nis, nis], rel=1e-12)
    assert [found.low, found.high] == pytest.approx([low, high], rel=1e-12)
    assert [found.factor_low, found.factor_high] == pytest.approx([nis / high, nis / low])


def test_the_factor_is_the_likeliest():
    from scipy.optimize import minimize_scalar

    y, s = draw(2, 400), np.exp(draw(3, 400))
    best = minimize_scalar(lambda ln: np.sum(y**2 / s / np.exp(ln) + ln), bracket=(-5, 5)).x
    assert np.log(diagnose(Innovations.of(y, s)).factor) == pytest.approx(best, abs=1e-6)


def test_the_interval_of_correlated_numbers_holds_what_it_should():
    """Of a mean of squares of a first-order process with a correlation of 0.8, in 95 % of cases."""
    inside = 0
    for seed in range(200):
        e = lfilter([0.6], [1.0, -0.8], draw(seed, 900))[100:]
        found = size(Innovations.of(e, np.ones(800)).columns)
        inside += found.low <= found.nis <= found.high
    # Two and a half deviations of a count of 200; without the correction it is 68 %.
    assert 200 * 0.91 <= inside <= 200 * 0.99


def test_ljung_box_is_that_of_a_loop():
    e = draw(4, 200)
    n, power, Q = 200, np.sum(e**2), 0.0
    for lag in range(1, 11):
        r = sum(e[i] * e[i - lag] for i in range(lag, n)) / power
        Q += n * (n + 2) * r**2 / (n - lag)
    found = diagnose(Innovations.of(e, np.ones(200)))["whiteness"]
    assert found.statistic == pytest.approx(Q, rel=1e-12)
    assert found.details["p_ljung_box"] == pytest.approx(chi2.sf(Q, 10), rel=1e-9)
    tuned = diagnose(Innovations.of(e, np.ones(200)), fitted=2)["whiteness"]
    assert tuned.details["p_ljung_box"] == pytest.approx(chi2.sf(Q, 8), rel=1e-9)


def test_no_pair_joins_two_recordings():
    e = draw(5, 100, 2, 1)
    whole = diagnose(Innovations.of(e, np.ones_like(e)))["whiteness"].statistic
    Q, n, power = 0.0, 200, np.sum(e**2)
    for lag in range(1, 11):
        r = sum(e[lag:, k, 0] @ e[:-lag, k, 0] for k in (0, 1)) / power
        Q += n * (n + 2) * r**2 / (n - 2 * lag)
    assert whole == pytest.approx(Q, rel=1e-12)


def test_scores_are_squares_of_normal_quantiles():
    e = np.array([0.1, -3.0, 1e9, 0.5])
    (column,) = Innovations.of(e, np.ones(4)).columns
    quantiles = norm.ppf((1 + np.array([1, 3, 4, 2]) / 5) / 2) ** 2
    assert scores(column).values == pytest.approx(quantiles - quantiles.mean(), rel=1e-12)


def test_the_usual_deviation_is_that_without_outliers():
    e = 0.01 * draw(6, 1200)
    e[::20] += 5.0
    (column,) = Innovations.of(e, np.ones(1200)).columns
    inside = np.delete(e, np.arange(0, 1200, 20))
    inside = inside[np.abs(inside) < 3 * column.scale]
    # Of normal numbers, those within three deviations have this mean square.
    share = 1 - 2 * 3 * norm.pdf(3) / (1 - 2 * norm.sf(3))
    assert column.scale == pytest.approx(np.sqrt(np.mean(inside**2) / share), rel=1e-5)
    assert column.scale == pytest.approx(0.01, rel=0.05)


def test_lag_one_of_white_and_of_like_numbers():
    white = draw(2, 4000, 2)
    assert abs(lag_one(white)) < 4 / np.sqrt(8000)  # four of its deviations
    like = np.cumsum(white, axis=0)
    assert lag_one(like) > 0.99
    assert np.isnan(lag_one(np.full((5, 1), np.nan)))
    # Several measurements are not joined: the last of one and the first of the next are no pair.
    two = np.stack([[1.0, 1.0], [-1.0, -1.0]], axis=1)
    assert lag_one(two) == pytest.approx(1.0)


# Nothing where nothing is wrong.


@pytest.mark.parametrize(("samples", "recordings", "parts"), [(60, 1, 1), (200, 1, 2), (50, 6, 1)])
def test_false_alarms_are_rare(samples, recordings, parts):
    """At most 2 % each; of 200 records 9 or more are 2 % in 2 cases of 100."""
    counts, cases = {}, 200
    for seed in range(cases):
        y = draw(1000 + seed, samples, recordings, parts)
        level = np.cumsum(draw(5000 + seed, samples, recordings, parts), axis=0)
        for test in failed(y, levels=level, turns=(ONE,)):
            counts[test] = counts.get(test, 0) + 1
    assert max(counts.values()) < 9, counts
    assert counts, "a test that never fails tests nothing"


# Each fault by its own test, with its way out.


def test_wrong_variances():
    y = draw(70, 500)
    for factor in (0.5, 2.0):
        found = diagnose(Innovations.of(y, np.full(500, factor)))
        assert [each.test for each in found.failed] == ["size"]
        words = "too large" if factor > 1 else "too small"
        assert f"all noise variances are {words} by a factor" in found["size"].sentence
        assert found.factor_low < 1 / factor < found.factor_high
    # One measurement's is too small and another's too large: NIS of all is 1.
    y = draw(8, 500, 2)
    both = diagnose(Innovations.of(y, np.ones_like(y) * [0.7, 1.75], names=("x", "y")))
    assert both.low < both.nis < both.high
    assert "of y is" in both["size"].sentence or "of x is" in both["size"].sentence


def test_outliers_are_counted_and_placed():
    y = draw(9, 1200)
    y[100:1000:30] += 8.0
    found = diagnose(Innovations.of(y, np.ones(1200), times=np.arange(1200) / 20))["outliers"]
    beyond = np.abs(y) / np.sqrt(np.mean(np.delete(y, np.arange(100, 1000, 30)) ** 2)) > 4
    assert found.statistic == beyond.sum()
    assert found.details["expected"] == pytest.approx(1200 * 2 * t.sf(4, 1199), rel=1e-9)
    assert found.details["time"] == pytest.approx(np.argmax(np.abs(y)) / 20)
    words = f"{beyond.sum()} of 1200 innovations lie beyond 4 deviations where 0.081 are expected"
    assert found.sentence.startswith(words)
    assert "--set gate=4" in found.sentence
    # One alone is enough if it is large, whatever the filter says of its size.
    y = 1e-3 * draw(10, 100)
    y[50] = 0.01
    assert failed(y) == {"outliers", "size"}


def test_coloured_innovations_and_offsets():
    e = draw(11, 500)
    assert failed(e[1:] + 0.5 * e[:-1], np.full(499, 1.25)) == {"whiteness"}
    offset = diagnose(Innovations.of(e + 0.3, np.full(500, 1.09)))
    assert [each.test for each in offset.failed] == ["whiteness"]
    assert "deviations: an offset" in offset["whiteness"].sentence


def test_noise_that_changes_with_time_or_level():
    e, ramp = draw(12, 600), np.linspace(-1, 1, 600)
    shuffled = np.random.default_rng(1).permutation(ramp)
    by_time = failed(unit(e * np.exp(0.4 * ramp)), levels=10 + shuffled)
    assert by_time == {"over time"}
    found = diagnose(
        Innovations.of(unit(e * np.exp(0.4 * shuffled)), np.ones(600), levels=shuffled)
    )
    assert [each.test for each in found.failed] == ["over level"]
    assert "grows with the level" in found["over level"].sentence
    # At a level of both signs it is its size that may count.
    sized = unit(e * np.exp(0.8 * np.abs(shuffled)))
    assert failed(sized, levels=shuffled) == {"over level"}
    # What comes and goes, and is as large at the end as at the beginning.
    wave = unit(e * np.exp(0.5 * np.sin(2 * np.pi * ramp)))
    assert failed(wave) == {"over time"}


def test_a_noisier_recording_among_several():
    e = draw(13, 100, 8, 1)
    e[:, 5] *= 2
    found = diagnose(Innovations.of(e, np.ones_like(e)))["over time"]
    assert found.verdict == "failed"
    assert "in recording 6)" in found.sentence


def test_wrapped_angles():
    y = 0.02 * draw(14, 400)
    y[[100, 250]] += [2 * np.pi, -4 * np.pi]
    found = diagnose(Innovations.of(y, np.full(400, 4e-4), turns=(2 * np.pi, 360.0)))
    assert [each.test for each in found.failed][:2] == ["full turns", "outliers"]
    assert "2 innovations lie within the noise of a full turn (6.28319)" in (
        found["full turns"].sentence
    )
    # Outliers of any other size are none, nor is noise as large as a turn.
    y[[100, 250]] = [1.0, -5.0]
    assert "full turns" not in failed(y, np.full(400, 4e-4), turns=(2 * np.pi,))
    loud = diagnose(Innovations.of(2 * draw(15, 400), np.full(400, 4.0), turns=(2 * np.pi,)))
    assert loud["full turns"].verdict == "not tried"


def test_a_start_that_contradicts_the_data():
    y = draw(16, 300)
    y[:12] += 6 * 0.8 ** np.arange(12)
    assert "start" in failed(y)
    # An outlier a little later is none.
    y = draw(17, 300)
    y[5] += 30
    assert failed(unit(y)) == {"outliers"}


# Bad input.


def test_a_filter_that_goes_astray():
    y = draw(18, 100)
    y[60:] = np.nan
    found = diagnose(Innovations.of(y, np.ones(100)))
    assert "40 innovations are not finite, the first at 60 s" in found["size"].sentence
    assert "size" in failed(draw(18, 100), np.where(np.arange(100) < 50, 1.0, -1.0))


def test_too_little_is_not_judged():
    for y, s in ((np.zeros(0), np.zeros(0)), (draw(1, 30), np.zeros(30)), (draw(1, 3), np.ones(3))):
        found = diagnose(Innovations.of(y, s))
        assert not found.failed
        assert found["whiteness"].verdict == "not tried"
        assert found["whiteness"].sentence
    silent = diagnose(Innovations.of(np.zeros(100), np.ones(100)))
    assert silent.nis == 0.0
    assert silent.verdict == "everything is predicted: too little noise for a test"
    assert [each.test for each in silent.failed] == ["size"]


@pytest.mark.parametrize(
    "parts",
    [
        {"variance": np.ones(5)},
        {"variance": np.ones(6), "levels": np.ones(5)},
        {"variance": np.ones(6), "names": ("a", "b")},
    ],
)
def test_shapes_that_do_not_go_together(parts):
    with pytest.raises(ValueError, match=r"give"):
        Innovations.of(np.ones(6), **parts)


def test_huge_and_tiny_numbers():
    e = draw(19, 200)
    for unit in (1e-150, 1e150):
        found = diagnose(Innovations.of(unit * e, np.full(200, unit) ** 2, turns=(ONE,)))
        assert found.nis == pytest.approx(np.mean(e**2), rel=1e-9)
        assert not found.failed
