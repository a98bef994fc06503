"""What a tuned filter must be, and the sentence that says so."""

import dataclasses
import re

import numpy as np
import pytest

from tests.tuner.export_cases import provenance, tuned
from tuner.export import Quantity


def exactly(sentence):
    return f"^{re.escape(sentence)}$"


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("R", np.float32(1.0), "'R' is float32; give a float64 array"),
        ("R", np.ones(2, np.float32), "'R' is float32; give a float64 array"),
        ("R", np.arange(2), "'R' is int64; give a float64 array"),
        ("R", np.array([1j]), "'R' is complex128; give a float64 array"),
        ("R", True, "'R' is bool; give a float64 array"),
        ("R", "1.0", "'R' is <U3; give a float64 array"),
        ("R", None, "'R' is object; give a float64 array"),
        ("R", [[1.0], [1.0, 2.0]], "'R' has rows of different lengths; give a full array"),
        ("R", np.ones((1, 1, 1)), "'R' has 3 axes; give a number, vector or matrix"),
        ("R", np.ones((0, 2)), "'R' is empty; give at least one number"),
        ("R", np.array(np.nan), "'R' holds NaN or infinity; give finite numbers"),
        ("R", np.array([1.0, -np.inf]), "'R' holds NaN or infinity; give finite numbers"),
    ],
)
def test_values(name, value, sentence):
    with pytest.raises(ValueError, match=exactly(sentence)):
        Quantity(name, value, "")


@pytest.mark.parametrize(
    "name",
    ["", "1R", "_R", "R_", "R__2", "R-2", "R 2", "Ω", "R\n", "R" * 26, 3, None, "\ud800", "*/"],
)
def test_names_must_be_parts_of_names_in_c(name):
    for make in (
        lambda: Quantity(name, np.array(1.0), ""),
        lambda: tuned(states=(name,)),
        lambda: tuned(name=name if name != "R" * 26 else "R" * 32),
    ):
        with pytest.raises(ValueError, match=r"^the .* is named .*; give at most \d\d letters"):
            make()


@pytest.mark.parametrize(
    "name",
    ["dt", "Real", "states", "STATE", "state_x", "R_f", "P0_rows", "tuner_meta", "tuner_json"],
)
def test_names_that_the_formats_form_themselves_are_taken(name):
    sentence = f"{name!r} is a name that C headers or MAT files need themselves; rename it"
    with pytest.raises(ValueError, match=exactly(sentence)):
        Quantity(name, np.array(1.0), "")


_SECONDS = "give a positive number of seconds, or 0 for a continuous model"


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"dt": 0.0}, f"the sample time is 0.0; {_SECONDS}"),
        ({"dt": -1}, f"the sample time is -1; {_SECONDS}"),
        ({"dt": np.nan}, f"the sample time is nan; {_SECONDS}"),
        ({"dt": np.inf}, f"the sample time is inf; {_SECONDS}"),
        ({"dt": "1"}, f"the sample time is '1'; {_SECONDS}"),
        ({"convention": "z"}, "the convention is 'z'; give 'discrete' or 'continuous'"),
        ({"convention": []}, "the convention is []; give 'discrete' or 'continuous'"),
        ({"filter": 3}, "the name of the filter's class is 3; give text"),
        ({"quantities": ()}, "there are no quantities; give at least one"),
        (
            {"quantities": [Quantity(name, np.array(1.0), "") for name in "qQ"]},
            "the quantity 'q' comes twice; rename one",
        ),
        ({"states": ("a", "A")}, "the state 'a' comes twice; rename one"),
    ],
)
def test_fields(changed, sentence):
    with pytest.raises(ValueError, match=exactly(sentence)):
        tuned(**changed)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"study": None}, "the study is None; give text"),
        ({"log_name": b"x"}, "the log_name is b'x'; give text"),
        ({"status": "\ud800"}, "the status holds half a character; give whole Unicode text"),
        ({"seed": 1.0}, "the seed is 1.0; give a whole number below 2^63"),
        ({"seed": True}, "the seed is True; give a whole number below 2^63"),
        ({"seed": 2**63}, f"the seed is {2**63}; give a whole number below 2^63"),
        ({"versions": ("ab",)}, "'ab' is not a version; give pairs of a name and a version"),
        ({"versions": (("a", 1),)}, "the version of 'a' is 1; give text"),
        ({"versions": (("a", ""), ("a", ""))}, "the version 'a' comes twice; rename one"),
    ],
)
def test_provenance(changed, sentence):
    with pytest.raises(ValueError, match=exactly(sentence)):
        provenance(**changed)


@pytest.mark.parametrize("field", ["unit", "meaning"])
def test_texts(field):
    good = Quantity("R", np.array(1.0), "")
    with pytest.raises(ValueError, match=f"^the {field} of 'R' is 3; give text$"):
        dataclasses.replace(good, **{field: 3})


def test_the_value_is_a_copy():
    given = np.eye(2)
    quantity = Quantity("P0", given, "")
    given[0, 0] = 5.0
    assert quantity.value[0, 0] == 1.0


def test_a_whole_number_of_seconds_becomes_a_float():
    assert repr(tuned(dt=np.float64(2)).dt) == "2.0"
    assert repr(tuned(dt=2).dt) == "2.0"
