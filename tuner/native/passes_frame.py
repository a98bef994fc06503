"""The C around both passes over a record, in parts that are stored one at a time."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import indent
from typing import NamedTuple

from tuner.native.fetching import fetching
from tuner.native.pass_struct import STRUCT

_HEAD = """\
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
"""
APART = "__attribute__((noinline))"
"""Keeps a function from being written out where it is called."""
_FORTH = """\
static {how} void forth(
    size_t n, size_t width, const double *restrict p, const double *restrict u,
    double *restrict state, double *restrict store, double *restrict kept, bool storing)
{{
{before}
    for (size_t i = 0; i < n; i++, u += width) {{
{sample}
        if (storing) {{
{stored}
            store += {stores};
        }}
        if ({keeps} && kept) {{
{kept}
            kept += {keeps};
        }}
{after}
    }}
{end}
}}

static void with_store(size_t n, size_t width, const double *p, const double *u, double *state,
                       double *store, double *kept)
{{
    forth(n, width, p, u, state, store, kept, true);
}}

static void without_store(size_t n, size_t width, const double *p, const double *u, double *state,
                          double *kept)
{{
    forth(n, width, p, u, state, NULL, kept, false);
}}
"""
_BACK = """\
static void back(size_t n, size_t width, const double *restrict p, const double *restrict u,
                 const double *restrict e, const double *restrict v, const double *restrict store,
                 double *restrict weight, double *restrict slope)
{{
{before}
    u += n * width;
    v += n * {reals};
    store += n * {stores};
    while (n-- > 0) {{
        u -= width;
        v -= {reals};
        store -= {stores};
{sample}
    }}
{end}
}}
"""
_WHOLE = """\
void forwards(const struct run *run, bool storing)
{{
    const size_t n = run->n, part = run->part, width = run->width;
    const double *p = run->p, *u = run->u;
    double *end = run->end;
{state}
    for (size_t from = 0; from < n; from += part) {{
        const size_t count = n - from < part ? n - from : part;
        double *keep = {keeps} ? run->kept + from * {keeps} : NULL;
        if (storing) {{
            memcpy(run->saved + from / part * {carried}, state, {carried} * sizeof *state);
            with_store(count, width, p, u + from * width, state, run->store, keep);
        }} else
            without_store(count, width, p, u + from * width, state, keep);
    }}
{total}
}}

void backwards(const struct run *run, const double *e, const double *v)
{{
    const size_t n = run->n, part = run->part, width = run->width;
    const double *p = run->p, *u = run->u;
    double *saved = run->saved, *store = run->store, *out = run->by_p;
{weight}
    double slope[{slopes} + 1] = {{0}};
    for (size_t from = n - 1; from < n; from -= part) {{
        from = from / part * part;
        const size_t count = n - from < part ? n - from : part;
        if (from + part < n)
            with_store(count, width, p, u + from * width, saved + from / part * {carried}, store,
                       NULL);
        back(count, width, p, u + from * width, e, v + from * {reals}, store, weight, slope);
    }}
    memset(out, 0, run->count * sizeof *out);
{out}
}}

void value(const struct run *run)
{{
    run->number(1, run->z, run->p);
    forwards(run, false);
    run->judge(1, run->end, run->judged);
}}

void gradient(const struct run *run)
{{
    run->number(1, run->z, run->p);
    forwards(run, true);
    run->judge(1, run->end, run->judged);
    backwards(run, run->judged + 1, NULL);
    run->pull(1, run->z, run->slope);
}}
"""


class Code(NamedTuple):
    """C of both passes.

    Its functions take a :class:`tuner.native.pass_struct.Given`. ``forwards`` and ``backwards``
    run over a record in parts. Forwards writes the numbers needed at the end and the values kept
    of each sample; if it stores, also the states where parts begin, and what the way back reads of
    the last part. Backwards takes the derivatives by the numbers at the end and by the kept ones,
    and writes those by the varying numbers. ``value`` and ``gradient`` do all from a point on.

    Attributes:
        text: the source.
        carried: number of numbers of the state.
        stored: number of those that are stored of a sample.
        total: number of those needed at the end.
        kept: number of those kept of a sample.
        operations: number of operations for a sample, where one on a vector counts as one of it.
        options: of the compiler, besides the usual ones.
    """

    text: str
    carried: int
    stored: int
    total: int
    kept: int
    operations: int
    options: Sequence[str] = ()


@dataclass(frozen=True)
class Forth:
    """Statements of the pass over a record: before the loop, of a sample, after the loop.

    Attributes:
        stored, kept: those that write what is stored and kept, where there is memory for it.
        after: those that write the next state.
        how: attributes of the function for the compiler.
    """

    before: str
    sample: str
    stored: str
    kept: str
    after: str
    end: str
    how: str = ""


@dataclass(frozen=True)
class Back:
    """Statements of the pass back: before the loop, of a sample, after the loop."""

    before: str
    sample: str
    end: str


@dataclass(frozen=True)
class Around:
    """Statements around both passes.

    Attributes:
        state: those that define the state before the first sample.
        total: those that write the numbers needed at the end.
        weight: those that define the derivatives by the state after the last sample.
        out: those that write the derivatives by the varying numbers.
    """

    state: str
    total: str
    weight: str
    out: str


@dataclass(frozen=True)
class Sizes:
    """Numbers of what is carried, stored and kept, of kept values with derivatives, of slopes."""

    carried: int
    stored: int
    kept: int
    reals: int
    slopes: int


def framed(functions: str, sizes: Sizes, forth: Forth, back: Back, around: Around) -> str:
    """The whole source.

    Args:
        functions: and tables, which the passes use.
        sizes: of the memory.
        forth: the pass over a record.
        back: the pass back.
        around: what is around them.
    """
    one = _FORTH.format(
        how=forth.how,
        before=indent(forth.before, " " * 4),
        sample=indent(forth.sample, " " * 8),
        stored=indent(forth.stored, " " * 12),
        kept=indent(forth.kept, " " * 12),
        after=indent(forth.after, " " * 8),
        end=indent(forth.end, " " * 4),
        stores=sizes.stored,
        keeps=sizes.kept,
    )
    other = _BACK.format(
        before=indent(back.before, " " * 4),
        sample=indent(fetching(back.sample, sizes.stored), " " * 8),
        end=indent(back.end, " " * 4),
        reals=sizes.reals,
        stores=sizes.stored,
    )
    whole = _WHOLE.format(
        state=indent(around.state, " " * 4),
        total=indent(around.total, " " * 4),
        weight=indent(around.weight, " " * 4),
        out=indent(around.out, " " * 4),
        carried=sizes.carried,
        keeps=sizes.kept,
        reals=sizes.reals,
        slopes=sizes.slopes,
    )
    return "\n".join([_HEAD, functions, one, other, STRUCT, whole])
