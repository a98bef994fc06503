"""tuner list: what is installed, and the facts of a filter in words, JSON and Markdown."""

import json
import re
import sys
import tomllib
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, Literal, NamedTuple

import pytest

from filters import Channel, Param
from tuner import catalogue
from tuner.cli.datasheet import as_json, datasheet_of, grids, page
from tuner.run.study import find_study, study_names

ROOT = Path(__file__).resolve().parents[2]


class Start(NamedTuple):
    x0: Annotated[Any, Param("m", "where it begins", (0.0, 0.5), shape=(2,))]


class Tuned(NamedTuple):
    tau: Annotated[Any, Param("s", "time constant", 1.0, 1e-3, 1e3, "trusts x", "trusts a|b")]
    start: Start | None = None


class Sample(NamedTuple):
    x: Annotated[Any, Channel("m", "measured place", ("x", "y"))]
    mag: Annotated[Any, Channel("", "field in any unit", ("x", "y", "z"))] = None


@dataclass(frozen=True)
class Toy:
    """Keeps a place.

    More words.
    """

    dt: float
    aid: Literal["none", "field"] = "none"
    order: Literal[1, 2] = 1

    params, inputs, states, outputs, derived = (
        Tuned,
        Sample,
        {"place": Channel("m", "where it is")},
        {"turn": Channel("rad", "its heading", kind="angle")},
        {"K": Param("", "steady gain", 0.5)},
    )


@pytest.fixture
def shelf(monkeypatch):
    """Filters of another package: one whole, one without facts, one broken."""
    module = ModuleType("shelf")
    module.Toy, module.Mute = Toy, type("Mute", (), {"__doc__": "Says nothing."})
    monkeypatch.setitem(sys.modules, "shelf", module)
    values = {"toy": "shelf:Toy", "mute": "shelf:Mute", "broken": "no_such_package:Filter"}
    points = [EntryPoint(name, value, "tuner.filters") for name, value in values.items()]
    monkeypatch.setattr(catalogue, "entry_points", lambda group: points)


def test_a_list_has_first_lines_and_says_what_is_broken(cli, shelf):
    code, out, err = cli("list", "filters")
    assert (code, err) == (0, "")
    broken, mute, toy = out.splitlines()
    assert broken.startswith("broken  the filter 'broken' of an unknown package cannot be loaded")
    assert (mute.split(None, 1), toy.split(None, 1)) == (
        ["mute", "Says nothing."],
        ["toy", "Keeps a place."],
    )
    assert json.loads(cli("list", "filters", "--json")[1])["filters"]["toy"] == "Keeps a place."


def test_facts_in_words(cli, shelf):
    code, out, err = cli("list", "filters", "toy")
    assert (code, err) == (0, "")
    for word in ("Keeps a place.", "time constant", "0.001 to 1000", "trusts x", "x y z", "steady"):
        assert word in out
    assert out.index("Inputs") < out.index("Parameters") < out.index("States") < out.index("Opt")


def test_facts_as_json(cli, shelf):
    found = json.loads(cli("list", "filters", "toy", "--json")[1])
    assert found["schema"] == "tuner.list/1"
    toy = found["filters"]["toy"]
    assert toy["class"].endswith("test_cli_listing.Toy")
    assert toy["about"] == "Keeps a place."
    assert list(toy["parameters"]) == ["tau", "x0"]
    assert toy["parameters"]["tau"] == {
        "unit": "s",
        "meaning": "time constant",
        "typical": 1.0,
        "low": 1e-3,
        "high": 1e3,
        "smaller": "trusts x",
        "larger": "trusts a|b",
        "shape": [],
        "channel": "",
        "sensor": "",
        "per_sample": False,
    }
    assert toy["parameters"]["x0"]["typical"] == [0.0, 0.5]
    assert {name: fact["optional"] for name, fact in toy["inputs"].items()} == {
        "x": False,
        "mag": True,
    }
    assert toy["outputs"]["turn"]["kind"] == "angle"
    assert toy["states"]["place"]["unit"] == "m"
    assert toy["derived"]["K"]["meaning"] == "steady gain"
    assert toy["options"] == {
        "aid": {"words": ["none", "field"], "default": "none"},
        "order": {"words": [1, 2], "default": 1},
    }


