"""Both passes over a record in C."""

from collections.abc import Iterable, Sequence
from textwrap import indent

from tuner.code.literal import type_of
from tuner.native.passes import Passes
from tuner.native.scalars import Scalars, read
from tuner.native.sines import sines

_HEAD = """\
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
"""
_FORTH = """\
static void forth(size_t n, size_t width, const double *p, const double *u, double *state,
                  double *store, double *kept)
{{
{before}
    for (size_t i = 0; i < n; i++, u += width) {{
{sample}
        if (store) {{
{stored}
            store += {stores};
        }}
        if (kept) {{
{kept}
            kept += {keeps};
        }}
{after}
    }}
{end}
}}
"""
_BACK = """\
static void back(size_t n, size_t width, const double *p, const double *u, const double *e,
                 const double *v, const double *store, double *weight, double *slope)
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
void forwards(size_t n, size_t part, size_t width, const double *p, const double *u, double *saved,
              double *store, double *kept, double *end)
{{
{start}
    double state[] = {{{states}0.0}};
    for (size_t from = 0; from < n; from += part) {{
        const size_t count = n - from < part ? n - from : part;
        if (saved) memcpy(saved + from / part * {carried}, state, {carried} * sizeof *state);
        forth(count, width, p, u + from * width, state, store, kept ? kept + from * {keeps} : NULL);
    }}
{total}
}}

void backwards(size_t n, size_t part, size_t width, const double *p, const double *u,
               const double *e, const double *v, double *saved, double *store, double *out)
{{
    double weight[] = {{{weights}0.0}}, slope[{slopes}] = {{0}};
    for (size_t from = n - 1; from < n; from -= part) {{
        from = from / part * part;
        const size_t count = n - from < part ? n - from : part;
        if (from + part < n)
            forth(count, width, p, u + from * width, saved + from / part * {carried}, store, NULL);
        back(count, width, p, u + from * width, e, v + from * {reals}, store, weight, slope);
    }}
{out}
}}
"""


def text(passes: Passes, reals: Sequence[bool]) -> str:
    """Functions ``forwards`` and ``backwards``, which run over a record in parts.

    Forwards takes the numbers of samples, of those of a part, and of columns, the varying numbers,
    the record, and memory: for the states where parts begin, for what is stored of the samples of
    a part, for the values kept of each sample, and for the numbers needed at the end. Without
    the first three it computes these alone. Backwards takes the derivatives by the numbers at
    the end and by the kept ones, and writes those by the varying numbers.

    Args:
        passes: both passes.
        reals: which of the kept values have derivatives.
    """
    return _Text(passes, sum(reals)).whole()


