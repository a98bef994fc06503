"""A time loop in C: its phases, one after another."""

from tuner.native.lanes import HEAD, function
from tuner.native.loop_text import LoopText
from tuner.native.phases import Phases
from tuner.native.settled_text import settling
from tuner.native.sines import sines


def source(both: Phases, lanes: int, *, points: bool) -> str:
    """A function ``run`` that runs a loop over a record.

    It takes the number of samples and of columns, the varying parameters and their derivatives,
    the record, rows of numbers, and memory for the results at the end and the values kept of
    each sample; it returns the number of samples that were taken with constant gains. A value is
    followed by its derivatives. Where lanes are points, the lanes of each number lie side by side,
    else those of each derivative.

    Args:
        both: the loop, in one direction that stands for all lanes, or in each of several; with the
            one before it.
        lanes: their number, a power of two.
        points: whether each lane has its own point.

    Raises:
        NoCounterpartError: for a quotient of whole numbers that differs between points.
    """
    before = None if both.first is None else LoopText(both.first, lanes, points=points)
    # One that settles is over soon, and what it carries is in the order that suits it.
    settles = both.settled is not None
    loop = LoopText(both.main, lanes, points=points, in_order=not settles, before=before)
    parts = [loop] if before is None else [before, loop]
    if both.settled is None:
        loops = loop.text()
    else:
        loops, more = settling(loop, both.settled)
        parts += more
    if before is not None:
        loops = [*before.until(both.zero), "    {", *loops, "    }"]
    functions = {name: takes for part in parts for name, takes in part.lanes.functions.items()}
    main = [
        "size_t run(size_t n, size_t width, const double *p, const double *dp, const double *u,",
        "           double *end, double *kept)",
        "{",
        "    const lanes zero = {0};",
        "    const masks none = {0};",
        "    size_t i = 0, settled = 0;",
        *loops,
        "    return settled;",
        "}",
    ]
    turned = [sines()] if any(part.scalars.turns for part in parts) else []
    used = [function(name, takes, lanes) for name, takes in sorted(functions.items())]
    return "\n".join([HEAD.format(bytes=8 * lanes), *turned, *used, "\n".join(main), ""])
