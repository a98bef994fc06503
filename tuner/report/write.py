"""A run's report as files in its folder."""

from pathlib import Path

from pydantic import ValidationError

from tuner.report.blocks import Report
from tuner.report.document import report_of
from tuner.report.page import page
from tuner.report.report_json import Kept, nothing_kept
from tuner.run.result import Result, read_result

KEPT, PAGE = "report.json", "report.html"


def page_of(result: Result, kept: Kept, folder: Path) -> bytes:
    """The HTML file of a run whose files are in a folder."""
    return page(report_of(result, kept, folder))


def read_kept(folder: Path) -> Kept:
    """The contents that a run kept for its report; empty where an earlier version wrote it.

    Raises:
        ValueError: where it is not what a run writes.
    """
    try:
        return Kept.model_validate_json((folder / KEPT).read_bytes())
    except FileNotFoundError:
        return nothing_kept()
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise ValueError(f"{KEPT} is not what a run writes: {where}: {first['msg']}") from None
    except OSError as error:
        raise ValueError(f"{folder / KEPT} cannot be read: {error.strerror}") from None


def report_again(path: Path) -> Report:
    """The report of a finished run, from what is in its folder.

    Raises:
        ValueError: where that is no folder of a finished run.
    """
    result = read_result(path)
    folder = path if path.is_dir() else path.parent
    return report_of(result, read_kept(folder), folder)


def page_again(path: Path) -> bytes:
    """The HTML file of a finished run, from what is in its folder.

    Raises:
        ValueError: where that is no folder of a finished run.
    """
    return page(report_again(path))
