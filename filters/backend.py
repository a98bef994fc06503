"""Settings that must reach XLA before its CPU backend starts: float64, whole loops, one thread."""

import os
import sys
import warnings
from collections.abc import MutableMapping
from enum import Enum
from functools import cache

LOOP_OPTION = "xla_cpu_small_while_loop_byte_threshold"
_FLAG = "--xla_backend_extra_options="
FUSION = "--xla_cpu_experimental_ynn_fusion_type"
"""Which operations XLA hands to the YNN library; such a fusion keeps the loop that holds it from
being compiled as a whole: from seven states on in a gradient, from nine in a value."""
INLINE = "JAX_CPU_ENABLE_ASYNC_DISPATCH"
"""Whether another thread computes while the caller goes on. A search waits for each number, and
the change of threads takes a quarter of a value of 1000 samples."""


class LoopOption(Enum):
    """Whether XLA compiles a whole time loop into one native loop in this process."""

    SET = "set before the backend started"
    GIVEN = "already given by the user in XLA_FLAGS"
    LATE = "not set: JAX's backend had started before `filters` was imported; import tuner first"


@cache
def loop_option() -> LoopOption:
    """Prepare the backend at the first call, and return what was found then."""
    return prepare(os.environ)


def prepare(environment: MutableMapping[str, str]) -> LoopOption:
    """Switch float64 on and ask XLA's CPU backend to compile whole scans.

    XLA compiles a loop into one native loop only where the loop's state is below
    1 kB; every larger scan is interpreted operation by operation, 10 to 100 times
    slower. The threshold is read once, when the backend starts. A loop that
    holds a fusion of the YNN library is interpreted too, so these are switched off. What is called
    is computed by the thread that calls, unless ``JAX_CPU_ENABLE_ASYNC_DISPATCH`` is given.

    Args:
        environment: where ``XLA_FLAGS`` is read and written.

    Returns:
        What was found. ``LATE`` also warns, once, as it cannot be mended in this process.
    """
    late = _backend_started()
    flags = environment.get("XLA_FLAGS", "")
    given = LOOP_OPTION in flags
    if not late and not given:
        environment["XLA_FLAGS"] = with_loop_option(flags)

    import jax

    jax.config.update("jax_enable_x64", True)
    if not late and INLINE not in environment:
        jax.config.update(INLINE.lower(), False)
    if given:
        return LoopOption.GIVEN
    if late:
        warnings.warn(
            "JAX's backend had started before `filters` was imported, so time loops run up to "
            "100 times slower; import tuner before the first JAX computation",
            RuntimeWarning,
            stacklevel=4,
        )
        return LoopOption.LATE
    return LoopOption.SET


def with_loop_option(flags: str) -> str:
    """Add the loop option to the text of ``XLA_FLAGS``, beside what is there already.

    >>> with_loop_option("--xla_foo=1").split()[:2]
    ['--xla_foo=1', '--xla_cpu_experimental_ynn_fusion_type=']
    >>> with_loop_option("--xla_foo=1").split()[2]
    '--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=1000000000'
    """
    ours = f"{LOOP_OPTION}=1000000000"
    words = flags.split()
    if FUSION not in flags:
        words.append(f"{FUSION}=")
    # XLA keeps the last occurrence of a flag, so ours has to join a list that is there already.
    for i, word in reversed(list(enumerate(words))):
        if word.startswith(_FLAG):
            return " ".join([*words[:i], f"{word},{ours}", *words[i + 1 :]])
    return " ".join([*words, _FLAG + ours])


def _backend_started() -> bool:
    if "jax" not in sys.modules:
        return False
    from jax._src import xla_bridge  # no public function answers this

    return bool(xla_bridge.backends_are_initialized())
