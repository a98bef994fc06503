"""The silent cliff: run times where XLA was not asked to compile whole loops."""

from collections.abc import Mapping

from benchmarks.processes import measure
from benchmarks.table import Row, duration
from benchmarks.work import Work

PART = "Without the loop option"
LATE = (
    "XLA's default compiles only loops that touch less than 1 kB a turn as a whole; the tangents "
    "of two parameters touch more than 2 kB. It happens only where JAX's backend ran "
    "before `tuner` was imported, and a warning says so"
)
WHAT = {
    "cost": "cost, R1",
    "cost + gradient": "cost + gradient, R1",
    "generic gradient": "gradient of the generic filter",
}


def rows(work: Work) -> list[Row]:
    """The same code in two processes, with the option and without."""
    on = measure("gradient", samples=work.samples)
    off = measure("gradient", whole=False, samples=work.samples)
    found = [_slower(name, on, off) for name in WHAT]
    return [*found, _against_c(off)] if "C" in off else found


def _slower(name: str, on: Mapping[str, float], off: Mapping[str, float]) -> Row:
    return Row(
        part=PART,
        what=f"{WHAT[name]}: without / with",
        ours=duration(on[name]),
        against=duration(off[name]),
        figure=off[name] / on[name],
    )


def _against_c(off: Mapping[str, float]) -> Row:
    return Row(
        part=PART,
        what="cost + gradient, R1",
        ours=duration(off["cost + gradient"]),
        against=f"C: {duration(off['C'])}",
        figure=off["cost + gradient"] / off["C"],
        target=6.0,
        why=LATE,
    )
