"""The files of a run's figures: a picture and a table each."""

from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass, field

from tuner.run.drawing import table
from tuner.run.figure import Figure
from tuner.run.folder import RunFolder
from tuner.run.painter import Painter
from tuner.run.progress import Progress
from tuner.run.threads import at_once


@dataclass(frozen=True)
class FigureFiles:
    """The figures of a run.

    Attributes:
        figures: those that were drawn.
        files: their files.
        failed: why others are missing, a sentence each.
    """

    figures: list[Figure] = field(default_factory=list)
    files: list[str] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)


def draw_figures(
    folder: RunFolder,
    figures: Callable[[], Iterable[Figure]],
    progress: Progress,
    painter: Painter,
) -> FigureFiles:
    """Draw figures and write them; one that fails ends no run.

    Each is drawn while the next one is made, or as many as there are processes that draw.

    Args:
        folder: of the run.
        figures: makes them, one after another.
        progress: told of every figure.
        painter: draws them.

    Raises:
        WriteError: where a file cannot be written.
    """
    written, begun = FigureFiles(), list[tuple[Figure, Future[dict[str, bytes]]]]()
    broken = list[str]()
    with at_once(max(painter.processes, 1)) as pool:
        try:
            for figure in figures():
                progress(f"drawing {figure.name}", 1, 4)
                begun.append((figure, pool.submit(_files, figure, painter)))
        except Exception as error:
            broken.append(f"a figure could not be drawn: {_in_words(error)}")
        for figure, drawing in begun:
            try:
                made = drawing.result()
            except Exception as error:
                written.failed.append(f"{figure.name} could not be drawn: {_in_words(error)}")
                continue
            written.files.extend(folder.write_all(made))
            written.figures.append(figure)
    written.failed.extend(broken)
    return written


def _files(figure: Figure, painter: Painter) -> dict[str, bytes]:
    stem = f"figures/{figure.name}"
    return {f"{stem}.csv": table(figure), f"{stem}.png": painter.picture(figure)}


def _in_words(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
