"""A fit behind a gate: what is refused, what is said of it, and what is no gate."""

import json

import numpy as np
import pytest

import tuner
from tests.tuner.fit_cases import level, write


def spoiled(seed=5):
    """A level of which one number in twenty is anything."""
    columns = level(seed=seed)
    draw = np.random.default_rng(seed + 1)
    wrong = draw.random(400) < 0.05
    wrong[:3] = False
    columns["z"] = np.where(wrong, draw.uniform(-80, 80, 400), columns["z"])
    return columns, wrong


def fitted(columns, **more):
    record = tuner.Record.of({"z": columns["z"]}, rate_hz=1.0)
    return tuner.fit("local-level", record, hold_out=False, **{"starts": 2} | more)


def values(fit):
    return np.array([float(fit.solution.parameters[name].value) for name in ("q", "R")])


def test_what_is_left_is_as_by_hand():
    columns, wrong = spoiled()
    fit = fitted(columns, options={"gate": 4})
    by_hand = fitted({"z": np.where(wrong, np.nan, columns["z"])})
    np.testing.assert_allclose(values(fit), values(by_hand), rtol=0.1)
    refused = fit.judged.refused
    assert abs(refused.refused - wrong.sum()) <= 2  # one beside the level may pass
    assert f"{refused.refused} of {refused.numbers} numbers refused" in fit.summary()
    assert fit.outputs.refused.sum() == refused.refused


def test_heavy_tails_move_little():
    columns, wrong = spoiled()
    fit = fitted(columns, options={"student": 4})
    by_hand = fitted({"z": np.where(wrong, np.nan, columns["z"])})
    plain = fitted(columns)
    factors = values(fit) / values(by_hand)
    assert (factors > 1).all()
    assert (factors < 1.6).all()  # t counts what is wrong as its tails, which widens them
    assert values(plain)[1] > 50 * values(by_hand)[1]
    assert "numbers taken at less than half their weight" in fit.summary()
    assert abs(fit.judged.refused.refused - wrong.sum()) <= 3


def test_units_and_starts_do_not_matter():
    columns, _ = spoiled()
    fit = fitted(columns, options={"gate": 4})
    small = fitted({"z": 1e-6 * columns["z"]}, options={"gate": 4})
    other = fitted(columns, options={"gate": 4}, start={"q": 30.0, "R": 1e3})
    np.testing.assert_allclose(values(small), 1e-12 * values(fit), rtol=1e-5)
    np.testing.assert_allclose(values(other), values(fit), rtol=1e-5)


def test_recordings_side_by_side_are_gated_each_by_itself():
    records = []
    for seed in (5, 6):
        columns, _ = spoiled(seed)
        records.append(tuner.Record.of({"z": columns["z"]}, rate_hz=1.0))
    fit = tuner.fit("local-level", records, options={"gate": 4}, starts=1, hold_out=False)
    assert fit.outputs.refused.shape == (400, 2, 1)
    assert (fit.outputs.refused.sum(axis=(0, 2)) > 10).all()


def test_the_command_line_counts_what_is_refused(cli, here):
    columns, wrong = spoiled()
    write(here / "level.csv", columns)
    words = ("--filter", "local-level", "--map", "z=z", "--set", "gate=4", "--starts", 1)
    code, out, err = cli("fit", "level.csv", *words, "--no-hold-out", "--out", "out", "--jobs", 1)
    assert code == 0, (out, err)
    count = int(np.load(here / "out" / "outputs.npz")["refused"].sum())
    assert abs(count - wrong.sum()) <= 2
    lines = json.loads((here / "out" / "result.json").read_text())["fit"]["lines"]
    assert f"{count} of 399 numbers refused" in lines[2]


def test_a_gate_that_refuses_everything_is_an_error(cli, here):
    draw = np.random.default_rng(1)
    z = np.cumsum(draw.standard_normal(300))
    write(here / "level.csv", {"t": np.arange(300.0), "z": z})
    held = ("--fix", "R=1e-6", "--bound", "q=1e-9..1e-6", "--starts", 1, "--no-hold-out")
    words = ("--filter", "local-level", "--map", "z=z", "--set", "gate=3", *held)
    code, _, err = cli("fit", "level.csv", *words, "--out", "out", "--jobs", 1)
    assert code == 2
    assert "measured numbers lie outside the gate" in err
    assert "give a wider one, as in --set gate=6" in err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"gate": 0.5}, "refuses more than a third of what is right"),
        ({"gate": "wide"}, "gate is 'wide'; give a number of deviations"),
        ({"gate": True}, "gate is True"),
        ({"gate": 4, "patience": 0}, "give 1 or more"),
        ({"gate": 4, "patience": 2.5}, "give a whole number of samples"),
        ({"student": 0.1}, "give 1 or more"),
        ({"student": "t"}, "student is 't'; give a number of degrees of freedom"),
        ({"student": 4, "gate": 4}, "guard against the same outliers"),
        ({"patience": 3}, "give --set gate=4 with it"),
        ({"gat": 4}, "did you mean gate"),
    ],
)
def test_what_is_no_gate_is_refused(options, words):
    with pytest.raises(ValueError, match=words):
        fitted(level(samples=60), options=options)


def test_a_filter_without_a_variance_has_no_gate():
    record = tuner.Record.of({"z": np.arange(60.0)}, rate_hz=10.0)
    with pytest.raises(ValueError, match="AlphaBeta outputs no variance"):
        tuner.fit("alpha-beta", record, options={"gate": 4})
