"""The reader of model files: TOML, limited in size before it is read, checked before use."""

import re
import tomllib
from pathlib import Path
from typing import Any

from tuner.files import opened
from tuner.model.lines import Lines
from tuner.model.quantities import NAME
from tuner.model.reading import described
from tuner.model.size import LARGEST_FILE, check_size

_DEEP_KEY = re.compile(r"(?:[\w \t-]{0,80}\.){12}")
"""Deeply nested keys, which take the TOML parser quadratic time."""
_DEEP_LIST = re.compile(r"[\[{][\s\[{]{20}")


def read_model(path: Path) -> dict[str, Any]:
    """The document of a model file.

    A document without a name is given that of its file. Nothing in it is executed; it is no larger
    than :data:`tuner.model.size.LARGEST_FILE`.

    Args:
        path: the TOML file.

    Raises:
        ValueError: where it is missing, too large, not TOML, or not a model: all mistakes, with
            lines.

    >>> import tempfile
    >>> from tuner.model.template import template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "level.toml")
    ...     _ = path.write_text(template("level"))
    ...     sorted(read_model(path)["parameters"])
    ['R', 'q']
    """
    text = _text(Path(path))
    document = _parsed(text, path.name)
    check_size(document, path.name)
    if NAME.fullmatch(path.stem):
        document.setdefault("name", path.stem)
    described(document, Lines.of(text), path.name)
    plain: dict[str, Any] = _storable(document)
    return plain


def _storable(value: Any) -> Any:
    """The same with infinity as text, for a run's folder holds finite numbers only."""
    if isinstance(value, dict):
        return {key: _storable(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_storable(each) for each in value]
    return "inf" if value == float("inf") else value


def _text(path: Path) -> str:
    if not path.is_file():
        why = "is not a file" if path.exists() else "is not there"
        raise ValueError(f"{path} {why}; give a model in TOML, tuner init writes one to begin with")
    try:
        with opened(path) as stream:
            data = stream.read(LARGEST_FILE + 1)
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from None
    if len(data) > LARGEST_FILE:
        raise ValueError(
            f"{path.name} is larger than {LARGEST_FILE // 1000} kB, too much for a model; give "
            "names, matrices and expressions alone"
        )
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise ValueError(f"{path.name} is not text in UTF-8; save it as such") from None


def _parsed(text: str, name: str) -> dict[str, Any]:
    if _DEEP_KEY.search(re.sub(r'"[^"\n]*"|\'[^\'\n]*\'|#.*', "", text)) or _DEEP_LIST.search(text):
        raise ValueError(f"{name} has tables or lists far too deep for a model")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError(f"{name} has tables or lists far too deep for a model") from None
    except ValueError as error:
        if "integer string" in str(error):
            raise ValueError(f"{name} holds a number of thousands of digits; shorten it") from None
        raise ValueError(f"{name} is not TOML: {' '.join(str(error).split())}") from None
