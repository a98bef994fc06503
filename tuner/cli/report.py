"""tuner report: a finished run as a page, again; or as Markdown or PDF."""

import sys
from collections.abc import Callable
from pathlib import Path

from tuner.atomic import write_bytes
from tuner.names import unknown
from tuner.run.folder import RunFolder

_FORMS = {"html": ".html", "md": ".md", "pdf": ".pdf"}


def write(run: Path, to: str | None, output: str | None, *, force: bool) -> None:
    """Write the report of a run and say where; ``-`` is stdout.

    Raises:
        ValueError: for an unknown form, a folder of no finished run, and a file that is there.
    """
    form = to or _form_of(output)
    if form not in _FORMS:
        raise unknown("form", form, _FORMS)
    data = _MAKERS[form](run)
    if output == "-":
        sys.stdout.buffer.write(data)
        sys.stdout.flush()
        return
    if output is not None:
        write_bytes(Path(output), data, overwrite=force)
        print(output)
        return
    folder = run if run.is_dir() else run.parent
    name = f"report{_FORMS[form]}"  # the run's own page may always be written again
    RunFolder(folder, overwrite=force).write(name, data, replace=form == "html")
    print(folder / name)


def _form_of(output: str | None) -> str:
    ends = {end: form for form, end in _FORMS.items()}
    return ends.get(Path(output or "").suffix, "html")


def _html(run: Path) -> bytes:
    from tuner.report.write import page_again

    return page_again(run)


def _md(run: Path) -> bytes:
    from tuner.report.markdown import markdown
    from tuner.report.write import report_again

    folder = run if run.is_dir() else run.parent
    return markdown(report_again(run), {file.stem for file in folder.glob("figures/*.png")})


def _pdf(run: Path) -> bytes:
    from tuner.report.pdf import pdf

    return pdf(_html(run))


_MAKERS: dict[str, Callable[[Path], bytes]] = {"html": _html, "md": _md, "pdf": _pdf}