class _Text:
    def __init__(self, passes: Passes, reals: int) -> None:
        self.passes, self.graph = passes, passes.graph
        self.scalars = Scalars(passes.graph)
        self.reals = reals

    def whole(self) -> str:
        """The whole text."""
        forth, back, both = self._forth(), self._back(), self._both()
        turned = [sines()] if self.scalars.turns else []
        return "\n".join([_HEAD, *turned, forth, back, both])

    def _forth(self) -> str:
        one, passes = self.scalars, self.passes
        one.begin()
        self._inputs("p")
        roots = [*(c.after for c in passes.carried), *passes.kept, *passes.stored]
        self._steady(roots)
        for k, cell in enumerate(passes.carried):
            kind = self.graph.nodes[cell.input].kind
            one.lines.append(f"{type_of(kind, 'double')} S{k} = {read(kind, f'state[{k}]')};")
        before = self._taken()
        self._inputs("u")
        for k, cell in enumerate(passes.carried):
            one.names[cell.input] = f"s{k}"
            kind = self.graph.nodes[cell.input].kind
            one.lines.append(f"const {type_of(kind, 'double')} s{k} = S{k};")
        one.state(self.graph.reached(roots))
        sample = self._taken()
        return _FORTH.format(
            before=indent(before, "    "),
            sample=indent(sample, " " * 8),
            stored=indent(self._written("store", passes.stored), " " * 12),
            stores=len(passes.stored),
            kept=indent(self._written("kept", passes.kept), " " * 12),
            keeps=len(passes.kept),
            after="\n".join(
                f"        S{k} = {one.name(cell.after)};" for k, cell in enumerate(passes.carried)
            ),
            end="\n".join(f"    state[{k}] = S{k};" for k in range(len(passes.carried))),
        )

    def _back(self) -> str:
        one, passes, nodes = self.scalars, self.passes, self.graph.nodes
        one.begin()
        self._inputs("p", "e")
        roots = [*(c.after for c in passes.weights), *passes.slopes.values()]
        order = self._reached_back(roots)
        self._steady(order)
        one.lines += [f"double W{k} = weight[{k}];" for k in range(len(passes.weights))]
        one.lines += [f"double D{k} = slope[{k}];" for k in range(len(passes.slopes))]
        before = self._taken()
        self._inputs("u", "v")
        for k, entry in enumerate(passes.stored):
            one.names[entry], kind = f"r{k}", nodes[entry].kind
            one.lines.append(f"const {type_of(kind, 'double')} r{k} = {read(kind, f'store[{k}]')};")
        for k, cell in enumerate(passes.weights):
            one.names[cell.input] = f"w{k}"
            one.lines.append(f"const double w{k} = W{k};")
        one.state(order)
        one.lines += [f"D{k} += {one.name(by)};" for k, by in enumerate(passes.slopes.values())]
        one.lines += [f"W{k} = {one.name(c.after)};" for k, c in enumerate(passes.weights)]
        sample = self._taken()
        ends = [f"weight[{k}] = W{k};" for k in range(len(passes.weights))]
        ends += [f"slope[{k}] = D{k};" for k in range(len(passes.slopes))]
        return _BACK.format(
            before=indent(before, "    "),
            sample=indent(sample, " " * 8),
            end="\n".join(f"    {line}" for line in ends),
            reals=self.reals,
            stores=len(passes.stored),
        )

    def _both(self) -> str:
        one, passes = self.scalars, self.passes
        one.begin()
        self._inputs("p")
        starts = [cell.start for cell in passes.carried]
        one.state(self.graph.reached(starts))
        start = self._taken()
        states = "".join(f"(double){one.name(k)}, " for k in starts)
        for k, cell in enumerate(passes.carried):
            one.names[cell.input] = f"state[{k}]"
        total = self._written("end", passes.total)
        ends = [cell.start for cell in passes.weights]
        derivatives = {k for k, node in enumerate(self.graph.nodes) if node.op == "input"}
        one.names |= {
            k: f"e[{self.graph.nodes[k].value[1]}]"
            for k in derivatives
            if self.graph.nodes[k].value[0] == "e"
        }
        weights = "".join(f"{one.name(k)}, " for k in ends)
        one.names |= {cell.input: f"weight[{k}]" for k, cell in enumerate(passes.weights)}
        out = [f"    out[{k}] = slope[{n}];" for n, k in enumerate(passes.slopes)]
        out += [f"    out[{k}] = {one.name(by)};" for k, by in passes.begun.items()]
        return _WHOLE.format(
            start=indent(start, "    "),
            states=states,
            carried=len(passes.carried),
            keeps=len(passes.kept),
            total=indent(total, "    "),
            weights=weights,
            slopes=max(1, len(passes.slopes)),
            reals=self.reals,
            out="\n".join(out),
        )

    def _inputs(self, *groups: str) -> None:
        """Statements that read inputs."""
        one = self.scalars
        for k, node in enumerate(self.graph.nodes):
            if node.op == "input" and node.value[0] in groups:
                group, number = node.value
                one.names[k] = f"{group}{number}"
                place = read(node.kind, f"{group}[{number}]")
                one.lines.append(f"const {type_of(node.kind, 'double')} {group}{number} = {place};")

    def _steady(self, roots: Iterable[int]) -> None:
        """Statements for what follows from named numbers alone, before the loop."""
        known = set(self.scalars.names)
        order = []
        for k in self.graph.reached(roots):
            node = self.graph.nodes[k]
            if k in known or node.op == "constant":
                known.add(k)
            elif node.op != "input" and known.issuperset(node.args):
                known.add(k)
                order.append(k)
        self.scalars.state(order)

    def _reached_back(self, roots: Iterable[int]) -> list[int]:
        """What the pass back computes, with its inputs."""
        stored, seen, open_ = set(self.passes.stored), set[int](), list(roots)
        while open_:
            k = open_.pop()
            if k not in seen:
                seen.add(k)
                open_ += () if k in stored else self.graph.nodes[k].args
        return sorted(seen - stored)

    def _taken(self) -> str:
        """The statements so far, which are no longer kept."""
        lines, self.scalars.lines = self.scalars.lines, []
        return "\n".join(lines)

    def _written(self, where: str, entries: Sequence[int]) -> str:
        names = map(self.scalars.name, entries)
        return "\n".join(f"{where}[{k}] = (double){name};" for k, name in enumerate(names))
