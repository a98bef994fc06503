"""You and Lee: a mixing filter for roll and pitch, and a velocity filter that aids it in turns.

Equation numbers are the paper's; docs/you_lee.md reports the findings.
"""

import numpy as np

from studies.you_lee import problems
from studies.you_lee.cases import Bench
from studies.you_lee.checks import refuse
from studies.you_lee.claims import CLAIMS
from studies.you_lee.figures import figures
from studies.you_lee.settings import Settings
from tuner.data.record import Record
from tuner.data.source import Source
from tuner.run.study import Plan, Study, Task
from tuner.solvers import Gradient


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """All problems tuned on the same runs by the same means, judged on others."""
    bench = Bench(settings, seed)
    posed = problems.posed(bench)
    refuse(bench)
    solver = Gradient("l-bfgs-b", seed=seed, starts=settings.starts)
    name = f"{settings.train} simulated flights on {settings.trajectory}, seeds from {seed}"
    shown = [np.asarray(leaf) for leaf in bench.train[0]]
    return Plan(
        source=Source.simulated(name, shown, settings.rate_hz),
        tasks=tuple(Task(problem, solver) for problem in posed.values()),
        exports=tuple(posed),
        case=bench,
        claims=tuple(claim for claim in CLAIMS if posed.keys() >= {*claim.needs}),
        figures=figures,
    )


STUDY = Study(
    name="you_lee",
    title="Roll and pitch in a turn: a mixing filter aided by airspeed or velocity, tuned",
    paper="J. J. You and J. G. Lee, An accelerometer Aided Mixing Algorithm for Strapdown "
    "Attitude (Roll, Pitch) Reference System (in Korean)",
    settings=Settings,
    plan=plan,
    takes="two to three minutes",
)
