"""A fit in a study.toml: written by hand, checked as a whole, run to the same numbers."""

import json
import time

import numpy as np
import pytest

from tests.tuner import fit_cases as cases
from tests.tuner.helpers import snapshot

HAND = """
study = "fit"
seed = 7

[settings]
filter = "local-level"
start = { q = 0.5 }
bound = { R = [0.01, 100.0] }
options = { gate = 6 }
objective = "likelihood"
solver = "l-bfgs-b"
starts = 2
held_out = "time"

[log]
files = ["data/level.csv"]
map = ["z=z:m"]
time = "t"
from_s = 10.0
to_s = 190.0
"""


@pytest.fixture
def folder(here):
    (here / "data").mkdir()
    columns = cases.level(samples=200)
    cases.write(here / "data" / "level.csv", {"t": columns["t"], "z": columns["z"]})
    (here / "my_fit.toml").write_text(HAND)
    return here


def solved(text):
    return json.loads(text)["solutions"][0]["parameters"]


def test_by_hand_it_is_what_the_command_does(cli, folder):
    code, out, err = cli("run", "my_fit.toml", "--dry-run")
    assert code == 0, err
    assert "would solve local_level over ln q, ln R by l-bfgs-b" in out
    assert not (folder / "runs").exists()
    code, by_hand, err = cli("run", "my_fit.toml", "--json", "--out", "one")
    assert code in (0, 1), err
    words = (
        *("--filter", "local-level", "--map", "z=z:m", "--time", "t", "--from", 10, "--to", 190),
        *("--start", "q=0.5", "--bound", "R=0.01..100", "--set", "gate=6", "--starts", 2),
        *("--set", "held_out=time", "--objective", "likelihood", "--seed", 7, "--json"),
    )
    code, told, err = cli("fit", "data/level.csv", *words, "--out", "two")
    assert code in (0, 1), err
    assert solved(by_hand) == solved(told)
    # What it wrote down is complete, and runs again to the same numbers.
    (folder / "one" / "level.csv").write_bytes((folder / "data" / "level.csv").read_bytes())
    code, again, err = cli("run", "one/study.toml", "--json", "--out", "three")
    assert code in (0, 1), err
    assert solved(again) == solved(by_hand)


def test_all_that_is_wrong_is_told_at_once(cli, folder):
    text = HAND.replace("local-level", "local-level").replace("[log]", "[log]\nrat_hz = 1.0")
    text = text.replace("seed = 7", "seed = -1").replace("starts = 2", "starts = 0\nstrats = 1")
    (folder / "bad.toml").write_text(text)
    before = snapshot(folder)
    code, out, err = cli("run", "bad.toml")
    assert (code, out, err.count("\n")) == (2, "", 1)
    for words in (
        "bad.toml is not a study.toml",
        "seed: must be at least 0",
        "unknown entry 'rat_hz'; did you mean rate_hz?",
        "unknown setting 'strats'; did you mean",
        "setting starts: must be at least 1",
    ):
        assert words in err
    names = HAND.replace("q = 0.5", "qq = 0.5, R = 1.0").replace("gate", "gait")
    names = names.replace('"likelihood"', '"likelyhood"').replace('"l-bfgs-b"', '"bfgs"')
    (folder / "bad.toml").write_text(names.replace("z=z:m", "y=z:m"))
    code, out, err = cli("run", "bad.toml")
    assert (code, out, err.count("\n")) == (2, "", 1)
    for words in (
        "bad.toml: unknown solver 'bfgs'; did you mean l-bfgs-b?",
        "unknown objective 'likelyhood'; did you mean likelihood?",
        "start: unknown parameter 'qq'; did you mean q?",
        "options: unknown option of local-level 'gait'; did you mean gate?",
        "log.map: unknown channel 'y'",
    ):
        assert words in err
    (folder / "bad.toml").write_text(HAND.replace("local-level", "local-levle"))
    assert "unknown filter 'local-levle'; did you mean local-level?" in cli("run", "bad.toml")[2]
    (folder / "bad.toml").write_text(HAND.replace('filter = "local-level"\n', ""))
    assert "and there is none; give one of them" in cli("run", "bad.toml")[2]
    assert cli("run", "bad.toml", "--filter", "local-level", "--dry-run")[0] == 0
    assert snapshot(folder).keys() == {*before}


@pytest.mark.parametrize("place", ["/etc/passwd", "../level.csv", "data/../../level.csv"])
def test_no_log_outside_the_folder(cli, folder, place):
    (folder / "data" / "my.toml").write_text(HAND.replace("data/level.csv", place))
    code, out, err = cli("run", "data/my.toml")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert f"the log {place} of data/my.toml leads out of its folder" in err
    assert cli("run", "data/my.toml", "--log", "data/level.csv", "--dry-run")[0] == 0


def test_a_log_lies_beside_its_recipe_first(cli, folder):
    other = cases.level(seed=9, samples=100)
    cases.write(folder / "level.csv", {"t": other["t"], "z": other["z"]})
    (folder / "data" / "my.toml").write_text(HAND.replace("data/level.csv", "level.csv"))
    code, out, err = cli("run", "data/my.toml", "--dry-run")
    assert code == 0, err
    assert "181 samples" in out  # of 200, from 10 to 190 s


def test_a_model_may_stand_in_it(cli, folder):
    model = """
[settings.model]
parameters = ["q", "R"]
states = ["level"]
measurements = ["z"]
[settings.model.model]
A = 0
Q = "q"
C = 1
R = "R"
"""
    text = HAND.replace('filter = "local-level"\n', "").replace("options = { gate = 6 }\n", "")
    text = text.replace("bound = { R = [0.01, 100.0] }\n", "").replace("start = { q = 0.5 }\n", "")
    (folder / "my.toml").write_text(text.replace("\n[log]", f"{model}\n[log]"))
    code, found, err = cli("run", "my.toml", "--json", "--out", "one")
    assert code in (0, 1), err
    code, same, err = cli(
        *("fit", "data/level.csv", "--filter", "local-level", "--map", "z=z:m", "--time", "t"),
        *("--from", 10, "--to", 190, "--starts", 2, "--json", "--out", "two"),
    )
    ours, theirs = (
        np.array([solved(text)[name]["value"] for name in ("q", "R")]) for text in (found, same)
    )
    # Two searches of the same likelihood.
    np.testing.assert_allclose(ours, theirs, rtol=1e-3)
    (folder / "my.toml").write_text(text.replace("\n[log]", f"{model}nois = 1\n[log]"))
    code, _, err = cli("run", "my.toml")
    assert (code, err.count("\n")) == (2, 1)
    assert "nois" in err


def test_a_huge_or_deep_file_is_refused(cli, here):
    (here / "deep.toml").write_text("study = 'fit'\na = " + "[" * 50_000)
    (here / "huge.toml").write_text("#" * 10_000_001)
    for name in ("deep", "huge"):
        code, out, err = cli("run", f"{name}.toml")
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert f"{name}.toml is not a study.toml" in err


def test_very_many_faults_are_told_by_the_first(cli, folder):
    many = "\n".join(f"k{i} = {i}" for i in range(200_000))
    (folder / "many.toml").write_text(f"{many}\n{HAND}")
    begun = time.perf_counter()
    code, out, err = cli("run", "many.toml")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.count("unknown entry") == 12
    assert err.rstrip().endswith("; and more")
    assert time.perf_counter() - begun < 20  # some 2 s; a shared machine may be slow
