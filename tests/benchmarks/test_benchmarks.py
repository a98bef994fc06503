"""The benchmark's own parts: that C computes the same filter, and what the table and guard say."""

import io
import json

import jax.numpy as jnp
import numpy as np
import pytest
from rich.console import Console

from benchmarks import unscented
from benchmarks.baseline import NoCompilerError, Weights, baseline
from benchmarks.guard import slow_products, slow_rows, slow_settling, verdict
from benchmarks.loops import exact, matrix_loop, scalar_loop
from benchmarks.machine import machine
from benchmarks.page import page
from benchmarks.processes import loop_flags
from benchmarks.single import passes
from benchmarks.table import Row, as_json, duration, markdown, number, show
from benchmarks.timing import Times, interleave
from benchmarks.work import DT, STEP, Q, R, Work, pairs
from filters.backend import LOOP_OPTION
from objectives import Reading
from tests import oracles_suh2004 as oracle
from tuner import values, values_and_gradients

WORK = Work(4000, 1)
FAST = {
    "gyroscope filter": 1e-3,
    "generic LinearKalman": 2e-3,
    "cost": 1e-3,
    "cost + gradient": 3e-3,
    "generic gradient": 6e-3,
    "Python loop": 40e-3,
}
SLOW = FAST | {"cost + gradient": 90e-3, "generic gradient": 60e-3}
ROWS = [
    Row("One", "a | b", "1 ms", "C: 2 ms", 0.5, 0.4, target=1.0, note="said"),
    Row("One", "slow", figure=4.0, target=3.0, why="it is slow"),
    Row("Two", "peer", figure=80.0, target=75.0, sense="least"),
    Row("Two", "absent", target=75.0, sense="least", note="not installed"),
    Row("Two", "free", figure=1.0),
]


@pytest.fixture(scope="module")
def limit():
    try:
        return baseline()
    except NoCompilerError as error:
        pytest.skip(str(error))


# --- the loops and C ----------------------------------------------------------------------------


def test_loops_agree_with_forty_digits():
    expected = exact(WORK.signal, R, Q, DT)
    for actual in (
        scalar_loop(WORK.signal.tolist(), R, Q, DT),
        matrix_loop(WORK.signal, R, Q, DT),
    ):
        # P22 - K P12 loses digits where P0 = ones has rank one: 1e-16 / R of the step
        np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-9 * STEP)


@pytest.mark.parametrize("noise", [(R, Q), (1e-12, 1e-9)], ids=["table 1", "small R"])
def test_c_agrees_with_forty_digits(limit, noise):
    expected = exact(WORK.signal, *noise, DT)
    actual = limit.forward(WORK.signal, *noise)
    np.testing.assert_allclose(actual, expected, rtol=0, atol=1e-12 * STEP)  # 4000 roundings


def test_our_passes_agree_with_c(limit):
    expected = limit.forward(WORK.signal, R, Q)
    for call in passes(WORK).values():
        # as for the loops: the generic filter cannot know that P0 has rank one
        np.testing.assert_allclose(call(), expected, rtol=0, atol=1e-9 * STEP)


def test_c_takes_two_signals_through_the_same_gains(limit):
    both = limit.forward(WORK.pair, R, Q)
    # the filter is linear; the sums are rounded in another order
    np.testing.assert_allclose(both.sum(axis=1), limit.forward(WORK.signal, R, Q), atol=1e-13)


def test_c_batches_agree_with_ours(limit):
    problem, points = WORK.problem(Reading.R1), pairs(5)  # fewer than a group of vectors
    truth = problem.data.truth
    weights = Weights(*map(np.asarray, (truth.step, truth.lag_weight, truth.power_weight)))
    costs = values(problem, np.log(points))
    np.testing.assert_allclose(limit.costs(points, WORK.signal, weights), costs, rtol=1e-12)
    found, gradients = values_and_gradients(problem, np.log(points))
    c = limit.gradients(points, WORK.signal, weights)
    np.testing.assert_allclose(c[0], found, rtol=1e-12)
    scale = np.abs(gradients).max()  # derivatives of both signs cancel
    np.testing.assert_allclose(c[1:].T, gradients, rtol=1e-9, atol=1e-11 * scale)


# --- timing -------------------------------------------------------------------------------------


def test_calls_take_turns():
    seen = []
    times = interleave({"a": lambda: seen.append("a"), "b": lambda: jnp.ones(3)}, 3)
    assert seen == ["a"] * 4
    assert {name: len(taken) for name, taken in times.seconds.items()} == {"a": 3, "b": 3}


def test_ratios_are_those_of_neighbours():
    busy = np.array([1.0, 1.0, 10.0])  # the machine was busy in the last round
    times = Times({"ours": 2 * busy, "C": busy, "rest": busy})
    assert times.ratio("ours", "C").median == 2.0
    assert times.ratio("ours", "C", "rest").median == 1.0
    assert times.ratio("ours", "C").best == 2.0
    assert times.noise("C") == 4.5


# --- the table ----------------------------------------------------------------------------------


