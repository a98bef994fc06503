"""Innovations as figures: their shares, windows, correlations and spread."""

import numpy as np
import pytest

from tuner.diagnostics import Innovations
from tuner.run.innovation_figures import drawn_innovations, windows


def white(samples=2000, scale=1.0, seed=0):
    draw = np.random.default_rng(seed)
    times = 0.1 * np.arange(samples)
    return Innovations.of(scale * draw.standard_normal(samples), np.ones(samples), times=times)


def figures(before, now):
    return {shown.figure.name: shown for shown in drawn_innovations(before, now)}


def test_a_right_filter():
    found = figures(white(scale=3.0), white())
    assert [*found] == ["innovations", "nis", "whiteness", "spread"]
    e = white().value[:, 0, 0]
    share = 100 * np.mean(np.abs(e) > 1.96)
    assert found["innovations"].figure.title.startswith(f"{share:.1f} % of the innovations")
    band, before, tuned = found["nis"].figure.lines
    assert [line.label for line in (before, tuned)] == ["before", "tuned"]
    assert np.mean(before.y) == pytest.approx(9 * np.mean(tuned.y))
    assert (band.x[0], band.x[-1]) == pytest.approx((0.0, 199.9))
    inside = np.mean((tuned.y >= band.y) & (tuned.y <= band.upper))
    assert 0.85 <= inside <= 1
    r = found["whiteness"].figure.lines[2].y
    assert r[4] == pytest.approx(e[5:] @ e[:-5] / (e @ e))
    innovations, normal = found["spread"].figure.lines
    area = np.sum(np.diff(innovations.x) * innovations.upper[1:])
    assert area == pytest.approx(1.0)
    assert np.trapezoid(normal.y, normal.x) == pytest.approx(1.0, abs=1e-3)


def test_windows_are_means_over_time():
    found = windows(white(samples=600))
    e = white(samples=600).value[:, 0, 0]
    assert found.numbers.sum() == 600
    assert found.numbers[0] == 15
    assert found.nis[0] == pytest.approx(np.mean(e[:15] ** 2))
    assert found.times[0] == pytest.approx(0.7)


def test_a_start_of_which_nothing_counts_is_left_out():
    nothing = Innovations.of(np.full(2000, np.nan), np.ones(2000), times=0.1 * np.arange(2000))
    found = figures(nothing, white())
    assert [line.label for line in found["nis"].figure.lines] == ["95 % expected", "tuned"]
    assert np.isnan(found["whiteness"].figure.lines[1].y).all()
    assert not figures(white(), nothing)


def test_a_start_that_is_far_off_is_shown_by_powers():
    found = figures(white(scale=1e100), white())
    assert found["nis"].figure.log == "y"
    assert [*figures(white(samples=20), white(samples=20))] == ["innovations"]
