"""The check of a model's equations against the given units."""

from collections.abc import Mapping, Sequence

from tuner.model import dimension as d
from tuner.model.description import Model
from tuner.model.dimension import BARE, SECOND, Dimension, Dimensions
from tuner.model.entries import Entries
from tuner.model.expression import Node, Number
from tuner.model.findings import Findings
from tuner.model.lines import Path
from tuner.model.quantities import dimension


def check_units(model: Model, entries: Entries, findings: Findings) -> None:
    """Add errors for sums of different units, and for equations whose two sides differ.

    A lone number in a matrix may stand for any unit, and so may what has no unit.
    """
    _Check(model, entries, findings).all()


class _Check:
    def __init__(self, model: Model, entries: Entries, findings: Findings) -> None:
        self.model, self.written, self.findings = model, entries.written, findings
        self.states = {state.name: dimension(state.unit) for state in model.states}
        self.known: dict[str, Dimension | None] = {"dt": SECOND, **self.states}
        self.known |= {each.name: dimension(each.unit) for each in model.parameters}
        for each in model.inputs:
            self.known |= dict.fromkeys(each.symbols, dimension(each.unit))
        self.measured = [dimension(group.unit) for group in model.groups for _ in group.symbols]
        self.per_step = BARE if model.time == "discrete" else SECOND

    def all(self) -> None:
        """Check every entry by itself, then against the quantity it stands for."""
        self.of = {path: self._dimension(path, node) for path, node in self.written.items()}
        names = self.model.state_names
        self._vector(("model", "f"), names, self._rates())
        self._matrix(("model", "A"), self._rates(), list(self.states.values()))
        self._matrix(("model", "F"), self._rates(), list(self.states.values()))
        pushes = [dimension(each.unit) for each in self.model.inputs for _ in each.symbols]
        self._matrix(("model", "B"), self._rates(), pushes)
        self._vector(("model", "x0"), names, list(self.states.values()))
        self._square(("model", "P0"), names, list(self.states.values()), BARE)
        self._measurements()
        self._noise()

    def _dimension(self, path: Path, node: Node) -> Dimension | None:
        if isinstance(node, Number):
            return None
        return Dimensions(self.known, lambda fault: self.findings.add(path, fault)).of(node)

    def _rates(self) -> list[Dimension | None]:
        return [
            None if each is None else d.times(each, self.per_step, -1)
            for each in self.states.values()
        ]

    def _measurements(self) -> None:
        states = list(self.states.values())
        symbols = [symbol for group in self.model.groups for symbol in group.symbols]
        self._vector(("model", "h"), symbols, self.measured)
        self._square(("model", "R"), symbols, self.measured, BARE)
        for key in ("H", "C"):
            self._matrix(("model", key), self.measured, states)
        for group in self.model.groups:
            path, own = ("measurements", group.name), [dimension(group.unit)] * len(group.symbols)
            axes = group.axes or (group.name,)
            self._vector((*path, "h"), axes, own)
            self._square((*path, "R"), axes, own, BARE)
            for key in ("H", "C"):
                self._matrix((*path, key), own, states)

    def _noise(self) -> None:
        """Check each noise by the states that it enters; an entry of 1 in G has no unit."""
        path: Path = ("model", "Q")
        states = list(self.states.values())
        if not any(place[:2] == ("model", "G") for place in self.written):
            self._square(path, self.model.state_names, states, self.per_step)
            return
        entering: list[Dimension | None] = []
        for k in range(len(self.model.Q)):
            entering.append(self._entering(k, states))
        self._square(path, [f"w{k + 1}" for k in range(len(entering))], entering, self.per_step)

    def _entering(self, k: int, states: Sequence[Dimension | None]) -> Dimension | None:
        """The unit of a noise in which its square is a density: from the first state it enters."""
        found: Dimension | None = None
        for i, state in enumerate(states):
            node = self.written.get(("model", "G", i, k))
            if state is None or node is None or node == Number(0.0):
                continue
            gain = BARE if node == Number(1.0) else self.of[("model", "G", i, k)]
            if gain is None:
                continue
            own = d.times(state, gain, -1)
            if found is not None and own != found:
                self.findings.add(
                    ("model", "G", i, k),
                    f"makes noise {k + 1} one in {d.words(own)}, and the rows above one in "
                    f"{d.words(found)}",
                )
            found = own if found is None else found
        return found

    def _vector(self, path: Path, names: Sequence[str], wanted: Sequence[Dimension | None]) -> None:
        for i, (name, unit) in enumerate(zip(names, wanted, strict=True)):
            for place in ((*path, name), (*path, i), path):
                if place in self.of:
                    self._same(place, self.of[place], unit, name)
                    break

    def _matrix(
        self, path: Path, rows: Sequence[Dimension | None], columns: Sequence[Dimension | None]
    ) -> None:
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                if row is not None and column is not None:
                    self._same((*path, i, j), self.of.get((*path, i, j)), d.times(row, column, -1))

    def _square(
        self,
        path: Path,
        names: Sequence[str],
        units: Sequence[Dimension | None],
        per: Dimension,
    ) -> None:
        """Check a covariance, over ``per``."""
        for i, one in enumerate(units):
            for j, other in enumerate(units):
                if one is None or other is None:
                    continue
                wanted = d.times(d.times(one, other), per, -1)
                self._same((*path, i, j), self.of.get((*path, i, j)), wanted)
                if i == j:
                    for place in ((*path, names[i]), (*path, i), path):
                        self._same(place, self.of.get(place), wanted, names[i])

    def _same(
        self, path: Path, found: Dimension | None, wanted: Dimension | None, of: str = ""
    ) -> None:
        if found is None or wanted is None or found == wanted:
            return
        key = next((part for part in reversed(path) if part in _WHAT), "")
        what = _WHAT[str(key)][self.model.time == "discrete"] if key else "the other side"
        named = f" of {of}" if of else ""
        self.findings.add(
            path, f"is in {d.words(found)}, and {what}{named} is in {d.words(wanted)}"
        )


_WHAT: Mapping[str, tuple[str, str]] = {
    "f": ("the rate", "the next value"),
    "A": ("such an entry", "such an entry"),
    "F": ("such an entry", "such an entry"),
    "B": ("such an entry", "such an entry"),
    "H": ("such an entry", "such an entry"),
    "C": ("such an entry", "such an entry"),
    "G": ("such an entry", "such an entry"),
    "h": ("the measurement", "the measurement"),
    "R": ("the variance", "the variance"),
    "P0": ("the variance", "the variance"),
    "x0": ("the start", "the start"),
    "Q": ("the spectral density", "the variance a sample"),
}
