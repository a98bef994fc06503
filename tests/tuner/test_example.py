"""The simulated logs hold what their first lines say."""

from pathlib import Path

import numpy as np
import pytest

import tuner
from tuner.cli import invoke
from tuner.data.example import KINDS, example


def numbers(kind):
    lines = example(kind).splitlines()[1:]
    return np.genfromtxt(lines, delimiter=",", names=True)


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_the_same_at_every_call_and_has_one_row_for_every_time(kind):
    assert example(kind) == example(kind)
    assert example(kind).startswith("# ")
    assert "simulated" in example(kind).splitlines()[0]
    assert len(numbers(kind)) >= 2000


def test_the_level_has_the_noise_that_it_names():
    z = numbers("level")
    assert np.var(np.diff(z["reference"])) == pytest.approx(0.16, rel=0.1)
    assert np.var(z["pressure"] - z["reference"]) == pytest.approx(9.0, rel=0.1)


def test_the_accelerometer_has_the_noise_that_it_names():
    z = numbers("vario")
    # The motion's part of the second differences is some 1e-4 of the noise's.
    assert np.mean(np.diff(z["acc_up"], 2) ** 2) == pytest.approx(6 * 0.3**2, rel=0.03)
    assert np.isnan(z["height"]).mean() == pytest.approx(0.8)


def test_the_tracks_have_the_noise_that_they_name():
    z = numbers("tracks")
    third, scale = [], []
    for track in range(10):
        part = z[z["track"] == track]
        metres = 111_320 * (part["lat"] - 48.1)
        third.append(np.diff(metres, 3))
        s = part["accuracy"] ** 2
        scale.append(s[3:] + 9 * s[2:-1] + 9 * s[1:-2] + s[:-3])
    # The position's third differences: noise with (1, 3, 3, 1), and the walk of the velocity.
    least, walk = np.concatenate(scale), 0.2
    assert np.mean(np.concatenate(third) ** 2) == pytest.approx(least.mean() + walk, rel=0.1)


def test_a_fit_finds_the_noise_within_its_limits(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert invoke(["example", "level"]) == 0
    record = tuner.read_record("level.csv", ["z=pressure:Pa"])
    found = tuner.fit("local-level", record, starts=1, hold_out=False).solution.parameters
    for name, known in (("q", 1.6), ("R", 9.0)):
        low, high = found[name].interval
        assert low < known < high


def test_nothing_is_replaced_unasked(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("vario.csv").write_text("mine")
    assert invoke(["example", "vario"]) == 2
    assert Path("vario.csv").read_text() == "mine"
    assert invoke(["example", "vario", "--force"]) == 0
    assert invoke(["example", "vairo"]) == 2
    assert "did you mean vario" in capfd.readouterr().err
    assert invoke(["example", "rest", "-o", "-"]) == 0
    assert capfd.readouterr().out == example("rest")
