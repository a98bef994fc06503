"""Both passes over a record in C, scalar by scalar."""

from collections.abc import Iterable, Sequence

from tuner.code.literal import type_of
from tuner.compiler import options_of_scalars
from tuner.native.loop import Carried
from tuner.native.passes import IN_ORDER, Passes
from tuner.native.passes_frame import APART, Around, Back, Code, Forth, Sizes, framed
from tuner.native.scalars import Scalars, read
from tuner.native.schedule import scheduled
from tuner.native.sines import sines

SMALL = 4000
"""Operations up to which the pass over a record is compiled twice: with what it stores, and without
it, for values alone."""


def code(passes: Passes, reals: Sequence[bool]) -> Code:
    """The C of both passes.

    Args:
        passes: both passes.
        reals: which of the kept values have derivatives.
    """
    sizes = Sizes(
        len(passes.carried),
        len(passes.stored),
        len(passes.kept),
        sum(reals),
        len(passes.slopes),
    )
    writer = _Writer(passes)
    forth, back, around = writer.forth(), writer.back(), writer.around()
    functions = sines() if writer.scalars.turns else ""
    text = framed(functions, sizes, forth, back, around)
    counts = sizes.carried, sizes.stored, len(passes.total), sizes.kept, passes.operations
    in_order = passes.operations <= IN_ORDER
    options = options_of_scalars(few=_is_small(passes), in_order=in_order)
    return Code(text, *counts, options=options)


def _is_small(passes: Passes) -> bool:
    """Whether a compiler takes little time for the pass over a record: it gets it twice."""
    return passes.operations <= SMALL


class _Writer:
    def __init__(self, passes: Passes) -> None:
        self.passes, self.graph = passes, passes.graph
        self.scalars = Scalars(passes.graph)

    def forth(self) -> Forth:
        """The pass over a record."""
        one, carried = self.scalars, self.passes.carried
        one.begin()
        self._inputs("p")
        roots = [*(c.after for c in carried), *self.passes.kept, *self.passes.stored]
        self._steady(roots)
        for k, cell in enumerate(carried):
            kind = self.graph.nodes[cell.input].kind
            one.lines.append(f"{type_of(kind, 'double')} S{k} = {read(kind, f'state[{k}]')};")
        before = self._taken()
        self._inputs("u")
        for k, cell in enumerate(carried):
            one.names[cell.input] = f"s{k}"
            kind = self.graph.nodes[cell.input].kind
            one.lines.append(f"const {type_of(kind, 'double')} s{k} = S{k};")
        stores = dict[int, str]()
        for k, entry in enumerate(self.passes.stored):
            stores[entry] = f"if (storing) store[{k}] = (double)"
        one.lines += [f"{text}{one.name(k)};" for k, text in stores.items() if k in one.names]
        then = {k: f"{text}t{k};" for k, text in stores.items()}
        one.state(self._in_order(self.graph.reached(roots), carried, self.passes.kept), then)
        return Forth(
            before,
            self._taken(),
            "",
            self._written("kept", self.passes.kept),
            "\n".join(f"S{k} = {one.name(cell.after)};" for k, cell in enumerate(carried)),
            "\n".join(f"state[{k}] = S{k};" for k in range(len(carried))),
            "inline __attribute__((always_inline))" if _is_small(self.passes) else APART,
        )

    def back(self) -> Back:
        """The pass back."""
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
        one.state(self._in_order(order, passes.weights, passes.slopes.values()))
        one.lines += [f"D{k} += {one.name(by)};" for k, by in enumerate(passes.slopes.values())]
        one.lines += [f"W{k} = {one.name(c.after)};" for k, c in enumerate(passes.weights)]
        ends = [f"weight[{k}] = W{k};" for k in range(len(passes.weights))]
        ends += [f"slope[{k}] = D{k};" for k in range(len(passes.slopes))]
        return Back(before, self._taken(), "\n".join(ends))

    def around(self) -> Around:
        """The statements around both."""
        one, passes, nodes = self.scalars, self.passes, self.graph.nodes
        one.begin()
        self._inputs("p")
        starts = [cell.start for cell in passes.carried]
        one.state(self.graph.reached(starts))
        numbers = "".join(f"(double){one.name(k)}, " for k in starts)
        one.lines.append(f"double state[] = {{{numbers}0.0}};")
        state = self._taken()
        one.names |= {cell.input: f"state[{k}]" for k, cell in enumerate(passes.carried)}
        total = self._written("end", passes.total)
        ends = {k: n.value[1] for k, n in enumerate(nodes) if n.op == "input" and n.value[0] == "e"}
        one.names |= {k: f"e[{number}]" for k, number in ends.items()}
        weights = "".join(f"{one.name(cell.start)}, " for cell in passes.weights)
        one.names |= {cell.input: f"weight[{k}]" for k, cell in enumerate(passes.weights)}
        out = [f"out[{k}] = slope[{n}];" for n, k in enumerate(passes.slopes)]
        out += [f"out[{k}] = {one.name(by)};" for k, by in passes.begun.items()]
        return Around(state, total, f"double weight[] = {{{weights}0.0}};", "\n".join(out))

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
        """The nodes of the pass back, with its inputs."""
        stored, seen, open_ = set(self.passes.stored), set[int](), list(roots)
        while open_:
            k = open_.pop()
            if k not in seen:
                seen.add(k)
                open_ += () if k in stored else self.graph.nodes[k].args
        return sorted(seen - stored)

    def _in_order(
        self, nodes: Iterable[int], carried: Iterable[Carried], ends: Iterable[int]
    ) -> list[int]:
        """Those of a sample's nodes that have no name yet, in the order of their statements."""
        names, graph = self.scalars.names, self.graph
        known = ("constant", "input")
        rest = [k for k in nodes if k not in names and graph.nodes[k].op not in known]
        if self.passes.operations > IN_ORDER:
            return rest
        return scheduled(graph, rest, [(cell.input, cell.after) for cell in carried], ends)

    def _taken(self) -> str:
        """The statements so far, which are no longer kept."""
        lines, self.scalars.lines = self.scalars.lines, []
        return "\n".join(lines)

    def _written(self, where: str, entries: Sequence[int]) -> str:
        names = map(self.scalars.name, entries)
        return "\n".join(f"{where}[{k}] = (double){name};" for k, name in enumerate(names))
