"""Names that no C can have, and filters that no C is written for."""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest
from jax import Array

from tests.tuner.code.compiled import COMPILERS, compile_in, needed, ran
from tests.tuner.export_cases import tuned
from tuner.code.document import files
from tuner.code.fields import fields_of
from tuner.code.form import form, write_form
from tuner.code.names import TAKEN, identifier, in_comment


class Names(NamedTuple):
    """Names that Python allows.

    Attributes:
        int: a number */ #error
        double: a number /* \\
        σ: what ??/
    """

    int: Array
    double: Array
    σ: Array  # noqa: PLC2401
    sigma: Array
    state: Array
    isnan: Array
    NAN: Array
    y0: Array


@dataclass(frozen=True)
class Nasty:
    """A filter with such names, inside and out, and a line of nasty text."""

    def init(self, params):
        zero = jnp.zeros((), params.int.dtype)
        return {"while": zero, "for": jnp.zeros(2, params.int.dtype)}

    def step(self, params, state, inputs):
        volatile = state["while"] * params.int + inputs.double
        sinf = jnp.sin(volatile) + jnp.sqrt(jnp.abs(volatile))
        FP_NAN = sinf * volatile + state["for"][0]
        sin = jnp.sin(FP_NAN) + state["for"].sum()  # */ ??/ \\
        σ = sin * inputs.σ + inputs.sigma  # noqa: PLC2401
        delete = σ * len("*/ ??/")
        return {"while": delete, "for": jnp.stack([sin, σ])}, Names(*[delete * k for k in range(8)])


def nasty(k):
    return Names(*(np.full(60, 0.1 * k + j) * np.cos(np.arange(60.0)) for j in range(8)))


@pytest.mark.parametrize("compiler", COMPILERS)
def test_nasty_names_are_names_of_c(tmp_path, compiler):
    needed(compiler)
    params = Names(*map(jnp.asarray, np.linspace(0.1, 0.9, 8)))
    found = form("int", Nasty(), params, nasty(1), "float", tunable=True)
    text = files(tuned(name="int"), "int.h", [found])
    whole = text.header + text.source + text.selftest
    assert whole.isascii()
    assert "??" not in text.source
    (tmp_path / "int.h").write_text(text.header)
    (tmp_path / "int.c").write_text(text.source)
    (tmp_path / "int_selftest.c").write_text(text.selftest)
    files_ = ("int.c", "int_selftest.c", "-o", "a", "-lm")
    compile_in(tmp_path, compiler, "-DSELFTEST_MAIN", *files_)
    assert ran(tmp_path, "./a").returncode == 0
    names = [field.name for field in found.implementation.inputs]
    assert names == ["int_", "double_", "sigma", "sigma_2", "state_", "isnan_", "NAN_", "y0_"]


@pytest.mark.parametrize(
    "name", ["int", "\u03c3", "Ж", "9", "*/", "??=", "a b", "", "_x", "x" * 90]
)
def test_identifiers_are_of_ascii_and_no_words(name):
    found = identifier(name)
    assert found.isascii()
    assert found.isidentifier()
    assert found not in TAKEN
    assert len(found) < 63
    assert identifier(name, {found}) != found


def test_comments_end_where_they_should():
    nasty = "*/*/ /* ??/ **/ \\ \n */ é °"
    assert "*/" not in in_comment(nasty)
    assert "??" not in in_comment(nasty)
    assert in_comment(nasty).isascii()


@dataclass(frozen=True)
class Large:
    """A filter with too many numbers."""

    size: int

    def init(self, params):
        return jnp.zeros(self.size)

    def step(self, params, state, inputs):
        return state + inputs, state[0]


def test_a_state_of_ten_thousand_numbers_is_refused():
    sample = np.zeros(())
    with pytest.raises(ValueError, match="the state of Large is 10000 numbers, and C is written"):
        write_form("large", Large(10_000), (), sample, "double", keep=None)


def test_a_larger_state_takes_loops():
    code = write_form("large", Large(900), (), np.zeros(()), "double", keep=None)
    assert any("for (int" in line for line in code.definitions)
    assert len(code.definitions) < 60


def test_fields_of_one_name_are_told_apart():
    fields = fields_of(None, "inputs", {"a": {"x": np.zeros(2)}, "b": {"x": np.zeros(3)}})
    assert [(field.name, field.size) for field in fields] == [("a_x", 2), ("b_x", 3)]
