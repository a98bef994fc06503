"""A test that a fit does not depend on the units of its record.

``python -m benchmarks.units`` fits every filter whose measurement may have any unit, in channel
units and units of time from 1e-9 to 1e9, and prints by how much each answer strays, relative, from
that in plain units. ``tests/tuner/test_fit_units.py`` runs a part of it.
"""

import re
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

import tuner
from filters.declared import OWN, channel_facts, parameter_facts
from tuner.catalogue import find, names

FACTORS = (1e-9, 1e-3, 1e3, 1e9)
DT = 0.5
SAMPLES = 300
_TIME = re.compile(r"/s(?:\^(\d+))?$")


class Scaled(NamedTuple):
    """A record of a filter in other units: ``size`` of its channels, ``clock`` of its time."""

    size: float = 1.0
    clock: float = 1.0

    def of(self, unit: str) -> float:
        """The factor on a number in a declared unit.

        >>> Scaled(10.0, 2.0).of("unit^2/s")
        50.0
        """
        own, per_time = OWN.search(unit), _TIME.search(unit)
        size = self.size ** int(own[1] or 1) if own else 1.0
        return size / self.clock ** int(per_time[1] or 1) if per_time else size


def of_any_unit() -> list[str]:
    """The catalogue's filters of which all parameters and inputs scale with the data."""
    found = []
    for name in names("tuner.filters"):
        cls = find("tuner.filters", name)
        channels = channel_facts(cls, "inputs").values()
        units = [fact.unit for fact in channels]
        units += [fact.unit for fact in parameter_facts(cls).values()]
        if all(OWN.search(unit) or not unit for unit in units) and any(
            OWN.search(fact.unit) for fact in channels
        ):
            found.append(name)
    return found


def record(name: str, scaled: Scaled, seed: int = 1) -> tuner.Record:
    """A course that wanders, with noise and gaps, for a filter of one measurement."""
    cls = find("tuner.filters", name)
    draw = np.random.default_rng(seed)
    depth = len(cls.states)  # a level, or a position and its derivatives
    course = draw.normal(size=SAMPLES)
    for _ in range(depth):
        course = np.cumsum(course) * DT
    z = course + draw.normal(size=SAMPLES)
    z[draw.random(SAMPLES) < 0.1] = np.nan
    channel = next(iter(channel_facts(cls, "inputs")))
    likelihood = "variance" in channel_facts(cls, "outputs")
    truth = {} if likelihood else {next(iter(channel_facts(cls, "outputs"))): scaled.size * course}
    return tuner.Record.of(
        {channel: scaled.size * z}, rate_hz=1 / (DT * scaled.clock), truth=truth or None
    )


def fitted(name: str, scaled: Scaled, **options: Any) -> dict[str, float]:
    """The parameters of a fit, back in plain units."""
    fit = tuner.fit(name, record(name, scaled), hold_out=False, **options)
    facts = parameter_facts(find("tuner.filters", name))
    return {
        key: float(found.value) / scaled.of(facts[key].unit)
        for key, found in fit.solution.parameters.items()
    }


def strays(name: str, **options: Any) -> Iterator[tuple[Scaled, float]]:
    """Relative difference of each fit in other units from that in plain ones."""
    plain = fitted(name, Scaled(), **options)
    for scaled in (*(Scaled(size=f) for f in FACTORS), *(Scaled(clock=f) for f in FACTORS)):
        other = fitted(name, scaled, **options)
        yield scaled, max(abs(other[key] / plain[key] - 1) for key in plain)


def main() -> None:
    """Print all of them."""
    for name in of_any_unit():
        begun = time.perf_counter()
        for scaled, stray in strays(name):
            print(f"{name:24} size {scaled.size:7.0e} clock {scaled.clock:7.0e}  {stray:.1e}")
        print(f"{name:24} {time.perf_counter() - begun:.1f} s")


if __name__ == "__main__":
    main()
