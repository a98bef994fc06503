"""Commented models as templates."""

from importlib.resources import files

from tuner.names import unknown

KINDS = ("level", "tracking", "robot", "pendulum")


def template(kind: str) -> str:
    """A commented model document.

    Args:
        kind: one of :data:`KINDS`.

    Raises:
        ValueError: for any other, with the near ones.

    >>> template("level").splitlines()[0]
    '# A level that wanders, measured with noise: the Kalman filter of one state.'
    """
    if kind not in KINDS:
        raise unknown("kind of model", kind, KINDS)
    return (files("tuner.model") / "examples" / f"{kind}.toml").read_text(encoding="utf-8")
