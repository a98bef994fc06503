"""tuner doctor: checks that the installation is complete and computes as it should."""

import json as json_
import shutil
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any, NamedTuple

from tuner.run.environment import environment


class Optional(NamedTuple):
    """Something that only some tasks need."""

    use: str
    install: str


_OPTIONAL = {
    "h5py": Optional("MAT v7.3 logs", "pip install 'filter-tuner[mat73]'"),
    "psycopg": Optional("many machines by PostgreSQL", "pip install 'filter-tuner[postgres]'"),
    "pyarrow": Optional("Parquet and Feather logs", "pip install 'filter-tuner[arrow]'"),
    "pyulog": Optional("PX4 logs", "pip install 'filter-tuner[ulog]'"),
    "rosbags": Optional("ROS bags and MCAP", "pip install 'filter-tuner[ros]'"),
    "cc": Optional("fast gradients over long recordings", "a C compiler of the system's packages"),
    "octave": Optional("the benchmark's comparison with fminsearch", "the system's package octave"),
}
OF_PYTHON = ("h5py", "psycopg", "pyarrow", "pyulog", "rosbags")
"""Those of them that are packages."""


def show(json: bool) -> int:
    """Print what was found; 1 where something that is needed is missing or wrong."""
    report = environment()
    problems = _problems(report)
    report |= {"optional": _optional(), "problems": problems}
    if json:
        print(json_.dumps({"schema": "tuner.doctor/1", **report}, indent=1))
        return 1 if problems else 0
    print("\n".join(_lines(report)))
    for problem in problems:
        print(f"problem: {problem}", file=sys.stderr)
    print(f"{len(problems)} problems" if problems[1:] else "1 problem" if problems else "all well")
    return 1 if problems else 0


def _lines(report: dict[str, Any]) -> Iterator[str]:
    yield f"Python {report['python']} on {report['system']} {report['machine']}"
    yield "packages"
    needed = {name: version for name, version in report["packages"].items() if name != "h5py"}
    yield from (f"  {name:14}{version or 'missing'}" for name, version in needed.items())
    yield "computing"
    yield f"  {'precision':14}{'double' if report['float64'] else 'single'}"
    yield f"  {'time loops':14}option {_loop_sentence()}"
    yield f"  {'compiled code':14}{'kept' if _cache() else 'not kept: its folder is read-only'}"
    yield "optional"
    for name, there in report["optional"].items():
        use, install = _OPTIONAL[name]
        yield f"  {name:14}{f'found: {use}' if there else f'missing: {use}; {install}'}"


def _problems(report: dict[str, Any]) -> list[str]:
    missing = [n for n, v in report["packages"].items() if v is None and n not in _OPTIONAL]
    found = [f"{name} is missing: pip install filter-tuner" for name in missing]
    if not report["float64"]:
        found.append("precision is single: leave jax_enable_x64 on")
    if report["loop_option"] == "late":
        found.append(f"the option of time loops is {_loop_sentence()}")
    return found


def _loop_sentence() -> str:
    from filters import loop_option

    return loop_option().value


def _cache() -> bool:
    from tuner.run.cache import use_cache

    return use_cache()


def _optional() -> dict[str, bool]:
    compilers = any(shutil.which(name) for name in ("cc", "gcc", "clang"))
    return {
        **{name: find_spec(name) is not None for name in OF_PYTHON},
        "cc": compilers,
        "octave": shutil.which("octave") is not None,
    }
