"""Figures: their data as CSV, to the digit, and a picture that is one."""

import csv
import io
import struct
import zlib

import numpy as np
import pytest
from matplotlib.layout_engine import ConstrainedLayoutEngine

from tuner.run.drawing import MANY, _draw_numbered, draw, new_canvas, picture, table
from tuner.run.figure import Chart, Line, Map, merged

NASTY = 'a "quoted", comma\nand line'
CHART = Chart(
    "chart",
    "A title",
    "time, s",
    "output, rad/s",
    (
        Line("one", np.array([0.0, 1.0, 2.0]), np.array([1 / 3, -1e-20, 12345.678901234])),
        Line("a point", np.array([1.5]), np.array([2.5])),
        Line(NASTY, np.array([1e300, -2.0]), np.array([np.nan, np.inf])),
        Line("empty", np.zeros(0), np.zeros(0)),
    ),
)
MAP = Map(
    "map",
    "A plane",
    "log10 R",
    "log10 Q",
    "log10 cost, dB",
    np.array([1.0, 2.0]),
    np.array([10.0, 20.0, 30.0]),
    np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]),
    (Line("best", np.array([1.5]), np.array([15.0])),),
)


@pytest.fixture(scope="module", autouse=True)
def laid_out(rough):
    """Pictures as users see them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ConstrainedLayoutEngine, "execute", rough)
        yield


def rows(figure):
    return list(csv.reader(io.StringIO(table(figure).decode("utf-8"))))


def test_chart_as_csv():
    header, *points = rows(CHART)
    assert header == ["label", "x", "y"]
    labels, xs, ys = zip(*points, strict=True)
    assert labels == ("one",) * 3 + ("a point",) + (NASTY,) * 2
    assert [float(x) for x in xs] == [0.0, 1.0, 2.0, 1.5, 1e300, -2.0]
    # Ten digits.
    expected = [1 / 3, -1e-20, 12345.678901234, 2.5, np.nan, np.inf]
    np.testing.assert_allclose([float(y) for y in ys], expected, rtol=1e-9)
    assert table(CHART).endswith(b"\n")


def test_map_as_csv():
    header, *points = rows(MAP)
    assert header == ["label", "x", "y", "z"]
    assert points[:3] == [
        ["log10 cost, dB", "1", str(y), str(z)]
        for y, z in zip((10, 20, 30), (1, 2, 3), strict=True)
    ]
    assert points[5] == ["log10 cost, dB", "2", "30", "6"]
    assert points[6:] == [["best", "1.5", "15", ""]]


def chunks(data):
    """The chunks of a PNG, with their checksums verified."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, found = 8, []
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        (checksum,) = struct.unpack(">I", data[at + 8 + length : at + 12 + length])
        assert zlib.crc32(kind + body) == checksum
        found.append((kind, body))
        at += 12 + length
    return found


def pixels(data):
    return zlib.decompress(b"".join(body for kind, body in chunks(data) if kind == b"IDAT"))


def image(data):
    """Brightness, 0 to 255, of every pixel."""
    from matplotlib.image import imread

    return 255 * imread(io.BytesIO(data))[..., :3].mean(axis=-1)


@pytest.mark.parametrize("log", ["", "x", "y", "xy"])
def test_chart_as_picture(log):
    line = Line("one", np.array([1.0, 2.0, 3.0]), np.array([1.0, 10.0, 5.0]))
    data = picture(Chart("chart", "A title", "x", "y", (line,), log))
    found = chunks(data)
    assert found[0][0] == b"IHDR"
    assert found[-1] == (b"IEND", b"")
    width, height = struct.unpack(">II", found[0][1][:8])
    assert (width, height) == (880, 550)
    assert len(set(pixels(data))) > 10  # not one plain colour
    assert not any(kind == b"tEXt" and b"Software" in body for kind, body in found)


def test_map_as_picture_shows_its_quantity():
    other = Map(**{**vars(MAP), "z": MAP.z[::-1]})
    assert pixels(picture(MAP)) != pixels(picture(other))


