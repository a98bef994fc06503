"""Does a tuned filter survive single precision on the target?"""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from filters import AnyFilter, run

HARMLESS = 0.01
"""A deviation below this share of the signal's scale is not worth a warning."""


@dataclass(frozen=True)
class SinglePrecision:
    """How far a filter in float32 strays from the same filter in float64 on the same record.

    Attributes:
        form: which form of the filter was run, "full covariance".
        largest: largest deviation of the output, in its unit.
        share: the same over the scale of the signal.
        sample: where it occurs.
        rms: root mean square of the deviation.
        warning: a sentence where it matters, otherwise "".
    """

    form: str
    largest: float
    share: float
    sample: int
    rms: float
    warning: str


@dataclass(frozen=True)
class Part:
    """A filter of whose outputs one part alone is put out.

    Attributes:
        filter: the filter.
        key: which part, the name of a field or an index along the first axis.

    >>> from filters import GyroscopeFilter, KownackiNoise
    >>> part = Part(GyroscopeFilter(dt=0.01, shape=(2,)), 1)
    >>> run(part, KownackiNoise.of(R=1e-4, Q=1.0), jnp.ones((500, 2)))[1].shape
    (500,)
    """

    filter: AnyFilter
    key: str | int

    def init(self, params: Any) -> Any:
        """The filter's own state before the first sample."""
        return self.filter.init(params)

    def step(self, params: Any, state: Any, inputs: Any) -> tuple[Any, jax.Array]:
        """Take one sample: the filter's next state and the part of what it puts out."""
        state, whole = self.filter.step(params, state, inputs)
        return state, getattr(whole, self.key) if isinstance(self.key, str) else whole[self.key]


def single_precision(
    form: str, filter: AnyFilter, params: Any, inputs: Any, scale: float
) -> SinglePrecision:
    """Run a filter whose outputs are one array ``(N, ...)`` in both precisions.

    Args:
        form: what to call it.
        filter: the filter.
        params: its parameters, float64.
        inputs: its inputs, float64, time first.
        scale: size of the signal that counts, in the output's unit.

    Raises:
        TypeError: where the filter falls back to float64, for then nothing would be tested.
    """
    exact = np.asarray(_outputs(filter, params, inputs))
    with np.errstate(over="ignore"):  # what overflows is infinite, and counts as such
        halved = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), (params, inputs))
    rounded = _outputs(filter, *halved)
    if rounded.dtype != jnp.float32:
        raise TypeError(f"{type(filter).__name__} puts out {rounded.dtype} for float32 inputs")
    deviation = np.abs(np.asarray(rounded, float) - exact)
    deviation[np.isnan(deviation)] = np.inf
    sample = int(np.unravel_index(np.argmax(deviation), deviation.shape)[0])
    largest = float(deviation.max())
    share = largest / scale
    warning = ""
    if not share < HARMLESS:
        warning = (
            f"in single precision the {form} form strays by {100 * share:.3g} % of {scale:g} at "
            f"sample {sample}; run it in double precision or use a fixed-gain form"
        )
    rms = float(np.sqrt(np.mean(deviation**2)))
    return SinglePrecision(form, largest, share, sample, rms, warning)


@jax.jit(static_argnums=0)
def _outputs(filter: AnyFilter, params: Any, inputs: Any) -> jax.Array:
    outputs: jax.Array = run(filter, params, inputs)[1]
    return outputs
