"""Passes over times in blocks and parts, held against the same with whole arrays at once."""

import numpy as np
import pytest

from tests.tuner.recordings import refusal
from tuner.data.logs import passes
from tuner.data.logs import steps as steps_module
from tuner.data.logs.clock import judged
from tuner.data.logs.digits import Resolution
from tuner.data.logs.passes import BLOCK, in_parts
from tuner.data.logs.steps import Steps, since_first
from tuner.data.logs.usual import Usual
from tuner.data.reading import read_record

SIZES = (2, 3, BLOCK - 1, BLOCK, BLOCK + 1, BLOCK + 2, 2 * BLOCK, 3 * BLOCK + 5)


@pytest.fixture(params=[1, 3])
def parts(request, monkeypatch):
    """Any column in one part and in three, whatever its length."""
    monkeypatch.setattr(passes, "_LONG", 0)
    monkeypatch.setattr(passes.os, "cpu_count", lambda: request.param)
    return request.param


def columns(rows):
    draw, k = np.random.default_rng(6), np.arange(rows)
    yield "seconds", 0.01 * k, 1.0
    yield "negative zero", np.r_[-0.0, 0.25 * k[1:]], 1.0
    yield "single, negative zero", np.r_[-0.0, 0.25 * k[1:]].astype(np.float32), 1.0
    yield "uneven", 3.0 + 0.01 * k + 1e-3 * draw.random(rows), 1.0
    yield "milliseconds", 7.0 + 10.0 * k, 1e-3
    yield "single", (1.5 + 0.25 * k).astype(np.float32), 1.0
    yield "half", (k % 2000).astype(np.float16), 0.5
    yield "other byte order", (0.5 + 0.01 * k).astype(">f8"), 1.0
    yield "microseconds", 10_000 * k + draw.integers(5000, size=rows), 1e-6
    yield "large", 2**62 + 1000 * k, 1e-9
    yield "unsigned", (10_000 * k + 5).astype(np.uint64), 1e-6
    yield "beyond int64", np.uint64(2**63 + 5) + k.astype(np.uint64), 1e-6
    yield "small", (k % 30_000).astype(np.int16), 1e-3
    yield "small, from zero", (k % 200).astype(np.uint8), 1.0
    yield "flags", k > rows // 2, 1.0
    yield "backwards", -0.01 * k, 1.0
    yield "every second of two", np.stack([0.1 * k, k], axis=1)[:, 0], 1.0
    yield "shortest between blocks", 0.01 * k - 0.005 * (k >= BLOCK) + 1.0, 1.0
    yield "longest between blocks", 0.01 * k + 0.005 * (k >= BLOCK) + 1.0, 1.0
    yield "missing", np.where(k == rows // 2, np.nan, 0.01 * k + 1), 1.0
    yield "infinite", np.where(k == rows // 2, np.inf, 0.01 * k + 1), 1.0


@pytest.mark.parametrize("rows", SIZES)
def test_times_and_extremes_of_their_steps(parts, rows):
    for name, column, scale in columns(rows):
        whole = column.dtype.kind in "iub"
        known = column.astype(np.int64 if whole else np.float64)
        with np.errstate(invalid="ignore"):
            times = (known - known[0]) * scale
            lengths = np.diff(times)
        if not whole and scale == 1.0 and column[0] == 0:
            times = known  # with the signs of its zeros
        steps = since_first(column, scale)
        assert steps.seconds.tobytes() == times.tobytes(), name
        assert steps.seconds.flags.c_contiguous, name
        np.testing.assert_array_equal((steps.lowest, steps.highest), (lengths.min(), lengths.max()))
        again = Steps(times)
        np.testing.assert_array_equal((again.lowest, again.highest), (steps.lowest, steps.highest))


@pytest.mark.parametrize("sampled", [40_000, 200, 3], ids=["all", "some", "too few"])
def test_the_median_is_looked_for_as_times_are_made(parts, sampled, monkeypatch):
    monkeypatch.setattr(steps_module, "_LONG", BLOCK)
    monkeypatch.setattr(steps_module, "_SAMPLED", sampled)
    ahead = set()
    for name, column, scale in columns(3 * BLOCK + 5):
        steps = since_first(column, scale)
        ahead |= {name} if steps.close is not None else set()
        if np.isfinite(steps.seconds).all():
            assert steps.median == np.median(np.diff(steps.seconds)), name
    assert {"uneven", "microseconds"} <= ahead
    assert not {"seconds", "backwards", "flags"} & ahead


def test_a_median_that_its_limits_miss_is_found_in_all_steps(monkeypatch):
    """A sample that knows nothing of most steps: those at odd rows are a hundred times longer."""
    monkeypatch.setattr(steps_module, "_every", lambda rows: 2)
    draw = np.random.default_rng(0)
    lengths = np.where(np.arange(200_000) % 2, 1.0, 0.01) * draw.uniform(1, 1.1, 200_000)
    steps = since_first(1.0 + np.append(0.0, np.cumsum(lengths)), 1.0)
    assert steps.close is not None
    assert steps.median == np.median(np.diff(steps.seconds))


def test_a_single_time_has_no_steps():
    assert since_first(np.array([7]), 0.1).seconds.tolist() == [0.0]


def test_blocks_are_the_same_for_any_number_of_parts(parts):
    for rows in SIZES:
        starts = in_parts(list, rows)
        assert len(starts) <= (1 if parts == 1 else passes._SHARES * parts)
        assert [at for part in starts for at in part] == list(range(0, rows, BLOCK))


def test_a_mistake_in_a_part_is_raised(parts):
    with pytest.raises(ZeroDivisionError):
        in_parts(lambda starts: 1 // starts[0], 3 * BLOCK)


def drawn(kind, rows):
    draw, k = np.random.default_rng(8), np.arange(rows)
    share = draw.random(rows)
    return {
        "close": 0.01 + 5e-4 * share,
        "wide": 0.01 + 8e-3 * share,
        "exponential": draw.exponential(size=rows) + 1e-6,
        "alternating": np.where(k % 2, 0.01, 0.02),
        "stray": np.where(share < 0.19, 0.013, 0.01),
        "too many stray": np.where(share < 0.21, 0.013, 0.01),
        "gaps": np.where(share < 1e-3, 0.2 * share + 0.016, 0.01 + 1e-4 * share),
        "double": np.where(share < 0.15, 0.02, 0.01),
        "too many double": np.where(share < 0.3, 0.02, 0.01),
        "mean off": np.where(k < 0.6 * rows, 0.01, 0.0103),
        "mean nearly off": np.where(k < 0.7 * rows, 0.01, 0.0103),
        "a short block": np.where((k >= BLOCK) & (k < 2 * BLOCK), 0.5, 0.01 + 1e-5 * share),
    }[kind]


def textbook(times):
    """The clock of times as its words have it, with arrays of all steps."""
    steps = np.diff(times)
    usual = np.median(steps)
    gaps = np.flatnonzero(steps > 1.5 * usual)
    line = np.polynomial.polynomial.polyfit(np.arange(len(times)), times, 1)
    off = np.ptp(times - np.polynomial.polynomial.polyval(np.arange(len(times)), line))
    if len(gaps) > 0.2 * len(steps) or (len(gaps) >= 10 and off <= 1e-9):
        gaps = gaps[:0]
    own = np.delete(steps, gaps)
    steady = np.mean(np.abs(own - usual) > 0.1 * usual) <= 0.2
    close = steady and abs(own.mean() - usual) <= 0.01 * usual
    step = usual if close else own.mean()
    return gaps, steps[gaps], step, np.abs(own - step).max() / step, steady


KINDS = ["close", "wide", "exponential", "alternating", "stray", "too many stray", "gaps", "double",
         "too many double", "mean off", "mean nearly off", "a short block"]  # fmt: skip


@pytest.mark.parametrize("rows", [300, 5 * BLOCK + 7])
@pytest.mark.parametrize("kind", KINDS)
def test_clock_is_that_of_the_textbook(parts, kind, rows):
    if kind == "a short block" and rows < 2 * BLOCK:
        rows = 3 * BLOCK
    times = np.append(0.0, np.cumsum(drawn(kind, rows)))
    gaps, lengths, step, jitter, steady = textbook(times)
    found = judged(times)
    assert [row for row, _ in found.gaps] == gaps.tolist()
    assert [length for _, length in found.gaps] == lengths.tolist()
    assert found.step == pytest.approx(step, rel=1e-12)
    assert found.jitter == pytest.approx(jitter, rel=1e-9, abs=1e-9)  # 0 where it is rounding
    assert found.steady == steady
    assert found.seconds is times


def test_steps_of_one_and_two_last_digits_are_a_coarse_clock_and_no_gaps(parts, tmp_path):
    rows = np.arange(2 * BLOCK)
    coarse = rows * 1000 // 950
    for times, gaps in ((coarse, 0), (coarse + 500 * (rows > 1000), (np.diff(coarse) > 1).sum())):
        np.savez(tmp_path / "log.npz", t_ms=times, x=rows)
        found = read_record(tmp_path / "log.npz", ["z=x"]).channels["z"].clock
        assert abs(len(found.gaps) - gaps) <= (gaps > 0)  # the pause may be on one of them
        assert found.step == pytest.approx(1e-3 if gaps else 1e-3 * np.diff(times).mean(), rel=1e-9)


def test_usual_steps_are_those_without_gaps(parts):
    times = np.append(0.0, np.cumsum(drawn("gaps", 3 * BLOCK)))
    steps, lengths = Steps(times), np.diff(times)
    limit = 1.5 * steps.median
    own = lengths[lengths <= limit]
    usual = Usual(steps, *steps.parted(limit))
    assert len(usual) == len(own) < len(lengths)
    assert (usual.lowest, usual.highest) == (own.min(), own.max())
    assert usual.mean == pytest.approx(own.mean(), rel=1e-13)
    for far in (1e-5, 5e-5, 1.0):
        assert usual.stray(far) == np.mean(np.abs(own - steps.median) > far)
    assert usual.mean_is_near(usual.mean, 0.0)
    assert not usual.mean_is_near(np.nextafter(usual.mean, 1.0), 0.0)
    off = abs(usual.mean - 0.01)
    assert usual.mean_is_near(0.01, off)
    assert not usual.mean_is_near(0.01, np.nextafter(off, 0.0))


def test_blocks_of_gaps_alone_and_gaps_at_their_edges(parts):
    lengths = drawn("gaps", 3 * BLOCK)
    lengths[[0, BLOCK - 1, -1]] = lengths[BLOCK : 2 * BLOCK] = 5.0
    steps = Steps(np.append(0.0, np.cumsum(lengths)))
    limit = 1.0
    found = np.diff(steps.seconds)
    own = found[found <= limit]
    usual = Usual(steps, *steps.parted(limit))
    assert len(usual) == len(own) < 2 * BLOCK
    assert (usual.lowest, usual.highest) == (own.min(), own.max())
    assert usual.mean == pytest.approx(own.mean(), rel=1e-13)
    for far in (1e-5, 5e-5, 1.0):
        assert usual.stray(far) == np.mean(np.abs(own - steps.median) > far)


def test_the_mean_does_not_depend_on_the_number_of_processors(monkeypatch):
    times, means = np.cumsum(drawn("exponential", 7 * BLOCK)), set()
    monkeypatch.setattr(passes, "_LONG", 0)
    for count in (1, 2, 3, 5):
        monkeypatch.setattr(passes.os, "cpu_count", lambda count=count: count)
        means.add(judged(times).step)
    assert len(means) == 1


def digits(column):
    """The step of the last decimal in use, by the numbers as they print."""
    noise = 4.0 * np.spacing(np.abs(column).max())
    fits = (np.abs(column - np.round(column, d)).max() <= noise for d in range(10))
    return next((max(10.0**-d, noise) for d, fit in enumerate(fits) if fit), noise)


@pytest.mark.parametrize("rows", [2, 999, 1001, 2 * BLOCK + 3])
def test_resolution_is_that_of_all_numbers(parts, rows):
    draw = np.random.default_rng(9)
    for decimals in (0, 2, 3, 6, 9, 12):
        column = np.round(np.cumsum(draw.random(rows)), decimals)
        for single in (column, column.astype(np.float32)):
            found = Resolution.of_column(single, 1.0, 0.0, float(np.abs(single).max()))
            assert found.step == digits(single.astype(np.float64))
            assert found.step <= found.most


def test_the_one_number_with_more_digits_is_found(parts):
    column = np.round(np.arange(3 * BLOCK) / 299, 3)
    column[2 * BLOCK + 17] += 1e-5
    found = Resolution.of_column(column, 1.0, 0.0, float(column.max()))
    assert (found.most, found.step) == (1e-3, 1e-5)
    assert not found.explains(1e-3, 0.0)
    assert found.explains(1e-5, 0.0)


def test_digits_of_times_are_looked_at_only_where_they_matter():
    def never():
        raise AssertionError("all times were looked at")

    assert not Resolution(1e-3, never).explains(2e-3, 1e-9)
    assert Resolution.of_step(1e-3).explains(1e-3, 0.0)
    assert not Resolution.of_step(1e-3).explains(1.01e-3, 0.0)


K = np.arange(500)


def test_what_is_missing_is_told_before_a_wrong_unit(tmp_path):
    path = tmp_path / "log.npz"
    np.savez(path, t=np.where(K == 250, np.nan, 0.01 * K), x=K)
    missing = "'t' (mapped to time) is missing (empty, NaN, Inf or beyond 1e150) in 1 row"
    assert missing in refusal(path, ["z=x"], time="t:parsec").replace(":parsec", "")
    np.savez(path, t=0.01 * K, x=K)
    assert "is in 'parsec', no unit of time" in refusal(path, ["z=x"], time="t:parsec")


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("row", [0, 250, 499])
def test_a_missing_time_is_told_with_its_place(tmp_path, wrong, row):
    path = tmp_path / "log.npz"
    np.savez(path, t=np.where(row == K, wrong, 0.01 * K), x=K)
    assert f"in 1 row, first at row {row} (counted from 0)" in refusal(path, ["z=x"])


def test_integers_too_close_for_seconds_are_repeated_times(tmp_path):
    path = tmp_path / "log.npz"
    np.savez(path, t_ns=2**60 + 10**6 * K, x=K)
    assert read_record(path, ["z=x"]).channels["z"].clock.step == pytest.approx(1e-3, rel=1e-12)
    np.savez(path, t_ns=np.where(K == 0, 0, 2**60 + K), x=K)  # doubles are 256 apart
    (note,) = [n for n in read_record(path, ["z=x"]).notes if "spread" in n]
    assert note == "time 't_ns': 496 repeated times spread over their time"


def test_times_of_extended_precision(tmp_path):
    path = tmp_path / "log.npz"
    np.savez(path, t=(1.0 + 0.01 * K).astype(np.longdouble), x=K)
    found = read_record(path, ["z=x"]).channels["z"].clock
    assert found.origin == 1
    assert found.step == pytest.approx(0.01, rel=1e-12)


def values_of(path, x, text):
    np.savez(path, t=0.01 * np.arange(len(x)), x=x)
    return read_record(path, [text]).channels["z"].values


@pytest.mark.parametrize("rows", [3, BLOCK + 1])
@pytest.mark.parametrize(
    "kind", [np.float64, np.float32, np.float16, ">f8", np.int16, np.int64, np.uint8, bool]
)
def test_numbers_of_any_kind_times_a_factor(parts, tmp_path, rows, kind):
    x = (100 * np.random.default_rng(3).random((rows, 3))).astype(kind)
    for order in "CF":
        given = np.asarray(x, order=order)
        for text, factor in (("z=x", 1.0), ("z=-x", -1.0), ("z=x*0.3", 0.3)):
            found = values_of(tmp_path / "log.npz", given, text)
            assert found.tobytes() == (x.astype(np.float64) * factor).tobytes()
    assert values_of(tmp_path / "log.npz", x, "z=x[1]").tobytes() == x[:, 1].astype(float).tobytes()


@pytest.mark.parametrize("rows", [3, 2 * BLOCK + 1])
def test_what_was_not_measured_is_nan(parts, tmp_path, rows):
    x = np.random.default_rng(4).normal(size=(rows, 2))
    x[1] = 1e149
    for wrong in (np.inf, -1e200, np.nan):
        x[0, 0] = wrong
        found = values_of(tmp_path / "log.npz", x, "z=x*2")
        np.testing.assert_array_equal(found, np.where(np.abs(x) < 1e150, 2 * x, np.nan))
    x[-1, 1] = -np.inf
    for text, factor in (("z=x", 1.0), ("z=x*100", 100.0)):
        found = values_of(tmp_path / "log.npz", x, text)
        np.testing.assert_array_equal(
            found, np.where(np.abs(x * factor) < 1e150, x * factor, np.nan)
        )


def test_integers_that_float64_rounds_are_refused_wherever_they_are(parts, tmp_path):
    x = np.arange(2 * BLOCK + 5)
    for row, beyond in ((0, 2**53 + 1), (BLOCK, -(2**53) - 1), (-1, 2**60)):
        np.savez(tmp_path / "log.npz", t=0.01 * x, x=np.where(x == x[row], beyond, x))
        assert "beyond 2**53" in refusal(tmp_path / "log.npz", ["z=x"])
    x[7] = 2**53
    assert values_of(tmp_path / "log.npz", x, "z=x")[7] == 2.0**53
