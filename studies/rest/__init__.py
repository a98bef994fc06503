"""A sensor at rest: its noise, and a filter that meets a requirement.

docs/rest.md explains the numbers.
"""

from collections.abc import Iterator

from filters import Channel
from studies.rest.data import axes_of
from studies.rest.figures import figures
from studies.rest.findings import findings
from studies.rest.problems import Rest, filter_problem, noise_problem, rest_of
from studies.rest.settings import Settings
from tuner.data.findings import resolution
from tuner.data.record import Record
from tuner.data.source import Source
from tuner.run.study import Plan, Study, Task
from tuner.solvers import Gradient, Ipopt, Known


def plan(settings: Settings, records: tuple[Record, ...], seed: int, storage: str) -> Plan:
    """Noise of every axis, and its filter where there is a requirement."""
    axes = axes_of(records)
    rests = tuple(rest_of(axis, settings.rate_hz, settings.requirement) for axis in axes)
    tasks = [
        Task(noise_problem(rest), Gradient("l-bfgs-b", seed=seed, starts=settings.starts))
        for rest in rests
    ]
    if settings.requirement:
        for rest in rests:
            problem = filter_problem(rest)
            solvers = (_closed_form(rest), Ipopt(seed=seed, starts=1))
            tasks += [Task(problem, solver) for solver in solvers]
    return Plan(
        source=Source.joined(axes[0].source.name, [axes[0].source]),
        tasks=tuple(tasks),
        exports=tuple(rest.axis.name for rest in rests),
        case=rests,
        claims=(),
        figures=figures,
        notes=tuple(note for rest in rests for note in _notes(rest)),
        findings=findings,
    )


def _closed_form(rest: Rest) -> Known:
    return Known("closed form", lambda _: {"K1": rest.gain}, "the least gain that will do")


def channels(settings: Settings) -> dict[str, Channel]:
    """The channels: any name will do."""
    return {}


def _notes(rest: Rest) -> Iterator[str]:
    """Remarks on the numbers of an axis."""
    name, noise, dt = rest.axis.name, rest.noise, 1 / rest.axis.rate_hz
    if not noise.fits:
        yield f"{name}: no part of the Allan curve is white noise, so N and K are unreliable"
    elif noise.from_s > 1.5 * dt:
        yield (
            f"{name} is not white below {noise.from_s:.3g} s: N is fitted from there to "
            f"{noise.to_s:.4g} s, and R is not the variance of a sample"
        )
    step = resolution(rest.axis.values)
    if step is not None and step > 0.5 * rest.axis.values.std():
        yield (
            f"{name} is quantised in steps of {step * rest.axis.scale:.3g}, half of its noise or "
            "more: smaller noise is not determined"
        )
    if noise.flicker.value > 0:
        B = noise.instability.value * rest.axis.scale
        yield (
            f"{name} has flicker noise as well (bias instability {B:.3g} {rest.axis.written}), so "
            "both methods differ in K; the likelihood's predicts the next samples best"
        )
    if not rest.walk.known:
        high = rest.walk.high * rest.axis.scale
        yield (
            f"{name}: {rest.axis.seconds:.4g} s show no random walk of the bias, K is below "
            f"{high:.3g}; record for longer to see it"
        )


STUDY = Study(
    name="rest",
    title="A sensor at rest: noise density, bias instability, walk, R and Q, and a filter for it",
    paper="none: a record of your own; IEEE Std 952 and NIST SP 1065",
    settings=Settings,
    plan=plan,
    needs="a record of a sensor at rest: --log FILE --map NAME=COLUMN",
    takes="ten seconds",
    channels=channels,
)
