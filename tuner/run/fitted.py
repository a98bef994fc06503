"""A fit from Python: a filter and a recording go in, a tuned filter comes out."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tuner import export
from tuner.certificate.solution import Solution
from tuner.certificate.table import as_html
from tuner.data.record import Record
from tuner.problem.kept_programs import forget_old_ones
from tuner.run.exports import tuned_of
from tuner.run.filter_choice import Model, choose_filter
from tuner.run.fit import Request, asked_for, concluded, plan_fit, pose_on
from tuner.run.fit_problem import Posed
from tuner.run.front import in_order, posed_against
from tuner.run.judgement import Judged
from tuner.run.save import Made, save
from tuner.run.search_space import Wishes
from tuner.run.split import HeldOutBy
from tuner.run.summary import five_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from tuner.code.literal import Precision


@dataclass(frozen=True, eq=False)
class Fit:
    """A filter tuned on a recording.

    Attributes:
        posed: the problem and its data.
        solution: the tuned values with their certificate.
        judged: what they are worth.
        made: how it came about.
    """

    posed: Posed
    solution: Solution
    judged: Judged
    made: Made

    @property
    def params(self) -> Any:
        """The filter's parameters, as its ``init`` and ``step`` take them."""
        return self.posed.problem.params(self.solution)

    @cached_property
    def outputs(self) -> Any:
        """The tuned filter's outputs over the recording, time first."""
        return self.posed.problem.outputs(self.solution)

    def summary(self) -> str:
        """Five lines: use these numbers, how good, why trust them, what is open, what next."""
        return "\n".join(five_lines(self.posed, self.solution, self.judged, folder=False))

    def plot(self) -> "Canvas":
        """A picture: what was measured and estimated, the innovations, and held-out data.

        Returns:
            A figure of matplotlib, with ``savefig(file)``; a notebook shows it.
        """
        from tuner.run.fit_plot import plotted

        return plotted(self.posed, self.made.solutions, self.judged)

    def save(self, folder: str | Path, *, force: bool = False) -> Path:
        """Write the folder that the command line writes: result, recipe, exports and pictures.

        ``tuner run FOLDER/study.toml`` runs it again, ``tuner check FOLDER`` tries its values on
        another recording. A recording that was arrays is written beside the recipe.

        Args:
            folder: where to; made whole or not at all.
            force: whether files that are there may be replaced.

        Raises:
            ValueError: where the folder holds files.
        """
        return save(self.made, Path(folder), force=force)

    def export(
        self,
        format: str,
        path: str | Path | None = None,
        *,
        force: bool = False,
        precision: "Precision" = "double",
        tunable: bool = False,
    ) -> str | bytes | Path:
        """The tuned filter in one of the formats of ``tuner list formats``.

        Args:
            format: such as ``"c"`` or ``"json"``.
            path: the file to write, which is read back, and for C the source and a self-test beside
                it; None returns what it would hold, for C the header and then the source.
            force: whether a file that is there may be replaced, and what did not converge exported.
            precision: of the numbers of C.
            tunable: whether parameters of C can be set as it runs.

        Returns:
            Text, or the bytes of a format that is none; the path where one was given.

        Raises:
            ValueError: for an unknown format, a solution that did not converge, a file that is
                there, and a filter that C has no counterpart for.
        """
        status = self.solution.status
        if not status.trusted and not force:
            raise ValueError(
                f"the solution is {status.value!r}, not converged; force=True exports it anyway"
            )
        problem, source = self.posed.problem, self.posed.source
        tuned = tuned_of(problem, self.solution, "fit", self.made.seed, problem.source or source)
        if format == "c":
            from tuner.run.code_files import Variant, write
            from tuner.run.machine import code_of

            include = f"{tuned.name}.h" if path is None else Path(path).name
            trials = problem.on_machine(self.solution)
            files = code_of(tuned, trials, Variant(precision, tunable), include).files
            if path is None:
                return files.whole
            write(files, Path(path), overwrite=force)
            export.read_back(tuned, path, format)
            return Path(path)
        if path is not None:
            export.write(tuned, path, format, overwrite=force)
            export.read_back(tuned, path, format)
            return Path(path)
        data = export.dump(tuned, format)
        return data.decode() if export.is_text(format) else data

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        return "\n".join([repr(self.solution), *self._lines()])

    def _repr_html_(self) -> str:
        lines = "".join(f"<li>{escape(' '.join(line.split()))}</li>" for line in self._lines())
        return f"{as_html(self.solution)}<ul>{lines}</ul>"

    def _lines(self) -> list[str]:
        """The summary without its numbers, which the table holds."""
        return self.summary().splitlines()[1:]


