"""Records lie in memory as XLA reads them, which does not copy them in every evaluation."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import LevelSample, LocalLevel
from objectives import Data, InnovationLikelihood
from tuner import Positive, Problem, Space
from tuner.problem.aligned import aligned

N = 40_000


def apart(size, by):
    """Zeros that begin so many bytes after a multiple of 64."""
    memory = np.zeros(8 * size + 128, np.uint8)
    begin = -memory.ctypes.data % 64 + by
    return memory[begin : begin + 8 * size].view(float)


def places(record):
    return [np.asarray(leaf).ctypes.data % 64 for leaf in jax.tree.leaves(record)]


@pytest.mark.parametrize("by", [0, 8, 16, 32, 56])
def test_a_large_array_is_moved_once(by):
    values = apart(N, by)
    values[:] = np.arange(N)
    found = aligned(values)
    assert places(found) == [0]
    assert (found is values) == (by == 0)
    np.testing.assert_array_equal(found, np.arange(N))
    assert aligned(found) is found


@pytest.mark.parametrize("dtype", [bool, np.int32, float])
def test_gaps_in_memory_are_closed(dtype):
    wide = np.arange(N * 9).reshape(N, 9).astype(dtype)
    for part in (wide[:, 2:5], wide[::2], wide.T):
        found = aligned(part)
        assert found.flags.c_contiguous
        assert found.dtype == dtype
        assert places(found) == [0]
        np.testing.assert_array_equal(found, part)


def test_what_is_small_or_xla_s_own_stays():
    record = [np.zeros(3), jnp.zeros(N), apart(N, 0)]
    assert aligned(record) is record
    moved = aligned([*record, apart(N, 8)])
    assert all(one is other for one, other in zip(record, moved, strict=False))


def problem(z):
    space = Space.of(q=Positive(1.0, 1e-3, 1e3), R=Positive(1.0, 1e-3, 1e3))
    data = Data(LevelSample(z), np.zeros((len(z), 1)))
    return Problem("level", space, LocalLevel(dt=1.0), None, InnovationLikelihood(), data)


def test_the_record_of_a_problem():
    z = apart(N, 16)
    z[:] = np.random.default_rng(0).normal(size=N).cumsum()
    one = problem(z)
    assert places(one.data) == [0, 0]
    np.testing.assert_array_equal(one.data.inputs.z, z)
