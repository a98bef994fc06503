"""Fresh Python processes: with and without the loop option, and nothing else different."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping

from filters.backend import LOOP_OPTION, with_loop_option

DEFAULT_THRESHOLD = 1024  # bytes; XLA's own
_PATIENCE = 300  # s


def loop_flags(flags: str, *, whole: bool) -> str:
    """``XLA_FLAGS`` with the loop option on, or at XLA's own default.

    >>> loop_flags("", whole=False).split()[-1]
    '--xla_backend_extra_options=xla_cpu_small_while_loop_byte_threshold=1024'
    """
    given = flags if LOOP_OPTION in flags else with_loop_option(flags)
    value = 10**9 if whole else DEFAULT_THRESHOLD
    return re.sub(rf"{LOOP_OPTION}=\d+", f"{LOOP_OPTION}={value}", given)


def measure(task: str, *, whole: bool = True, samples: int = 0) -> Mapping[str, float]:
    """Run one of :mod:`benchmarks.worker`'s tasks in its own process: seconds by name."""
    environment = dict(os.environ)
    environment["XLA_FLAGS"] = loop_flags(environment.get("XLA_FLAGS", ""), whole=whole)
    environment.pop("JAX_COMPILATION_CACHE_DIR", None)
    command = [sys.executable, "-m", "benchmarks.worker", task, str(samples)]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=_PATIENCE, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{' '.join(command[1:])} failed: {done.stderr.strip()[-500:]}")
    found: Mapping[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def python(code: str, bytecode: str) -> None:
    """Run a line of Python in its own process.

    Args:
        code: the line.
        bytecode: a folder for compiled modules. An installed package has them, a checkout that
            nobody may write to has not, and compiling takes as long as importing.
    """
    environment = dict(os.environ, PYTHONPYCACHEPREFIX=bytecode, PYTHONDONTWRITEBYTECODE="")
    subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True)
