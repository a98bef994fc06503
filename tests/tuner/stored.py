"""Programs and texts that are kept between runs, in tests."""

from tuner import stored_programs


def forget():
    """Forget what a process remembers of its folder and its surroundings."""
    stored_programs._trusted.cache_clear()
    stored_programs._surroundings.cache_clear()
