"""Fits side by side."""

import json
from pathlib import Path

import pytest

from tuner.cli import invoke


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """A folder with two fits of one log and one of another."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("fits"))
        assert invoke(["example", "level"]) == 0
        text = Path("level.csv").read_text().splitlines()
        Path("short.csv").write_text("\n".join(text[:300]))
        quick = ["--filter", "local-level", "--map", "z=pressure:Pa", "--starts", "1"]
        assert invoke(["fit", "short.csv", *quick, "--out", "both"]) == 0
        fixed = ["--fix", "R=9", "--no-hold-out", "--out", "fixed"]
        assert invoke(["fit", "short.csv", *quick, *fixed]) == 0
        Path("other.csv").write_text("\n".join(text[:2] + text[400:600]))
        assert invoke(["fit", "other.csv", *quick, "--no-hold-out", "--out", "other"]) == 0
        yield


def cells(text):
    lines = [line.strip("|").split("|") for line in text.splitlines() if "---" not in line]
    return {line[0].strip(): [cell.strip() for cell in line[1:]] for line in lines}


def test_what_they_are_worth_and_what_they_found(desk, capfd):
    assert invoke(["compare", "both", "fixed", "--md"]) == 0
    out, err = capfd.readouterr()
    found = cells(out)
    assert found[""] == ["both", "fixed"]
    assert found["filter"] == ["LocalLevel", "LocalLevel"]
    assert found["status"] == ["converged", "converged"]
    results = [json.loads(Path(run, "result.json").read_text()) for run in ("both", "fixed")]
    assert found["on all data"] == [f"{r['fit']['tuned']:.6g} Pa" for r in results]
    held = results[0]["fit"]["held_out"]
    assert found["there, tuned"] == [f"{held['tuned']:.6g} Pa", "-"]
    assert found["R"][1] == "9 Pa^2"
    q = results[1]["solutions"][0]["parameters"]["q"]
    assert found["q"][1].startswith(f"{q['value']:.5g} [{q['interval'][0]:.3g}, ")
    assert int(found["operations a sample"][0]) > 5
    assert "different recordings" not in err


def test_fits_of_different_recordings_are_told(desk, capfd):
    assert invoke(["compare", "both", "other"]) == 0
    assert "different recordings" in capfd.readouterr().err


def test_as_json(desk, capfd):
    assert invoke(["compare", "both", "--json"]) == 0
    (run,) = json.loads(capfd.readouterr().out)["runs"]
    assert run["rows"] == []
    assert run["fit"]["filter"] == "LocalLevel"