def test_c_runs_the_papers_tilt_filter(limit):
    acceleration, rate = map(np.ascontiguousarray, oracle.experiment2())
    r = oracle.DEFAULTS["r_nom"]
    names = ("alpha1", "alpha2")
    numbers = [oracle.DEFAULTS["q1"], r, r, oracle.DEFAULTS["r3"]]
    numbers += [oracle.DEFAULTS[name] for name in names]
    settings = (oracle.DEFAULTS["T"], oracle.DEFAULTS["delta"], 0.0)
    found = limit.tilt(settings, acceleration, rate, np.array(numbers), np.empty((len(rate), 2)))
    expected = oracle.run(acceleration, rate, "two-step")
    np.testing.assert_allclose(found[:, 0], expected["theta"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(found[:, 1], expected["phi"], rtol=0, atol=1e-12)


def test_targets_are_judged_by_the_figure():
    assert [row.reached for row in ROWS] == [True, False, True, None, None]


def test_markdown_table():
    lines = markdown(ROWS).splitlines()
    assert lines[0] == "### One"
    assert lines[4] == "| a / b | 1 ms | C: 2 ms | 0.5 x | 0.4 x | <= 1 x | yes |"
    assert "- a | b: said" in lines
    assert "| peer |  |  | 80 x |  | >= 75 x | yes, narrowly |" in lines
    assert "| absent |  |  |  |  | >= 75 x | not measured |" in lines


def test_table_on_a_terminal():
    out = io.StringIO()
    show(ROWS, Console(file=out, width=120))
    assert "<= 3 x" in out.getvalue()
    assert "a | b: said" in out.getvalue()


def test_json_says_what_was_reached():
    found = json.loads(json.dumps(as_json(ROWS)))
    assert [row["reached"] for row in found] == [True, False, True, None, None]


def test_page_tells_what_was_missed():
    text = page(ROWS, machine(None), 100_000, 0.05)
    assert "- One, slow: 4 x, not 3 x: it is slow." in text
    assert "- absent: not measured; not installed." in text
    assert "100 000 samples" in text
    assert "Every target was reached" in page(ROWS[:1], machine(None), 1, 0.0)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1.2345, "1.23"), (123.4, "123"), (1234.5, "1230"), (2.54e-11, "2.54e-11")],
)
def test_numbers_have_three_digits(value, text):
    assert number(value) == text


def test_durations_are_in_their_natural_unit():
    assert [duration(t) for t in (1.6, 0.00178, 4e-6)] == ["1.6 s", "1.78 ms", "4 us"]


# --- the guard ----------------------------------------------------------------------------------


def test_guard_is_content_where_the_option_decides():
    assert verdict(FAST, SLOW) == []


def test_guard_says_that_the_option_is_no_longer_understood():
    *slow, effect = verdict(SLOW, SLOW)
    assert [sentence.split(" takes ")[0] for sentence in slow] == [
        "cost + gradient",
        "generic gradient",
    ]
    assert effect.startswith("the loop option has no effect (1.0 times")
    assert effect.endswith("XLA no longer understands it")


def test_guard_says_that_the_option_is_no_longer_needed():
    (effect,) = verdict(FAST, FAST)
    assert "may not need it any more" in effect


def test_guard_notices_a_slow_pass():
    crawling = FAST | {"gyroscope filter": 20e-3}
    (sentence,) = verdict(crawling, SLOW)
    assert sentence.startswith("the gyroscope filter is only 2.0 times as fast as a plain")


def test_guard_notices_slow_products():
    assert slow_products({(9, 3): (1.8, 1.9)}) == []
    (sentence,) = slow_products({(9, 3): (1.8, 9.0)})
    assert sentence.startswith("the gradient of a linear filter of 9 states takes 9.0 times")


def test_guard_notices_slow_rows_and_gains_that_do_not_settle():
    assert slow_rows((1.4, 1.3)) == slow_settling(3.9) == []
    (sentence,) = slow_rows((1.4, 9.0))
    assert sentence.startswith(
        "the gradient of a linear filter of 9 states by compiled C takes 9.0"
    )
    (sentence,) = slow_settling(1.0)
    assert sentence.startswith("a likelihood is only 1.0 times as fast with constant gains")


@pytest.mark.parametrize(
    "given", ["", "--xla_foo=1", f"--xla_backend_extra_options=a=1,{LOOP_OPTION}=7"]
)
def test_loop_flags_keep_what_was_given(given):
    for whole, value in ((True, 10**9), (False, 1024)):
        flags = loop_flags(given, whole=whole)
        assert flags.count(LOOP_OPTION) == 1
        assert f"{LOOP_OPTION}={value}" in flags
        assert all(part in flags for part in given.replace(f",{LOOP_OPTION}=7", "").split())


def test_unscented_and_extended_filter_do_the_same_work(monkeypatch):
    monkeypatch.setattr(unscented, "SAMPLES", 200)
    inputs, noise = unscented.record(2), jnp.asarray(unscented.NOISE)
    found = {
        name: np.asarray(unscented.passed(filter, 2, noise, inputs))
        for name, filter in unscented.filters().items()
    }
    for name, estimates in found.items():
        apart = np.abs(estimates - found["extended"]).max()
        assert apart <= unscented.AGREED, name
