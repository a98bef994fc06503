"""ROS 2 robot_localization: process noise of its EKF and UKF, in a file of parameters.

Order, defaults and what they are times: robot_localization, params/ekf.yaml and src/ekf.cpp, where
a prediction over T seconds adds T times the matrix; so the matrix is Q / T.
"""

from collections.abc import Collection, Iterator

import numpy as np

from tuner.export.tuned import Tuned
from tuner.firmware.amount import density
from tuner.firmware.target import FileRequest, Target, Text, commented, head, yaml_number
from tuner.names import unknown

# The default of each.
_DEFAULTS = {
    "x": 0.05, "y": 0.05, "z": 0.06, "roll": 0.03, "pitch": 0.03, "yaw": 0.06,
    "vx": 0.025, "vy": 0.025, "vz": 0.04, "vroll": 0.01, "vpitch": 0.01, "vyaw": 0.02,
    "ax": 0.01, "ay": 0.01, "az": 0.015,
}  # fmt: skip
_UNITS = (*["m"] * 3, *["rad"] * 3, *["m/s"] * 3, *["rad/s"] * 3, *["m/s^2"] * 3)
PLACES = {name: (i, _UNITS[i]) for i, name in enumerate(_DEFAULTS)}
"""The states in their order, with their units."""


def written(request: FileRequest) -> Text:
    """The file: the whole matrix, with its own defaults where nothing was tuned."""
    matrix, comments = np.diag(list(_DEFAULTS.values())), list[str]()
    (tuned,) = request.tuned
    mapped = {key: _place(key) for keys in request.wish.maps.values() for key in keys}
    if not mapped:
        raise ValueError(_ask(tuned))
    states = {state: keys for state, keys in request.wish.maps.items() if state in tuned.states}
    comments += _of_states(request, states, matrix)
    for name, keys in request.wish.maps.items():
        comments += [] if name in states else _of_density(request, name, keys, matrix)
    rest = [name for name in PLACES if name not in mapped]
    notes = (f"{', '.join(rest)} have robot_localization's own defaults",) if rest else ()
    lines = commented([*head(request, "robot_localization", TARGET.filter, notes), *comments])
    lines += ["ekf_filter_node:", "  ros__parameters:"]
    if states:
        lines += [f"    frequency: {yaml_number(1 / tuned.dt)}"]
    lines += [f"    # {' '.join(PLACES)}", "    process_noise_covariance: ["]
    lines += [f"      {', '.join(map(yaml_number, row))}," for row in matrix]
    lines[-1] = lines[-1].removesuffix(",") + "]"
    return Text("\n".join([*lines, ""]), len(mapped), notes)


def _ask(tuned: Tuned) -> str:
    first = tuned.states[0] if tuned.states else "STATE"
    there = f"its states are {', '.join(tuned.states)}" if tuned.states else "it names no states"
    return (
        f"nothing says what the states of {tuned.name} are to robot_localization, {there}; name "
        f"them, as in --map {first}=x, with the names {', '.join(PLACES)}"
    )


def _of_states(
    request: FileRequest, states: dict[str, tuple[str, ...]], matrix: np.ndarray
) -> Iterator[str]:
    """Q / T at the places of the states that are mapped."""
    if not states:
        return
    for state, keys in states.items():
        if len(keys) > 1:
            raise ValueError(f"{state} is one state; map it to one of {' and '.join(keys)}")
    (tuned,) = request.tuned
    Q = _covariance(tuned, request.parameters) / tuned.dt
    places, rows = [], []
    for state, keys in states.items():
        places.append(_place(keys[0])[0])
        rows.append(tuned.states.index(state))
        yield f"{keys[0]} is the state {state}: Q / T, T = {tuned.dt:.6g} s"
    matrix[np.ix_(places, places)] = Q[np.ix_(rows, rows)]


def _covariance(tuned: Tuned, parameters: Collection[str]) -> np.ndarray:
    """The states' process noise per sample; that of one axis, repeated for equal axes.

    A parameter of the name Q may be a density as well.
    """
    n = len(tuned.states)
    named = {one.name: one for one in tuned.quantities if one.name not in parameters}
    Q = named.get("Q_derived", named.get("Q"))
    side = 0 if Q is None else round(Q.value.size**0.5)
    axes = n // side if side else 0
    if Q is None or Q.value.size != side**2 or not (tuned.dt > 0 and _alike(tuned, side, axes)):
        raise ValueError(
            f"{tuned.name} has no covariance Q a sample of its states {', '.join(tuned.states)}; "
            "map a density instead, as in --map q=vx"
        )
    found = Q.value.reshape(side, side)
    if not (np.diagonal(found) >= 0).all():
        raise ValueError(f"{Q.name} of {tuned.name} has a negative variance; give a covariance")
    return np.kron(found, np.eye(axes))


def _alike(tuned: Tuned, side: int, axes: int) -> bool:
    """Whether there are ``side`` states for each axis: place_x, place_y, speed_x ..."""
    ends = [state.rpartition("_")[2] for state in tuned.states]
    return side * axes == len(ends) and (axes == 1 or ends == list("xyz"[:axes]) * side)


def _of_density(
    request: FileRequest, name: str, keys: tuple[str, ...], matrix: np.ndarray
) -> Iterator[str]:
    """A density on the diagonal."""
    amounts = {amount.name: amount for amount in request.amounts}
    if name not in amounts:
        raise unknown("state or number", name, [*request.tuned[0].states, *request.parameters])
    amount = amounts[name]
    for key in keys:
        place, unit = _place(key)
        read = density(amount, f"{unit}/s") if amount.value > 0 else None
        if read is None:
            raise ValueError(
                f"{name} is {amount.value:g} {amount.unit}, and {key} takes a positive density in "
                f"({unit})^2/s; map a state, or another number"
            )
        matrix[place, place] = read.value**2
        yield f"{key}: ({read.how})^2 = {read.value**2:.6g} ({unit})^2/s"


def _place(key: str) -> tuple[int, str]:
    if key not in PLACES:
        raise unknown("state of robot_localization", key, PLACES)
    return PLACES[key]


TARGET = Target(
    "robot_localization",
    "ekf.yaml",
    "noises of the EKF of ROS's robot_localization",
    "robot_localization's EKF",
    written,
    True,
)
