"""Steps in which a wrong constant shows: a search from states near a filter's own and far off."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tuner.code.array_step import Step
from tuner.code.batches import batches
from tuner.code.chosen import Chosen
from tuner.code.detection import largest_moves
from tuner.code.expected import LONG, SAFE, SAFELY, comparable, expected, with_others
from tuner.code.faint import Faint
from tuner.code.hidden import Hidden
from tuner.code.mutants import Mutant
from tuner.code.shown import Shown, by_changes, by_derivatives
from tuner.code.states import Around, Arrays, by_node, rounded
from tuner.code.together import Inverses, Together
from tuner.code.variations import varied

_ROUNDS, _CHILDREN, _TIMES = 24, 16, 3
"""How often the steps of constants that hardly show are varied, the number from each, and how often
their rounding is measured."""
Results: TypeAlias = Callable[[Arrays, Arrays], Sequence[np.ndarray]]
"""The roots of steps from states and samples, ``(roots, B)``, by each half of symmetric ones."""


@dataclass(frozen=True, eq=False)
class Found:
    """Single steps in which constants show.

    Attributes:
        states, samples: a field each, ``(C, ...)``.
        chosen: the same, with what shows in each.
        tried: number of states that were looked at.
        idle: constants that had no effect in any of them: not even doubled, or in a long step by
            their derivatives.
        faint: constants that show in some of them, if at all.
    """

    states: Arrays
    samples: Arrays
    chosen: Chosen
    tried: int
    idle: set[Mutant]
    faint: list[Mutant]


@dataclass(frozen=True, eq=False)
class Before:
    """What a search of the same step in another precision found.

    Attributes:
        states, samples: its steps, a field each, ``(C, ...)``.
        tried, idle: as of :class:`Found`.
        undetected: constants that show in none of its steps.
        formulas: operations of a step, in order.
    """

    states: Arrays
    samples: Arrays
    tried: int
    idle: set[Mutant]
    undetected: Sequence[Mutant]
    formulas: Sequence[str]

    def beside(self, drawn: tuple[Arrays, Arrays]) -> tuple[Arrays, Arrays]:
        """Its steps with those that were drawn, states and samples."""
        return _joined(self.states, drawn[0]), _joined(self.samples, drawn[1])

    def given_up(self, step: Step) -> set[Mutant]:
        """The constants of a step that are not looked for again: none where its formulas differ."""
        return set(self.undetected if self.formulas == formulas(step) else ())


def search(step: Step, around: Around, by_jax: Results, before: Before | None = None) -> Found:
    """Steps that together show as many constants as can be.

    Args:
        step: the filter's.
        around: where states are drawn.
        by_jax: JAX's results of steps, with which those of a long step have to agree.
        before: what was found in another precision. Its steps are looked at with the first, and
            where the formulas are the same, what did not show is not looked for.
    """
    draw, tried, chosen = np.random.default_rng(0), 0, Chosen()
    given_up = before.given_up(step) if before else set[Mutant]()
    program, hidden, faint = step.program, Hidden(step, given_up), Faint()
    together, inverses = Together(step), Inverses(step)
    for drawn, beside in batches(step, around, draw, hidden):
        if not hidden.mutants:
            break
        looked_at = before.beside(drawn) if before and not tried else drawn
        states, samples = (rounded(part, program.precision) for part in looked_at)
        given = by_node(program, states, samples)
        tried += len(next(iter(given.values()), ()))
        if len(step.order) > LONG:
            right = expected(step, given, draw)
            right = with_others(step, right, by_jax(states, samples), SAFELY)
            good = comparable(step, right)
            if not good.any():
                continue
            right = right.of(good)
            states, samples = ([x[good] for x in part] for part in (states, samples))
            shown = by_derivatives(step, right, hidden, draw, together, beside)
            together.take([*states, *samples], shown.also)
            if beside:
                inverses.look(right, [*states, *samples], shown.also)
        else:
            shown = by_changes(step, given, hidden, draw)
        faint.look(shown.moved, [*states, *samples])
        _take(chosen, hidden, shown, [*states, *samples])
        if len(step.order) <= LONG:
            hidden.leave_proven()

    if len(step.order) <= LONG:
        faint.leave(hidden.mutants)
        faint = _improved(step, faint, draw)
    faint.leave(hidden.mutants)
    _take_rest(chosen, inverses, together, faint)
    whole, fields = _by_fields(step, chosen.steps), len(program.state)
    parts = whole[:fields], whole[fields:]
    # Of those given up the other search tried each in its steps, of the rest this one.
    tried = min(tried, before.tried) if before and given_up else tried
    idle = hidden.idle | (before.idle & given_up if before else set())
    return Found(*parts, chosen, tried, idle, faint.mutants)


def _joined(some: Arrays, others: Arrays) -> Arrays:
    return [np.concatenate(both) for both in zip(some, others, strict=True)]


def formulas(step: Step) -> list[str]:
    """The operations of a step, in order: the same in both precisions, but for rounding."""
    return [step.graph.nodes[k].op for k in step.order]


def _improved(step: Step, faint: Faint, draw: np.random.Generator) -> Faint:
    """The same constants in steps that were varied; what counts is the least of several moves.

    The tolerance follows from random errors: the best of many steps would be one in which they
    happened to be small.
    """
    program, own, found = step.program, len(step.program.state), Faint()
    steps = _by_fields(step, faint.steps)
    for turn in range(_ROUNDS if faint.mutants else 0):
        if turn and found.mutants:
            parents = _by_fields(step, found.steps)
            steps = varied(draw, [np.repeat(x, _CHILDREN, axis=0) for x in parents])
        steps = rounded(steps, program.precision)
        given = by_node(program, steps[:own], steps[own:])
        rights = [expected(step, given, draw, SAFE) for _ in range(_TIMES)]
        sizes = np.min([largest_moves(step, faint.mutants, right) for right in rights], axis=0)
        found.look(dict(zip(faint.mutants, sizes, strict=True)), steps)
    return found


def _take(chosen: Chosen, hidden: Hidden, shown: Shown, steps: Arrays) -> None:
    """Choose steps, a field each, until all is chosen that they show: that of the most first."""
    shows, used = shown.hidden, shown.used
    while shows.any() or used:
        best = int(shows.sum(axis=0).argmax()) if shows.any() else _commonest(used)
        own = [hidden.mutants[k] for k in np.flatnonzero(shows[:, best])]
        uses = [one for one, row in used.items() if row[best]]
        chosen.take([x[best] for x in steps], [*own, *shown.also(best)], [], uses)
        rest = np.logical_not(shows[:, best])
        hidden.leave(rest)
        hidden.uses.difference_update(uses)
        shows, used = shows[rest], {one: row for one, row in used.items() if not row[best]}


def _take_rest(chosen: Chosen, inverses: Inverses, together: Together, faint: Faint) -> None:
    """Choose what matters less than the constants that show alone."""
    for one, more in inverses.steps():
        chosen.take(one, more)
    for one, more, groups in together.steps():
        chosen.take(one, more, groups)
    for one in faint.steps:
        chosen.take(one)


def _commonest(shown: Mapping[Mutant, np.ndarray]) -> int:
    """The step in which most of these show."""
    return int(np.sum(list(shown.values()), axis=0).argmax())


def _by_fields(step: Step, chosen: list[Arrays]) -> Arrays:
    """Steps as an array for each field of the state, then of the inputs."""
    fields = [*step.program.state, *step.program.inputs]
    columns = ([one[k] for one in chosen] for k in range(len(fields)))
    return [
        np.array(column).reshape(len(chosen), *field.shape)
        for column, field in zip(columns, fields, strict=True)
    ]