@pytest.mark.parametrize("count", [1, 3, MANY, MANY + 1, 20])
@pytest.mark.parametrize("drawn", ["curve", "points", "band"])
def test_a_legend_covers_no_curve(count, drawn):
    """It stands above the axes, or beside them, and within the picture; the title above it."""
    x = np.linspace(0.0, 1.0, 200)
    y = np.random.default_rng(1).uniform(size=(count, 200))
    lines = tuple(
        Line(f"line {i} all over", x, row, drawn=drawn, upper=row + 1) for i, row in enumerate(y)
    )
    canvas = new_canvas((8, 5))
    axes = canvas.subplots()
    draw(Chart("c", "A title", "x", "y", lines), canvas, axes)
    canvas.draw_without_rendering()
    legend, frame = axes.get_legend().get_window_extent(), axes.get_window_extent()
    assert legend.y0 >= frame.y1 - 1 or legend.x0 >= frame.x1
    assert legend.x0 >= 0
    assert legend.x1 <= 880 + 1
    title = axes._left_title.get_window_extent()
    assert title.y1 <= 550
    assert title.y0 >= legend.y1 - 2 or legend.x0 >= frame.x1


def test_a_long_title_stays_within_the_picture():
    x = np.linspace(0.0, 1.0, 9)
    canvas = new_canvas((8, 5))
    axes = canvas.subplots()
    title = "what was found, with all the numbers that it takes, and a unit; " * 4
    draw(Chart("c", title, "x", "y", (Line("a", x, x), Line("b", x, -x))), canvas, axes)
    canvas.draw_without_rendering()
    box, legend = axes._left_title.get_window_extent(), axes.get_legend().get_window_extent()
    assert axes._left_title.get_text().split() == title.split()
    assert box.x0 >= 0
    assert box.x1 <= 880
    assert box.y1 <= 550
    assert box.y0 >= legend.y1 - 2


def test_curves_that_coincide_are_one():
    x = np.linspace(0.0, 1.0, 50)
    lines = [Line("a", x, x), Line("b", x, 1 - x), Line("c", x, x + 0.005), Line("d", x, x + 0.02)]
    assert [line.label for line in merged(lines)] == ["a; c", "b", "d"]
    gap = Line("e", x, np.where(x < 0.5, np.nan, x))
    assert [line.label for line in merged([lines[0], gap])] == ["a; e"]
    assert [line.label for line in merged([lines[0], Line("f", x[:9], x[:9])])] == ["a", "f"]
    assert merged([]) == ()


def test_marks_that_coincide_are_all_seen():
    one, x = np.array([1.0]), np.array([0.0, 2.0])
    both = (Line("curve", x, x), Line("first", one, one), Line("second", one, one))
    alone = (*both[:2], Line("second", 0 * one, one))
    assert pixels(picture(Chart("c", "t", "x", "y", both))) != pixels(
        picture(Chart("c", "t", "x", "y", alone))
    )
    canvas = new_canvas((8, 5))
    axes = canvas.subplots()
    draw(Chart("c", "t", "x", "y", both), canvas, axes)
    _, first, second = axes.lines
    assert first.get_markersize() > second.get_markersize() > 4
    assert first.get_marker() != second.get_marker()


def test_axes_of_equal_scale():
    circle = np.exp(1j * np.linspace(0, 2 * np.pi, 50))
    canvas = new_canvas((8, 5))
    axes = canvas.subplots()
    chart = Chart("c", "t", "x", "y", (Line("circle", circle.real, circle.imag),), equal=True)
    draw(chart, canvas, axes)
    canvas.draw_without_rendering()
    (x0, y0), (x1, y1) = axes.transData.transform([(0, 0), (1, 1)])
    assert x1 - x0 == pytest.approx(y1 - y0)


