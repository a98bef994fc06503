"""Parts of recordings by --from and --to: in Python, by command line, and run again."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

import tuner
from tuner.data.cut import cut
from tuner.data.merge import timeline


def record(**changes):
    t = np.array([0.0, 0.1, 0.2, 0.3, 0.9, 1.0, 1.1])
    return tuner.Record.of({"z": np.arange(7.0)}, times=t, truth={"x": np.arange(7.0)}, **changes)


def test_times_go_on_counting_and_gaps_outside_are_forgotten():
    assert timeline(record()).rate_hz is None
    part = cut(record(), to_s=0.3)
    assert part.channels["z"].values.tolist() == [0, 1, 2, 3]
    assert timeline(part).rate_hz == pytest.approx(10.0)
    late = cut(record(), from_s=0.9)
    assert late.truth["x"].values.tolist() == [4, 5, 6]
    assert timeline(late).times[0] == pytest.approx(0.9)
    assert late.notes == ("only the part from 0.9 s",)
    assert late.sources[0].samples == 3
    assert cut(record()).channels["z"].values.size == 7


def test_a_time_with_fewer_digits_means_the_sample_beside_it():
    whole = tuner.Record.of({"z": np.arange(100.0)}, rate_hz=3.0)
    assert cut(whole, from_s=0.3333333).channels["z"].values[0] == 1


@pytest.mark.parametrize(
    ("between", "match"),
    [
        ((0.5, 0.2), "--from 0.5 is not before --to 0.2"),
        ((0.31, 0.8), "was measured from 0 s to 1.1 s, and --from, --to leave 0 samples"),
        ((np.nan, None), "--from is nan s"),
    ],
)
def test_parts_that_are_none(between, match):
    with pytest.raises(ValueError, match=match):
        cut(record(), *between)


def test_channels_of_one_clock_share_it_and_are_described_once():
    both = tuner.Record.of({"a": np.arange(20.0), "b": np.arange(20.0)}, rate_hz=10.0)
    told = "\n".join(cut(both, from_s=0.5, to_s=1.5).describe())
    assert told.count("time of") <= 1
    assert "11 samples" in told


def test_by_command_line_and_again_from_its_file(cli, here):
    rows = np.random.default_rng(0).standard_normal(600)
    lines = [f"{k / 10:.1f},{value:.4f}" for k, value in enumerate(rows)]
    Path("level.csv").write_text("\n".join(["t,z", *lines]))
    words = ["level.csv", "--filter", "local-level", "--map", "z=z:m", "--starts", 1]
    code, out, err = cli(
        "fit", *words, "--no-hold-out", "--from", 10, "--to", 30, "--json", "--out", "o"
    )
    assert code in (0, 1), err
    assert json.loads(out)["log"]["samples"] == 201
    log = tomllib.loads(Path("o/study.toml").read_text())["log"]
    assert (log["from_s"], log["to_s"]) == (10.0, 30.0)
    _, _, err = cli("run", "o/study.toml", "--dry-run")
    assert "only the part from 10 s to 30 s" in err
    code, _, err = cli("run", "design", "--from", 3)
    assert code == 2


def test_without_a_log_they_are_refused(cli):
    code, _, err = cli("run", "kownacki2010", "--to", 3)
    assert code == 2
    assert "--to says how to read a log" in err
