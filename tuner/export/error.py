"""The error of this package."""


class ExportError(ValueError):
    """A tuned filter that cannot be written or read, told in one sentence.

    Example:
        >>> raise ExportError("there is no format 'xml'; there are json, toml")
        Traceback (most recent call last):
        tuner.export.error.ExportError: there is no format 'xml'; there are json, toml
    """