def test_facts_as_a_page(cli, shelf):
    code, out, _ = cli("list", "filters", "toy", "--md")
    assert code == 0
    assert out == page([datasheet_of("toy", Toy)])
    assert out.startswith("# Filters\n")
    assert "\n## toy\n" in out
    rows = [line for line in out.splitlines() if line.startswith("|")]
    parameters = rows.index("| parameters | unit | typical | range | meaning | smaller | larger |")
    assert rows[parameters + 1 : parameters + 4] == [
        "| --- | --- | --- | --- | --- | --- | --- |",
        r"| tau | s | 1 | 0.001 to 1000 | time constant | trusts x | trusts a\|b |",
        "| x0 | m | (0, 0.5) | not tuned | where it begins |  |  |",
    ]
    assert "| mag |  | x y z | number | field in any unit | no |" in rows
    assert "| aid | none, field | none |" in rows


def test_what_a_filter_does_not_have_makes_no_table():
    class Bare:
        """Has no options."""

        params, inputs = {"gain": Param("", "gain", 1.0)}, {"z": Channel("m", "place")}
        states, outputs = {"x": Channel("m", "place")}, {"x": Channel("m", "place")}

    sheet = datasheet_of("bare", Bare)
    assert [grid.title for grid in grids(sheet)] == ["Inputs", "Parameters", "States", "Outputs"]
    assert as_json(sheet)["options"] == {}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["filters", "toi"], "unknown filter 'toi'; did you mean toy"),
        (["filters", "mute"], "Mute declares no inputs; give the class an attribute inputs"),
        (["filters", "broken"], "'broken' of an unknown package cannot be loaded"),
        (["filters", "--md"], "'broken' of an unknown package cannot be loaded"),
        (["solvers", "ipopt"], "only filters have a page of facts; leave out 'ipopt'"),
        (["studies", "--md"], "only filters have a page of facts; leave out --md"),
        (["filters", "toy", "--md", "--json"], "give one of them"),
    ],
)
def test_what_has_no_facts_is_refused(cli, shelf, words, told):
    code, out, err = cli("list", *words)
    assert (code, out) == (2, "")
    assert told in err
    assert len(err.splitlines()) == 1


def test_the_page_in_docs_is_what_filters_declare():
    made = ROOT / "docs" / "filters.md"
    if not made.exists():
        pytest.skip("docs/filters.md is not made yet: tuner list filters --md > docs/filters.md")
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    ours = sorted(table["project"]["entry-points"]["tuner.filters"])
    sheets = [datasheet_of(name, catalogue.find("tuner.filters", name)) for name in ours]
    assert made.read_text(encoding="utf-8") == page(sheets)


def test_every_format_says_what_it_is(cli, monkeypatch):
    formats = json.loads(cli("list", "formats", "--json")[1])["formats"]
    assert all(re.fullmatch(r"\S+: \S.+", line) for line in formats.values()), formats
    monkeypatch.setenv("COLUMNS", "50")
    assert max(map(len, cli("list", "formats")[1].splitlines())) <= 50


@pytest.mark.parametrize(
    ("words", "end"),
    [
        (["fit"], "missing argument 'LOG'; see tuner fit --help"),
        (["fi"], "no such command 'fi'. Did you mean 'fit'? See tuner --help"),
    ],
)
def test_refused_usage_names_the_help_of_its_command(cli, words, end):
    assert cli(*words)[2].strip().endswith(end)


def test_every_study_says_how_long_it_takes():
    """A fit's time depends on the recording; every other study's is known."""
    for name in study_names():
        study = find_study(name)
        assert bool(study.takes) is (name != "fit"), name
