"""UAV: an attitude filter aided by GPS positions, on real flights without any truth.

The filter is that of Chauhan, Patil, Sinha and Halder 2009; the flights' files stay where the user
has them. docs/uav.md tells what was found.
"""

import hashlib
from functools import partial

from pydantic import Field

from studies.uav import judging
from studies.uav.estimator import ANGLES, LAWS, STATES, Angle, problem
from studies.uav.figures import figures
from studies.uav.flights import Flight, cut, flight
from studies.uav.recordings import GRAVITY, AccUnit, GyrUnit, read
from studies.uav.rows import compare
from tuner.data.logs import Log
from tuner.problem.problem import Problem
from tuner.run.settings import StudySettings
from tuner.run.study import Plan, Source, Study, Target, Task
from tuner.solvers import Gradient

ENOUGH = 1e-4
"""Slope of ln deviation at which a search may end: a tenth of a factor e more changes nothing."""

STARTS = 2
"""Of each search: with the fuzzy law the likelihood has kinks, where one search may end."""


class Settings(StudySettings):
    """Where the flights are, which is tuned on, and how attitudes are made of them."""

    folder: str = Field("", description="folder of the flights: zips, or folders of text files")
    tuned: str = Field("quad106", description="name of the flight that is tuned on")
    judged: tuple[str, ...] = Field(
        ("quad122a", "InputFilesPX4_search", "f450_glitch_log"),
        description="names of the flights that are judged on",
    )
    angles: tuple[Angle, ...] = Field(
        ANGLES, min_length=1, description="constructed angles that are taken as measurements"
    )
    slowest: float = Field(
        3.0, gt=0, description="ground speed up to which no attitude is constructed, m/s"
    )
    ticks_per_second: int = Field(20, ge=5, le=400, description="ticks of the filter in a second")
    gravity: float = Field(GRAVITY, gt=9.7, lt=9.9, description="where it flies, m/s^2")
    velocity_delay: float = Field(
        0.23, ge=0, le=5, description="of the GPS's speed, s, for flights without a timing.txt"
    )
    position_delay: float = Field(0.21, ge=0, le=5, description="of its position, s, likewise")
    acc_unit: AccUnit = Field("m/s^2", description="unit of the accelerometers")
    gyr_unit: GyrUnit = Field("rad/s", description="unit of the gyroscopes")
    seconds: float | None = Field(
        None, ge=30, description="only so much of each flight from its first attitude, s"
    )


MEANINGS = {f"R_{angle}": f"variance of the measured {angle}" for angle in ANGLES} | {
    "Q_quaternion": "spectral density of the quaternion's noise",
    "Q_bias": "spectral density of the gyroscopes' bias",
    "floor_quaternion": "least spectral density of the quaternion's noise",
    "floor_bias": "least spectral density of the gyroscopes' bias",
}


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """Both laws tuned on one flight by the same means, judged on the others."""
    if settings.tuned in settings.judged or len(set(settings.judged)) < len(settings.judged):
        raise ValueError(
            f"{settings.tuned} is tuned on, and {', '.join(settings.judged) or 'none'} judged on; "
            "name every flight once, for what is judged on what it was tuned on says nothing"
        )
    tuned, *others = (_flight(settings, name) for name in (settings.tuned, *settings.judged))
    if tuned.jumps:
        raise ValueError(
            f"the ground speed of {tuned.name} jumps at {tuned.jumps[0]:.1f} s as no vehicle's "
            "does: a GPS glitch, which noise tuned on it would swallow; tune on another flight, "
            "--set tuned=NAME, or on what comes before it, --set seconds=N"
        )
    posed = {law: problem(tuned, law, settings.angles) for law in LAWS}
    solver = Gradient("l-bfgs-b", seed=seed, starts=STARTS, gradient=ENOUGH, iterations=40)
    field = judging.Field(tuned, tuple(others), settings.angles)
    return Plan(
        source=_source(field, settings),
        tasks=tuple(Task(each, solver, solver.name) for each in posed.values()),
        targets=tuple(_target(each, settings) for each in posed.values()),
        compare=partial(compare, field),
        figures=partial(figures, field),
    )


def _flight(settings: Settings, name: str) -> Flight:
    units, delays = (
        (settings.acc_unit, settings.gyr_unit),
        (settings.velocity_delay, settings.position_delay),
    )
    recording = read(settings.folder, name, units, delays)
    whole = flight(recording, 1 / settings.ticks_per_second, settings.slowest, settings.gravity)
    return cut(whole, settings.seconds)


def _source(field: judging.Field, settings: Settings) -> Source:
    digest = hashlib.sha256("".join(each.sha256 for each in field.flights).encode()).hexdigest()
    name = f"flight {field.tuned.name}"
    if field.judged:
        name += f", judged on {', '.join(each.name for each in field.judged)}"
    return Source(name, digest, len(field.tuned.t), float(settings.ticks_per_second))


def _target(posed: Problem, settings: Settings) -> Target:
    return Target(
        problem=posed,
        filter="GpsAidedKalman",
        states=STATES,
        dt=1 / settings.ticks_per_second,
        quantities=lambda _: (),
        single=lambda _: (),
        meanings=MEANINGS,
    )


STUDY = Study(
    name="uav",
    title="Attitude from gyroscopes and GPS positions, on real flights",
    paper="S. Chauhan, C. Patil, M. Sinha and A. Halder, Fuzzy state noise-driven Kalman filter "
    "for sensor fusion, Proc. IMechE Part G: J. Aerospace Engineering 223, 2009",
    settings=Settings,
    channels={},
    plan=plan,
)
