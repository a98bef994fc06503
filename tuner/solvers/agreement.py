"""Whether several starts came to the same end."""

from tuner.certificate.solution import Starts
from tuner.certificate.yardstick import Yardstick
from tuner.solvers.minimum import Minimum

AGREE = {"likelihood": 0.05}
"""Ends that differ by less, in nats, agree; of any other kind by 0.1 % of the value."""


def agrees(end: Minimum, best: Minimum, yard: Yardstick) -> bool:
    """Whether an end is as low as the best."""
    within = AGREE.get(yard.kind, yard.negligible)
    return end.allowed and yard.of(end.value - best.value) <= within


def agreement(ends: list[Minimum], best: Minimum, yard: Yardstick) -> Starts:
    """How the ends agree; those that keep no constraint found nothing that could."""
    rivals = [end for end in ends if end.allowed] or [best]
    excess = [yard.of(end.value - best.value) for end in rivals]
    return Starts(len(rivals), sum(agrees(end, best, yard) for end in rivals), max(excess))


def most_agree(starts: Starts) -> bool:
    """Whether at least half of the starts, and two, came to the best value."""
    return starts.agreeing >= max(2, starts.count / 2)
