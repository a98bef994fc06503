"""Ha, Kim and Choi 1981: the vertical channel's bias by a conventional loop and a Kalman filter.

Nothing is measured: gains follow from the model. Equation numbers are the paper's;
docs/ha1981.md reports the findings.
"""

from studies.ha1981.channel import Channel
from studies.ha1981.claims import CLAIMS
from studies.ha1981.figures import figures
from studies.ha1981.problems import tasks
from studies.ha1981.settings import Settings
from tuner.data.record import Record
from tuner.data.source import Source
from tuner.run.study import Plan, Study


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """The designs of both schemes, and of the values that the paper leaves open."""
    channel = Channel.of(settings)
    return Plan(
        source=Source.model("none: the model alone", [channel]),
        tasks=tasks(channel, settings, seed),
        exports=("conventional", "kalman_stored"),
        case=(channel, settings),
        claims=CLAIMS,
        figures=figures,
    )


STUDY = Study(
    name="ha1981",
    title="Bias of an INS vertical channel: gains of a conventional loop and a Kalman filter",
    paper="I. J. Ha, Y. K. Kim and K. K. Choi, Kalman Filter Method and the Conventional Method "
    "for the Bias Error Reduction of INS Vertical Channel, 1981",
    settings=Settings,
    plan=plan,
    takes="half a minute",
)
