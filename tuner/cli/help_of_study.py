"""tuner run STUDY --help: the settings of that study below the options of the command."""

from collections.abc import Sequence


def add_settings(arguments: Sequence[str]) -> None:
    """Print the settings of the study that the help of ``run`` was asked with, if there is one."""
    words = [word for word in arguments[1:] if not word.startswith("-")]
    if arguments[:1] != ["run"] or "--help" not in arguments or not words:
        return
    from tuner.cli.listed_settings import show_settings
    from tuner.run.study import study_names

    if words[0] in study_names():
        print()
        show_settings(words[0])
