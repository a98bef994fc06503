"""The folders of compiled code between runs."""

import os
from pathlib import Path


def cache_folder() -> Path:
    """The folder of compiled code: ``TUNER_CACHE``, or the user's cache folder."""
    given = os.environ.get("TUNER_CACHE")
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(given) if given else Path(root) / "filter-tuner" / "jax"


def code_folder() -> Path:
    """The folder of compiled C: one in that of ``TUNER_CACHE``, or beside the user's."""
    folder = cache_folder()
    return (folder if os.environ.get("TUNER_CACHE") else folder.parent) / "native"
