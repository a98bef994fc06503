"""The environment of a run: versions and settings that its numbers depend on, and no path."""

import os
import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

PACKAGES = (
    "filter-tuner",
    "jax",
    "jaxlib",
    "numpy",
    "scipy",
    "optuna",
    "cmaes",
    "casadi",
    "cvxpy",
    "clarabel",
    "pydantic",
    "typer",
    "rich",
    "matplotlib",
    "h5py",
)


def environment() -> dict[str, Any]:
    """Versions, platform, precision and loop option, JSON-able."""
    import jax

    from filters import loop_option

    return {
        "python": platform.python_version(),
        "system": platform.system(),
        "machine": platform.machine(),
        "processors": os.cpu_count(),
        "packages": {name: installed(name) for name in PACKAGES},
        "float64": bool(jax.config.read("jax_enable_x64")),
        "loop_option": loop_option().name.lower(),
    }


@cache
def installed(name: str) -> str | None:
    """The version of an installed distribution; None where it is missing. Its file is read once."""
    try:
        return version(name)
    except PackageNotFoundError:
        return None
