"""tuner init, and what of it the command line tunes."""

from pathlib import Path

import pytest

from tuner.model import read_model, template


def test_a_model_is_printed(cli):
    code, out, err = cli("init", "--kind", "robot")
    assert (code, out, err) == (0, template("robot"), "")


@pytest.mark.usefixtures("here")
def test_a_model_is_written_once(cli):
    code, out, err = cli("init", "-o", "mine.toml")
    assert (code, out) == (0, "")
    assert err.startswith("wrote mine.toml; change it to your model, then tuner fit LOG --model")
    assert read_model(Path("mine.toml"))["name"] == "mine"
    Path("mine.toml").write_text("# changed")
    code, _, err = cli("init", "-o", "mine.toml")
    assert code == 2
    assert "mine.toml exists; give another name, or replace it with --force" in err
    assert Path("mine.toml").read_text() == "# changed"
    assert cli("init", "-o", "mine.toml", "--force")[0] == 0
    assert Path("mine.toml").read_text() == template("level")


def test_an_unknown_kind_has_near_ones(cli):
    code, _, err = cli("init", "--kind", "robt")
    assert code == 2
    assert "unknown kind of model 'robt'; did you mean robot?" in err


def test_a_wrong_model_is_told_before_a_log_is_opened(cli, here):
    (here / "mine.toml").write_text(template("level").replace('"level", R', '"levl", R'))
    code, out, err = cli("fit", "log.csv", "--model", "mine.toml", "--map", "z=x")
    assert (code, out) == (2, "")
    assert "mine.toml: line 12, measurements.z.h: unknown name 'levl'; did you mean level?" in err
    assert [path.name for path in here.iterdir()] == ["mine.toml"]


def test_a_model_is_listed_as_a_filter_is(cli, here):
    (here / "mine.toml").write_text(template("pendulum"))
    code, out, _ = cli("list", "filters", "mine.toml")
    assert code == 0
    assert "Angle and rate of a pendulum" in out
    assert "density of what pushes it" in out
