"""Things found by entry points: near names, rivals, and packages that are broken."""

import sys
from importlib.metadata import EntryPoint
from types import ModuleType

import pytest

from tuner import catalogue
from tuner.catalogue import find, names

GROUPS = ("tuner.studies", "tuner.filters", "tuner.objectives")


@pytest.fixture
def offered(monkeypatch):
    """Make entry points known, name and value, in place of those that are installed."""

    def offer(*pairs):
        points = [EntryPoint(name, value, "group") for name, value in pairs]
        monkeypatch.setattr(catalogue, "entry_points", lambda group: points)

    return offer


@pytest.fixture
def module(monkeypatch):
    """A module of another package."""
    made = ModuleType("another_package")
    monkeypatch.setitem(sys.modules, made.__name__, made)
    return made


@pytest.mark.parametrize("group", GROUPS)
def test_ours_are_found_in_every_group(group):
    found = names(group)
    assert found == sorted(set(found))
    assert {"kownacki2010", "madgwick", "likelihood"} & set(found)


def test_names_import_nothing(offered):
    offered(("b", "no_such_package:B"), ("a", "no_such_package:A"))
    assert names("tuner.filters") == ["a", "b"]


def test_another_package_adds_one(offered, module):
    module.Thing = object()
    offered(("thing", "another_package:Thing"))
    for group in GROUPS:
        assert find(group, "thing") is module.Thing


@pytest.mark.parametrize(
    ("group", "word"), [*zip(GROUPS, ("study", "filter", "objective"), strict=True)]
)
def test_an_unknown_name_is_refused_with_near_ones(offered, group, word):
    offered(("mahony", "m:M"), ("ins", "i:I"))
    with pytest.raises(ValueError, match=f"^unknown {word} 'mahonny'; did you mean mahony"):
        find(group, "mahonny")


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("no_such_package:Thing", "ModuleNotFoundError: No module named 'no_such_package'"),
        ("another_package:Thing", "AttributeError: .*another_package.* has no attribute 'Thing'"),
    ],
)
def test_what_cannot_be_imported_is_told_in_one_sentence(offered, module, value, why):
    offered(("thing", value))
    with pytest.raises(ValueError, match=rf"^the filter 'thing' .* from {value} \({why}\); mend"):
        find("tuner.filters", "thing")


def test_a_module_that_breaks_off_is_told_in_one_line(offered, tmp_path, monkeypatch):
    (tmp_path / "breaking_off.py").write_text("raise RuntimeError('first\\nsecond')")
    monkeypatch.syspath_prepend(tmp_path)
    offered(("thing", "breaking_off:Thing"))
    with pytest.raises(ValueError, match=r"\(RuntimeError: first second\)"):
        find("tuner.objectives", "thing")


def test_one_name_for_two_things_is_refused(offered, module):
    module.A = module.B = object()
    offered(("thing", "another_package:A"), ("thing", "another_package:B"))
    with pytest.raises(ValueError, match="'thing' is both another_package:A of .* uninstall one$"):
        find("tuner.filters", "thing")
    # the metadata of one package may be found twice
    offered(("thing", "another_package:A"), ("thing", "another_package:A"))
    assert find("tuner.filters", "thing") is module.A
