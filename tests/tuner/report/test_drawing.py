"""Pictures as shapes: fewer points that look alike, axes, and paths."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tuner.report import made
from tuner.report.axis import FULL, Axis
from tuner.report.contours import contoured
from tuner.report.drawing import drawn
from tuner.report.report_json import MOST
from tuner.report.thinning import rounded, rows

floats = st.floats(-1e12, 1e12)


@given(st.lists(floats | st.just(float("nan")), min_size=1, max_size=400), st.integers(4, 60))
def test_no_peak_is_lost(values, most):
    y = np.array(values)
    shown = y[rows(y, most)]
    assert len(shown) <= max(1.5 * most + 2, most)
    if np.isfinite(y).any():
        assert np.nanmax(shown) == np.nanmax(y)
        assert np.nanmin(shown) == np.nanmin(y)
    assert np.isnan(shown).any() == np.isnan(y).any()


@given(st.lists(floats, min_size=2, max_size=50))
def test_rounding_is_not_seen(values):
    y = np.array(values)
    found = np.array(rounded(y, log=False))
    assert np.allclose(found, y, rtol=0, atol=4e-5 * max(np.ptp(y), 1e-9 * np.abs(y).max()))


@given(floats, floats)
def test_the_numbers_at_an_axis(one, other):
    axis = Axis.over(np.array([one, other]))
    ticks = axis.ticks()
    places = [tick.at for tick in ticks]
    assert places == sorted(places)
    assert all(-1e-6 <= place <= 1 + 1e-6 for place in places)
    assert len({tick.text for tick in ticks}) == len(ticks)
    assert 1 <= len(ticks) <= 8


@given(st.floats(1e-9, 1e9), st.floats(1.5, 1e12))
def test_the_numbers_at_a_logarithmic_axis(low, ratio):
    axis = Axis.over(np.array([low, low * ratio]), log=True)
    places = [tick.at for tick in axis.ticks()]
    assert places == sorted(places)
    assert all(-1e-6 <= place <= 1 + 1e-6 for place in places)
    assert places
    ends = axis.at(np.array([axis.low, axis.high, -1.0]))
    assert ends[:2] == pytest.approx([0, FULL])
    assert np.isnan(ends[2])


def test_a_chart():
    chart, sizes, counted, _ = made.pictures()
    found = drawn(chart)
    assert [shape.kind for shape in found.shapes] == ["band", "limit", "points", "curve"]
    assert [shape.look for shape in found.shapes] == ["c0", "muted", "muted", "c0"]
    assert [shape.label for shape in found.legend] == ["95 % expected", "measured", "tuned"]
    assert all(len(line.x) <= 1.5 * MOST + 2 for line in chart.lines)
    assert all(line.of in (3000, 2) for line in chart.lines)
    assert found.joined == "time"
    assert found.y_label == "level, Pa²"
    numbers = np.array(re.findall(r"-?\d+\.?\d*", found.shapes[3].path), float).reshape(-1, 2)
    assert (numbers >= 0).all()
    assert (numbers <= FULL).all()
    assert numbers[0, 0] == 0
    t = chart.lines[2].x
    assert numbers[:, 0] == pytest.approx(FULL * np.array(t) / 2999, abs=0.06)
    assert [tick.text for tick in drawn(sizes).x_ticks] == [
        *("10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹", "10²", "10³"),
    ]
    assert [tick.text for tick in drawn(counted).x_ticks] == ["1", "7", "30"]


def test_a_map():
    found = contoured(made.pictures()[3])
    assert [shape.kind for shape in found.shapes] == [*["fill"] * 4, "curve", "spot"]
    assert found.x.log
    assert found.y.log
    assert [words for _, words in found.keys] == [
        *("0 to 1", "1 to 3", "3 to 9", "above 9"),
    ]
    # The outline is a circle of radius sqrt(3) in the logarithm, around 0.1.
    place = np.array(re.findall(r"\d+", found.shapes[4].path), float).reshape(-1, 2)
    radius = np.hypot(*((place - FULL / 2) / FULL * np.log(100)).T)
    assert radius == pytest.approx(np.full(len(radius), np.sqrt(3)), rel=0.02)


def test_a_chart_of_nothing():
    (chart,) = made.kept_pictures(
        [made.ReportFigure("figures", made.Chart("a", "b", "x", "y", ()))]
    )
    assert drawn(chart).shapes == []


def test_axes_of_one_scale():
    track = made.Line("track", np.array([0.0, 10.0]), np.array([0.0, 1.0]))
    chart = made.Chart("track", "A track", "x, m", "y, m", (track,), equal=True)
    (kept,) = made.kept_pictures([made.ReportFigure("figures", chart)])
    found = drawn(kept)
    spans = [axis.high - axis.low for axis in (found.x, found.y)]
    assert found.aspect == pytest.approx(spans[0] / spans[1]) == pytest.approx(2.0)