@pytest.mark.parametrize("log", ["", "xyz", "z"])
def test_a_map_on_logarithmic_axes(log):
    x, y = np.geomspace(1e-13, 1, 20), np.geomspace(1e-3, 1e3, 15)
    z = np.exp(np.log(x[:, None] / y[None, :]) ** 2 / 50)
    canvas = new_canvas((8, 5))
    axes = canvas.subplots()
    draw(Map("m", "t", "x", "y", "z", x, y, z, log=log), canvas, axes)
    assert axes.get_xscale() == ("log" if "x" in log else "linear")
    assert picture(Map("m", "t", "x", "y", "z", x, y, z, log=log))[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("last", "labels"),
    [(12.0, {"0.2", "0.5", "1", "2", "5", "10"}), (0.5, {"0.2", "0.3", "0.4", "0.5"})],
)
def test_a_short_logarithmic_axis_has_plain_numbers(last, labels):
    canvas = new_canvas((8, 5))
    axes = canvas.subplots()
    x = np.geomspace(0.2, last, 9)
    draw(Chart("c", "c", "x", "y", (Line("a", x, x),), log="xy"), canvas, axes)
    for axis in (axes.xaxis, axes.yaxis):
        assert {t.get_text() for t in axis.get_ticklabels()} >= labels
        assert not any(t.get_text() for t in axis.get_ticklabels(minor=True))


def test_numbers_stand_at_equal_distances():
    """Trials 1, 2 and 30 are drawn as 1, 2 and 3 would be, but for their labels."""
    charts = [
        Chart("c", "t", "x", "y", (Line("one", np.array(x), np.array([1.0, 5, 3])),), "y", True)
        for x in ([1.0, 2.0, 30.0], [1.0, 2.0, 3.0], [30.0, 2.0, 1.0])
    ]
    same, other, turned = (image(picture(chart)) for chart in charts)
    above = slice(0, 480)  # the labels are below
    np.testing.assert_array_equal(same[above], other[above])
    assert (same != other).any()
    assert (same[above] != turned[above]).any()


def test_equal_points_of_numbers_stand_side_by_side():
    """Not one above the other: more of the first line's colour is seen than in the legend."""
    from matplotlib.image import imread

    x, y = np.arange(1.0, 21.0), np.ones(20)
    chart = Chart("c", "t", "x", "y", (Line("one", x, y), Line("other", x, y)), "", True)
    pixels = (255 * imread(io.BytesIO(picture(chart)))[..., :3]).round()
    blue, orange = (
        (pixels == colour).all(axis=-1).sum() for colour in ((0, 114, 178), (213, 94, 0))
    )
    assert blue > 0.3 * orange > 100  # a circle beside a square


def test_the_last_number_is_shown_where_its_points_stand_on_one_side():
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    whole, first = (np.arange(1.0, 1.0 + n) for n in (3, 1))
    _draw_numbered((Line("whole", whole, whole), Line("first", first, first)), axes)
    low, high = axes.get_xlim()
    assert low + high == pytest.approx(2.0)  # of three numbers the middle is in the middle
    assert high - low > 3.0


def test_points_of_numbers_may_be_missing():
    gap = Line("gap", np.array([1.0, np.nan, 4.0]), np.array([1.0, np.nan, 2.0]))
    whole = Line("gap", np.array([1.0, 4.0]), np.array([1.0, 2.0]))
    nothing = Line("none", np.zeros(0), np.zeros(0))
    one, other = (Chart("c", "t", "x", "y", (n, nothing), "", True) for n in (gap, whole))
    assert picture(one) == picture(other)


def test_equal_figures_give_equal_pictures():
    assert picture(MAP) == picture(MAP)


def test_nasty_curves_can_be_drawn():
    labelled = Chart("c", "t", "x", "y", (CHART.lines[0], CHART.lines[1], CHART.lines[3]))
    assert picture(labelled)[:4] == b"\x89PNG"


def test_no_state_is_left_with_matplotlib():
    from matplotlib import _pylab_helpers

    before = len(_pylab_helpers.Gcf.figs)
    picture(MAP)
    assert len(_pylab_helpers.Gcf.figs) == before
