"""Kownacki 2010: Q and R of an accelerometer's and a gyroscope's Kalman filter by optimisation.

Equation and table numbers are the paper's; docs/kownacki2010.md reports the findings.
"""

from studies.kownacki2010 import problems
from studies.kownacki2010.claims import CLAIMS
from studies.kownacki2010.data import benches
from studies.kownacki2010.figures import figures, own_figures
from studies.kownacki2010.paper import channels
from studies.kownacki2010.settings import Settings
from tuner.data.record import Record
from tuner.run.study import Plan, Study, Task
from tuner.solvers import NelderMead, make_solver


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """The paper's procedure on both built-in records, or on the channels of a log.

    Each sensor gives three problems: Q with R as measured, which is well posed; Q and R together,
    as the paper has it ("NAME.paper"); and Q under the literal reading of (10) ("NAME.literal").
    A log gives the first one alone, and is not compared with the paper's sensors.
    """
    tested = benches(settings, records, seed)
    solvers = [
        make_solver(name, seed=seed, starts=settings.starts, storage=storage)
        for name in settings.solvers
    ]
    posed = [problems.problem(bench) for bench in tested]
    papers = [problems.paper(bench) for bench in tested] if not records else []
    tasks = [Task(problem, solver) for problem in posed + papers for solver in solvers]
    if not records:  # the literal cost has jumps, which do not show in a gradient
        simplex = NelderMead(seed=seed, starts=settings.starts)
        tasks += [Task(problems.literal(bench), simplex) for bench in tested]
    return Plan(
        source=tested[0].source,
        tasks=tuple(tasks),
        exports=tuple(problem.name for problem in posed),
        case=tested,
        claims=CLAIMS if not records else (),
        figures=figures if not records else own_figures,
    )


STUDY = Study(
    name="kownacki2010",
    title="Q and R of an accelerometer's and a gyroscope's Kalman filter by optimisation",
    paper="C. Kownacki, Optimization approach to adapt Kalman filters for the real-time "
    "application of accelerometer and gyroscope signals' filtering, "
    "Digital Signal Processing, 2010",
    settings=Settings,
    plan=plan,
    takes="a minute",
    channels=channels,
)
