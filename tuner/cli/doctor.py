"""tuner doctor: is everything there, and does it do what it should?"""

import json as json_
import shutil
import sys
from importlib.util import find_spec
from typing import Any

from tuner.run.environment import environment

_OPTIONAL = {
    "h5py": "MAT v7.3 logs: pip install 'filter-tuner[mat73]'",
    "psycopg": "many machines by PostgreSQL: pip install 'filter-tuner[postgres]'",
    "pyarrow": "Parquet and Feather: pip install 'filter-tuner[arrow]'",
    "pyulog": "PX4 logs: pip install 'filter-tuner[ulog]'",
    "rosbags": "ROS bags and MCAP: pip install 'filter-tuner[ros]'",
    "cc": "a C compiler: gradients over long recordings, the benchmark's speed limit",
    "octave": "Octave, for the comparison with its fminsearch",
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
    print(f"Python {report['python']} on {report['system']} {report['machine']}")
    for name, version in report["packages"].items():
        print(f"  {name:14}{version or 'missing'}")
    print(f"float64: {'on' if report['float64'] else 'OFF'}")
    print(f"loop option: {_loop_sentence()}")
    print(f"compiled code is kept: {'yes' if _cache() else 'no, its folder cannot be written'}")
    for name, there in report["optional"].items():
        print(f"optional {name}: {'found' if there else 'not found'} ({_OPTIONAL[name]})")
    for problem in problems:
        print(f"PROBLEM: {problem}", file=sys.stderr)
    print("all well" if not problems else f"{len(problems)} problems")
    return 1 if problems else 0


def _problems(report: dict[str, Any]) -> list[str]:
    missing = [n for n, v in report["packages"].items() if v is None and n not in _OPTIONAL]
    found = [f"{name} is missing: pip install filter-tuner" for name in missing]
    if not report["float64"]:
        found.append("float64 is off: something switched jax_enable_x64 back")
    if report["loop_option"] == "late":
        found.append(_loop_sentence())
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
