"""An attitude filter with a lead: the freedom that the room filter has."""

from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, NamedTuple, cast

import jax.numpy as jnp
from jax import Array

from filters import AnyFilter, Param
from filters.imu import ATTITUDE
from filters.rotation import from_rotation_vector, multiply

LEAD = Param("s", "how far ahead of the last sample the attitude is wanted", typical=0.0)


@dataclass(frozen=True)
class Ahead:
    """A filter's attitude, extrapolated at the last sample's rate for the lead.

    The rate is taken as it is, without the bias that the filter may know: a bias of 0.01 rad/s
    turns 2 ms by 0.001 deg.

    Attributes:
        filter: a filter of :class:`filters.ImuSample` that outputs an attitude, alone or as
            ``att``.

    >>> import jax.numpy as jnp
    >>> from filters import ImuSample, Mahony, assembled, run
    >>> gains = {"Kp": 0.0, "Ki": 0.0, "q0": jnp.array([1.0, 0.0, 0.0, 0.0])}
    >>> up = jnp.tile(jnp.eye(3)[2], (10, 1))
    >>> about_z = ImuSample(9.81 * up, up)
    >>> turned = Ahead(Mahony(0.1))
    >>> found = run(turned, assembled(turned, gains | {"lead": 0.5}), about_z)[1]
    >>> round(2 * float(jnp.arctan2(found[-1, 3], found[-1, 0])), 6)  # 1 s, and 0.5 s ahead
    1.5
    """

    filter: AnyFilter

    outputs = {"att": ATTITUDE}  # noqa: RUF012  # facts, which nobody changes

    @property
    def params(self) -> type[Any]:
        """The filter's own parameters, and the lead."""
        return _with_lead(getattr(self.filter, "params"))  # noqa: B009  # no part of the protocol

    def init(self, params: Any) -> Any:
        """The filter's own start."""
        return self.filter.init(params.inner)

    def step(self, params: Any, state: Any, inputs: Any) -> tuple[Any, Array]:
        """The filter's own step, with its attitude extrapolated."""
        state, found = self.filter.step(params.inner, state, inputs)
        turn = from_rotation_vector(jnp.nan_to_num(inputs.gyr) * params.lead)
        attitude: Any = getattr(found, "att", found)
        return state, multiply(attitude, turn)


@cache
def _with_lead(inner: type[Any]) -> type[Any]:
    """One class for each inner one, for JAX tells trees apart by it."""
    fields = [("inner", inner), ("lead", Annotated[Array, LEAD])]
    made: Any = NamedTuple  # called, for its fields are known only here
    return cast("type[Any]", made(f"{inner.__name__}Ahead", fields))
