"""Objectives by name, for a filter and a record: the values of ``--objective``.

Each is a function of the output that is judged: its name among the filter's outputs, "" where they
are one array; and its declared channel, None where there is no truth. Other packages add theirs to
the entry-point group ``tuner.objectives``.
"""

from typing import Literal

from filters.declared import Channel
from objectives.attitude import AttitudeRmse
from objectives.likelihood import InnovationLikelihood
from objectives.rmse import ChannelRmse, InnovationRmse
from objectives.score import Objective


def likelihood(output: str, channel: Channel | None) -> Objective:
    """How well the filter predicts its measurements; needs no truth."""
    return InnovationLikelihood()


def prediction(output: str, channel: Channel | None) -> Objective:
    """Root mean square of the innovations; needs no truth, and no variance."""
    return InnovationRmse()


def rmse(output: str, channel: Channel | None) -> Objective:
    """Root mean square error of an output; of an attitude, of the whole angle."""
    known = _with_truth("rmse", channel)
    if known.kind == "attitude":
        return AttitudeRmse("total")
    kind: Literal["angle", "number"] = "angle" if known.kind == "angle" else "number"
    return ChannelRmse(output, kind, max(len(known.axes), 1))


def inclination(output: str, channel: Channel | None) -> Objective:
    """Root mean square error of an attitude's roll and pitch, deg: what gravity shows."""
    return _attitude("inclination", channel)


def heading(output: str, channel: Channel | None) -> Objective:
    """Root mean square error of an attitude's heading, deg: what a magnetometer shows."""
    return _attitude("heading", channel)


def _attitude(part: Literal["inclination", "heading"], channel: Channel | None) -> Objective:
    known = _with_truth(part, channel)
    if known.kind != "attitude":
        raise ValueError(
            f"the objective {part} judges an attitude, not {known.meaning.split(';')[0]}; use rmse"
        )
    return AttitudeRmse(part)


def _with_truth(name: str, channel: Channel | None) -> Channel:
    if channel is None:
        raise ValueError(
            f"the objective {name} compares with a truth, and there is none; give --truth "
            "OUTPUT=COLUMN, or use likelihood"
        )
    return channel
