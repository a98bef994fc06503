"""float64 and the loop option: what the environment says, and what a process then does."""

import json
import os
import subprocess
import sys
from pathlib import Path

import jax
import jax.numpy as jnp
import pytest

from filters import LoopOption, loop_option
from filters.backend import FUSION, INLINE, LOOP_OPTION, prepare, with_loop_option

ROOT = Path(__file__).parents[2]
OURS = f"{LOOP_OPTION}=1000000000"
NONE = f"{FUSION}="
LIST = "--xla_backend_extra_options="
OTHER = "xla_cpu_option_of_the_user=1"

# A gradient along 20 000 samples: the loop option makes it some 20 times faster.
REPORT = """
import json, os, time, warnings
import jax, jax.numpy as jnp
{before}
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    import filters
    again = filters.loop_option()

def total(point):
    noise = filters.KownackiNoise.of(R=jnp.exp(point[0]), Q=jnp.exp(point[1]))
    return filters.run(filters.GyroscopeFilter(1e-4), noise, jnp.ones(20_000))[1].sum()

gradient, times = jax.jit(jax.jacfwd(total)), [float("inf")]
point = jnp.array([-20.0, -10.0])
for _ in range({runs}):
    start = time.perf_counter()
    gradient(point).block_until_ready()
    times.append(time.perf_counter() - start)
print(json.dumps({{
    "option": filters.loop_option().name, "again": again.name, "flags": os.environ["XLA_FLAGS"],
    "warnings": [(w.category.__name__, str(w.message)) for w in caught],
    "dtype": str(jnp.ones(1).dtype), "seconds": min(times),
}}))
"""


def process(flags="", before="", runs=8):
    environment = {**os.environ, "XLA_FLAGS": flags, "JAX_PLATFORMS": "cpu"}
    finished = subprocess.run(
        [sys.executable, "-c", REPORT.format(before=before, runs=runs)],
        cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert finished.returncode == 0, finished.stderr
    return json.loads(finished.stdout)


@pytest.fixture(scope="module")
def fresh():
    """A process that imports filters first, where the user's list has another option already."""
    return process(flags=f"--xla_force_host_platform_device_count=1 {LIST}{OTHER}")


@pytest.fixture(scope="module")
def late():
    """A process that has computed something before it imports filters."""
    return process(before="jnp.ones(1).block_until_ready()")


@pytest.mark.parametrize(
    ("flags", "expected"),
    [
        ("", f"{NONE} {LIST}{OURS}"),
        ("   ", f"{NONE} {LIST}{OURS}"),
        ("--xla_a=1 --xla_b", f"--xla_a=1 --xla_b {NONE} {LIST}{OURS}"),
        (f"{LIST}x=1", f"{LIST}x=1,{OURS} {NONE}"),
        (f"--xla_a=1 {LIST}x=1,y --xla_b", f"--xla_a=1 {LIST}x=1,y,{OURS} --xla_b {NONE}"),
        # XLA reads the last of two lists, so that is the one to join.
        (f"{LIST}x=1 {LIST}y=2", f"{LIST}x=1 {LIST}y=2,{OURS} {NONE}"),
        # What the user says of fusions stays.
        (f"{FUSION}=dot", f"{FUSION}=dot {LIST}{OURS}"),
    ],
)
def test_the_option_joins_what_is_there(flags, expected):
    assert with_loop_option(flags) == expected


def test_preparing_sets_the_option_once():
    """with_loop_option always adds; that it is not added twice is prepare's part."""
    environment = {"XLA_FLAGS": f"{LIST}{OURS}"}
    assert prepare(environment) is LoopOption.GIVEN
    assert environment == {"XLA_FLAGS": f"{LIST}{OURS}"}


def test_a_value_of_the_user_is_left_alone():
    environment = {"XLA_FLAGS": f"{LIST}{LOOP_OPTION}=5"}
    assert prepare(environment) is LoopOption.GIVEN
    assert environment == {"XLA_FLAGS": f"{LIST}{LOOP_OPTION}=5"}


def test_preparing_late_warns_and_leaves_the_environment_alone():
    jnp.ones(1).block_until_ready()  # the backend runs
    environment = {}
    with pytest.warns(
        RuntimeWarning, match="import tuner before the first JAX computation"
    ) as seen:
        assert prepare(environment) is LoopOption.LATE
    assert len(seen) == 1
    assert environment == {}


def test_this_process_has_float64_and_the_option():
    assert loop_option() in {LoopOption.SET, LoopOption.GIVEN}
    assert jnp.ones(1).dtype == "float64"


def test_a_fresh_process_gets_the_option_without_a_word(fresh):
    assert fresh["option"] == fresh["again"] == "SET"
    assert fresh["flags"] == (
        f"--xla_force_host_platform_device_count=1 {LIST}{OTHER},{OURS} {NONE}"
    )
    assert fresh["warnings"] == []
    assert fresh["dtype"] == "float64"


def test_a_process_with_the_users_own_value_keeps_it():
    given = process(flags=f"{LIST}{LOOP_OPTION}=1024", runs=0)
    assert given["option"] == given["again"] == "GIVEN"
    assert given["flags"] == f"{LIST}{LOOP_OPTION}=1024"
    assert given["warnings"] == []
    assert given["dtype"] == "float64"


def test_a_late_import_warns_once_and_still_has_float64(late):
    assert late["option"] == late["again"] == "LATE"
    assert late["flags"] == ""
    assert [category for category, _ in late["warnings"]] == ["RuntimeWarning"]
    assert late["dtype"] == "float64"


def test_the_option_makes_a_gradient_much_faster(fresh, late):
    """The cliff is silent: without the option the same code runs, 20 times slower.

    A ratio of the fastest of eight runs, and a fifth of what it usually is, for other load.
    """
    assert late["seconds"] > 4 * fresh["seconds"]


@pytest.mark.skipif(INLINE in os.environ, reason="the environment decides")
def test_calls_are_computed_by_the_thread_that_makes_them():
    assert jax.config.values[INLINE.lower()] is False
