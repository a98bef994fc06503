"""A tuned filter for export: its numbers, their meaning and their origin."""

import math
import re
import reprlib
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from tuner.export.checks import frozen_array, require, require_name, require_once, require_text

Convention: TypeAlias = Literal["discrete", "continuous"]

# C99 distinguishes identifiers by 63 characters; GYRO_STATE_OMEGA is the longest form made.
LONGEST_NAME = 31
_LONGEST_PART = 25
_TAKEN = re.compile(
    r"dt|real|states?|state_.*|tuner_(meta|json)|.*_(f|rows|cols|included)", re.IGNORECASE
)


@dataclass(frozen=True, eq=False)
class Quantity:
    """One number, vector or matrix of a tuned filter; equality is bit for bit.

    Attributes:
        name: letters, digits and single underscores, 25 characters at most: ``R``, ``P0``, ``K1``.
            Names that a C header forms are reserved: ``dt``, ``states``, ``..._f`` and so on.
        value: float64, shape ``()``, ``(n,)`` or ``(n, m)``, finite; kept as a read-only copy.
        unit: such as ``"(rad/s)^2"``; ``""`` for none.
        meaning: one short sentence.

    Raises:
        ValueError: one sentence, where a field is not as above.

    Example:
        >>> Quantity("R", np.array(1.5e-9), "(rad/s)^2") == Quantity("R", np.array(1.5e-9), "")
        False
    """

    name: str
    value: NDArray[np.float64]
    unit: str
    meaning: str = ""

    def __post_init__(self) -> None:
        require_name("the quantity", self.name, _LONGEST_PART)
        require(
            not _TAKEN.fullmatch(self.name),
            f"{self.name!r} is a name that C headers or MAT files need themselves; rename it",
        )
        require_text(f"the unit of {self.name!r}", self.unit)
        require_text(f"the meaning of {self.name!r}", self.meaning)
        object.__setattr__(self, "value", frozen_array(self.name, self.value))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Quantity) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[Any, ...]:
        return self.name, self.value.shape, self.value.tobytes(), self.unit, self.meaning


@dataclass(frozen=True)
class Provenance:
    """The origin of the numbers; no times and no machine, so equal runs give equal files.

    Attributes:
        study: name of the study.
        problem: name of its problem.
        solver: name of the solver.
        status: how the solver ended.
        seed: seed of the random numbers, below 2^63 in magnitude.
        log_name: name of the log; ``""`` where there was none.
        log_sha256: its SHA-256; ``""`` where there was none.
        versions: ``("filter-tuner", "0.1.0"), ...``, each name once.

    Raises:
        ValueError: one sentence, where a field is not as above.

    Example:
        >>> Provenance("demo", "step", "grid", "optimal", 0, "", "", (("jax", "0.10.2"),)).seed
        0
    """

    study: str
    problem: str
    solver: str
    status: str
    seed: int
    log_name: str
    log_sha256: str
    versions: tuple[tuple[str, str], ...]

    def __post_init__(self) -> None:
        for field in ("study", "problem", "solver", "status", "log_name", "log_sha256"):
            require_text(f"the {field}", getattr(self, field))
        require(
            type(self.seed) is int and abs(self.seed) < 2**63,
            f"the seed is {reprlib.repr(self.seed)}; give a whole number below 2^63",
        )
        for pair in self.versions:
            require(
                isinstance(pair, tuple) and len(pair) == 2,
                f"{reprlib.repr(pair)} is not a version; give pairs of a name and a version",
            )
            require_text("a name among the versions", pair[0])
            require_text(f"the version of {pair[0]!r}", pair[1])
        require_once("version", [name for name, _ in self.versions])


@dataclass(frozen=True)
class Tuned:
    """A tuned filter, ready to be written.

    Attributes:
        name: file stem and prefix in C, ``"gyro"``; as a quantity's name, 31 characters at most.
        filter: name of the filter's class, ``"GyroscopeFilter"``.
        quantities: its numbers, at least one; names differ in more than case.
        convention: whether they are those of the discrete or of the continuous model.
        dt: sample time in s, positive; 0 where the numbers are those of the continuous model.
        states: names of the states in their order, ``("omega", "epsilon")``.
        provenance: the origin of the numbers.

    Raises:
        ValueError: one sentence, where a field is not as above.

    Example:
        >>> source = Provenance("demo", "step", "grid", "optimal", 0, "", "", ())
        >>> R = Quantity("R", np.array(2.0), "m^2/s^4")
        >>> tuned = Tuned("level", "AccelerometerFilter", (R,), "discrete", 0.01, ("a",), source)
        >>> tuned.quantities[0].unit
        'm^2/s^4'
    """

    name: str
    filter: str
    quantities: tuple[Quantity, ...]
    convention: Convention
    dt: float
    states: tuple[str, ...]
    provenance: Provenance

    def __post_init__(self) -> None:
        require_name("the tuned filter", self.name, LONGEST_NAME)
        require_text("the name of the filter's class", self.filter)
        require(len(self.quantities) > 0, "there are no quantities; give at least one")
        require_once("quantity", [quantity.name.lower() for quantity in self.quantities])
        for state in self.states:
            require_name("the state", state, _LONGEST_PART)
        require_once("state", [state.lower() for state in self.states])
        require(
            self.convention in get_args(Convention),
            f"the convention is {reprlib.repr(self.convention)}; give 'discrete' or 'continuous'",
        )
        least = self.dt == 0 and self.convention == "continuous"
        require(
            isinstance(self.dt, float | int) and math.isfinite(self.dt) and (self.dt > 0 or least),
            f"the sample time is {reprlib.repr(self.dt)}; give a positive number of seconds, or 0 "
            "for a continuous model",
        )
        object.__setattr__(self, "dt", float(self.dt))
