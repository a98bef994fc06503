"""The text of plain data is equal only for what computes the same, and nothing else has one."""

import sys
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import pytest

import filters.small_linalg
from filters import ConstantVelocity, Estimate, LocalLevel, Settling
from filters.small_linalg import matmul
from tests.tuner.model.documents import SHORT, made
from tuner.plain import NotPlainError, described


@dataclass(frozen=True)
class Foreign:
    gain: float


@dataclass(frozen=True)
class Steeper(LocalLevel):
    """A filter of the user's own, for its step is."""


class Pair(NamedTuple):
    first: float
    second: float


class Level(IntEnum):
    LOW = 1


UNLIKE = [
    1,
    1.0,
    True,
    None,
    "1",
    b"1",
    (1,),
    [1],
    ((1,), 2),
    (1, (2,)),
    (1, 2),
    {"a": 1},
    {"b": 1},
    {},
    (),
    0.1,
    float(np.nextafter(0.1, 1.0)),
    float("nan"),
    float("inf"),
    0.0,
    -0.0,
    np.ones(2),
    np.ones((2, 1)),
    np.ones(2, np.float32),
    np.array([1.0, 1.0 + 2**-52]),
    np.bool(True),
    "a', str 'b",
    ("a", "b"),
    matmul,
    partial(matmul, 1.0),
    LocalLevel,
    LocalLevel(dt=0.1),
    LocalLevel(dt=0.2),
    Settling(LocalLevel(dt=0.1)),
    ConstantVelocity(dt=0.1, axes="xy"),
    ConstantVelocity(dt=0.1, axes="xyz"),
    Estimate(1.0, 2.0),
]


def test_no_two_of_unlike_things_have_one_text():
    texts = [described(thing) for thing in UNLIKE]
    assert len(set(texts)) == len(UNLIKE)
    assert texts == [described(thing) for thing in UNLIKE]


def test_an_array_is_its_numbers_wherever_they_lie():
    assert described(jnp.ones(3)) == described(np.ones(3))


def test_filters_of_models_are_told_apart_by_their_models():
    level, other = made(SHORT), made(SHORT.replace("C = 1", "C = 2"))
    assert described(level(dt=0.1)) == described(made(SHORT)(dt=0.1))
    assert described(level(dt=0.1)) != described(other(dt=0.1))
    assert described(level.inputs(1.0)) != described((1.0,))


@pytest.mark.parametrize(
    "thing",
    [
        Foreign(1.0),
        Foreign,
        Steeper(dt=0.1),
        Settling(Steeper(dt=0.1)),
        Pair(1.0, 2.0),
        Level.LOW,
        lambda x: x,
        partial(lambda x: x),
        object(),
        np.array([object()]),
        {1, 2},
        (1, [Foreign(1.0)]),
        np.sin,
        sys,
    ],
    ids=lambda thing: type(thing).__name__,
)
def test_what_is_not_plain_has_none(thing):
    with pytest.raises(NotPlainError):
        described(thing)


def test_a_function_that_was_replaced_has_none(monkeypatch):
    monkeypatch.setattr(filters.small_linalg, "matmul", lambda a, b: a)
    with pytest.raises(NotPlainError):
        described(matmul)
