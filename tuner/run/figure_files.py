"""The files of a run's figures: a picture and a table each."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from tuner.atomic import WriteError
from tuner.run.drawing import picture, table
from tuner.run.figure import Figure
from tuner.run.folder import RunFolder
from tuner.run.progress import Progress


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
    picture: Callable[[Figure], bytes] = picture,
) -> FigureFiles:
    """Draw figures and write them; one that fails ends no run.

    Args:
        folder: of the run.
        figures: makes them, one after another.
        progress: told of every figure.
        picture: a figure as a PNG.

    Raises:
        WriteError: where a file cannot be written.
    """
    written = FigureFiles()
    try:
        for figure in figures():
            progress(f"drawing {figure.name}", 1, 4)
            try:
                made = {"csv": table(figure), "png": picture(figure)}
            except Exception as error:
                written.failed.append(f"{figure.name} could not be drawn: {_in_words(error)}")
                continue
            stem = f"figures/{figure.name}"
            written.files.extend(folder.write_all({f"{stem}.{end}": made[end] for end in made}))
            written.figures.append(figure)
    except WriteError:
        raise
    except Exception as error:
        written.failed.append(f"a figure could not be drawn: {_in_words(error)}")
    return written


def _in_words(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