def fit(
    filter: Model,
    record: Record | Iterable[Record],
    *,
    start: Mapping[str, float] | None = None,
    fix: Mapping[str, float] | None = None,
    bound: Mapping[str, tuple[float, float]] | None = None,
    options: Mapping[str, Any] | None = None,
    objective: str | None = None,
    solver: str = "l-bfgs-b",
    starts: int = 4,
    seed: int = 0,
    hold_out: bool = True,
    held_out: HeldOutBy | None = None,
    against: str | None = None,
) -> Fit:
    """Tune a filter on a recording, or on several with one set of numbers for all.

    With a truth the filter's error is minimised, without one the likelihood of its innovations.

    Args:
        filter: a name of ``tuner list filters``, a class that declares its facts, FILE.py:CLASS,
            or a model: the path of its TOML file, or what that holds.
        record: recordings in SI (:func:`tuner.read_record`, :meth:`tuner.Record.of`).
        start: where the search begins, by parameter.
        fix: parameters that are held, and at what.
        bound: the ends of the search, by parameter.
        options: fields of the filter's class.
        objective: of ``tuner list objectives``.
        solver: of ``tuner list solvers``.
        starts: of the search.
        seed: where the random ones come from.
        hold_out: whether a second fit on a part of the data is judged on the rest.
        held_out: which part that is: the end of the ``time``, some whole recordings
            (``recording``), each in turn (``leave-one-out``), ``none``; None decides by what
            there is.
        against: a second objective, of ``tuner list objectives``: the front of both, with its knee,
            stands in ``judged.trade``.

    Raises:
        ValueError: for what does not go together, in one sentence with the way out.

    >>> import numpy as np
    >>> rng = np.random.default_rng(1)
    >>> level = np.cumsum(0.1 * rng.standard_normal(400))
    >>> record = Record.of({"z": level + rng.standard_normal(400)}, rate_hz=1.0)
    >>> found = fit("local-level", record, starts=1, hold_out=False)
    >>> 0.8 < float(found.solution.parameters["R"].value) < 1.2
    True
    """
    forget_old_ones()
    objective, against = in_order(objective, against)
    wishes = Wishes(start or {}, fix or {}, bound or {}, options or {}, objective)
    choice = choose_filter(filter)
    records = (record,) if isinstance(record, Record) else tuple(record)
    begun = time.perf_counter()
    posed = pose_on(choice.name, choice.cls, records, wishes)
    other = (
        None if against is None else posed_against(choice.name, choice.cls, posed, wishes, against)
    )
    request = Request(solver, starts, seed, "", asked_for(hold_out, held_out))
    plan = plan_fit(posed, request, other)
    solved = {(t.problem.name, t.solver.name): t.solver(t.problem) for t in plan.tasks}
    found = concluded(plan.case, solved)
    settings = {
        **choice.settings,
        **{name: dict(getattr(wishes, name)) for name in ("start", "fix", "bound", "options")},
        "objective": objective,
        "solver": solver,
        "starts": starts,
        "hold_out": hold_out,
        "held_out": held_out,
        "against": against,
    }
    made = Made(settings, seed, plan, solved, records, time.perf_counter() - begun)
    return Fit(posed, found.solution, found.judged, made)
