"""A fit behind a gate: what is rejected, what is said of it, and what is no gate."""

import json
from functools import cache

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


@cache
def behind_a_gate():
    """The fit of the spoiled level."""
    return fitted(spoiled()[0], options={"gate": 4})


@cache
def by_hand():
    """The fit of what is left of it where all that is wrong is taken out."""
    columns, wrong = spoiled()
    return fitted({"z": np.where(wrong, np.nan, columns["z"])})


def test_what_is_left_is_as_by_hand():
    _, wrong = spoiled()
    fit = behind_a_gate()
    np.testing.assert_allclose(values(fit), values(by_hand()), rtol=0.1)
    rejected = fit.judged.rejected
    assert abs(rejected.rejected - wrong.sum()) <= 2  # one beside the level may pass
    assert f"{rejected.rejected} of {rejected.numbers} numbers rejected" in fit.summary()
    assert fit.outputs.rejected.sum() == rejected.rejected


def test_heavy_tails_move_little():
    columns, wrong = spoiled()
    fit = fitted(columns, options={"student": 4})
    plain = fitted(columns)
    factors = values(fit) / values(by_hand())
    assert (factors > 1).all()
    assert (factors < 1.6).all()  # t counts what is wrong as its tails, which widens them
    assert values(plain)[1] > 50 * values(by_hand())[1]
    assert "numbers given less than half their weight" in fit.summary()
    assert abs(fit.judged.rejected.rejected - wrong.sum()) <= 3


def test_units_and_starts_do_not_matter():
    columns, _ = spoiled()
    fit = behind_a_gate()
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
    assert fit.outputs.rejected.shape == (400, 2, 1)
    assert (fit.outputs.rejected.sum(axis=(0, 2)) > 10).all()


def test_the_command_line_counts_what_is_rejected(cli, here):
    columns, wrong = spoiled()
    write(here / "level.csv", columns)
    words = ("--filter", "local-level", "--map", "z=z", "--set", "gate=4", "--starts", 1)
    code, out, err = cli("fit", "level.csv", *words, "--no-hold-out", "--out", "out", "--jobs", 1)
    assert code == 0, (out, err)
    count = int(np.load(here / "out" / "outputs.npz")["rejected"].sum())
    assert abs(count - wrong.sum()) <= 2
    found = json.loads((here / "out" / "result.json").read_text())["fit"]
    assert f"{count} of 399 numbers rejected" in found["lines"][2]
    assert (found["rejected"]["rejected"], found["rejected"]["numbers"]) == (count, 399)


def test_a_gate_that_rejects_everything_is_an_error(cli, here):
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
        ({"gate": 0.5}, "rejects more than a third of what is right"),
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


def simulated(noise, seed=3, n=1500):
    """A level that wanders from 5 to far, measured with a noise of one's own making."""
    draw = np.random.default_rng(seed)
    level = 40 + np.cumsum(0.5 * draw.standard_normal(n))
    return {"z": level + noise(draw, level)}


def test_noise_that_grows_with_the_level_is_found():
    columns = simulated(lambda draw, x: (0.5 + 0.1 * np.abs(x)) * draw.standard_normal(len(x)))
    fit = fitted(columns, options={"noise": "level"}, fix={"q": 0.25})
    found = {name: float(p.value) for name, p in fit.solution.parameters.items()}
    middle = np.abs(columns["z"]).mean()
    # Both numbers of one line; at the middle of the levels it is known well.
    assert found["R"] ** 0.5 + found["slope"] * middle == pytest.approx(
        0.5 + 0.1 * middle, rel=0.05
    )
    assert 0.07 < found["slope"] < 0.13
    plain = fitted(columns, fix={"q": 0.25})
    assert fit.solution.value < plain.solution.value - 0.01


def test_coloured_noise_is_found():
    def markov(draw, x, tau=8.0):
        phi, v = np.exp(-1 / tau), [0.0]
        for e in 3 * np.sqrt(1 - phi**2) * draw.standard_normal(len(x) - 1):
            v.append(phi * v[-1] + e)
        return np.array(v)

    columns = simulated(markov, n=800)
    fit = fitted(columns, options={"noise": "coloured"}, fix={"q": 0.25})
    found = {name: float(p.value) for name, p in fit.solution.parameters.items()}
    assert found["tau"] == pytest.approx(8.0, rel=0.5)
    assert found["R"] == pytest.approx(9.0, rel=0.5)
    assert fit.solution.parameters["tau"].unit == "s"
    white = fitted(columns, fix={"q": 0.25})
    assert fit.solution.value < white.solution.value - 0.1


def test_noise_by_a_channel_keeps_its_unit_and_a_gate_goes_around_it():
    draw = np.random.default_rng(4)
    sigma = draw.uniform(0.5, 4.0, 1500)
    columns = simulated(lambda draw, x: np.sqrt(4 + 0.5 * sigma**2) * draw.standard_normal(len(x)))
    columns["z"][10::50] += 300.0
    record = tuner.Record.of(
        columns | {"sigma": sigma}, rate_hz=1.0, units={"z": "m", "sigma": "m"}
    )
    fit = tuner.fit(
        "local-level", record, options={"noise": "sigma", "gate": 5}, starts=2, hold_out=False
    )
    found = {name: float(p.value) for name, p in fit.solution.parameters.items()}
    assert fit.solution.parameters["R"].unit == "m^2"
    # What a measurement's variance is on the average.
    mean = found["R"] + found["share"] * np.mean(sigma**2)
    assert mean == pytest.approx(4 + 0.5 * np.mean(sigma**2), rel=0.1)
    assert fit.judged.rejected.rejected == 30


def test_the_command_line_takes_a_list_of_noises(cli, here):
    columns = level(samples=200)
    write(here / "level.csv", columns)
    words = ("--filter", "local-level", "--map", "z=z", "--set", 'noise=["level", "coloured"]')
    more = ("--starts", 1, "--no-hold-out", "--out", "out", "--jobs", 1, "--dry-run")
    code, out, err = cli("fit", "level.csv", *words, *more)
    assert code == 0, (out, err)
    assert "tau" in out
    assert "slope" in out


@pytest.mark.parametrize("noise", ["pink", ["level", "pink"], [], 3])
def test_what_is_no_noise_is_refused(noise):
    with pytest.raises(ValueError, match="give coloured, sigma or level"):
        fitted(level(samples=60), options={"noise": noise})


def test_a_filter_without_deviations_has_one_noise():
    record = tuner.Record.of({"acc": np.zeros(60), "baro": np.ones(60)}, rate_hz=10.0)
    with pytest.raises(ValueError, match="its noise cannot follow the level"):
        tuner.fit("vertical", record, options={"noise": "level"})
