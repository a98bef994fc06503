"""No filter at all: the vertical by accelerometers alone and by gyroscopes alone."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from filters.rotation import level
from objectives import Data, Records
from studies.broad.contest import Contest, Error
from studies.broad.contestants import start
from studies.broad.trials import Trial


def accelerometers(contest: Contest) -> np.ndarray:
    """Errors by trial, deg, ``(k,)``, with each acceleration taken as the vertical."""
    return np.asarray(_by_acceleration(contest.data("mahony")))


def gyroscopes(contest: Contest) -> np.ndarray:
    """Errors by trial, deg, ``(k,)``, of rates integrated from rest, less their mean at rest."""
    still = Contest(tuple(_unbiased(trial) for trial in contest.trials))
    none = {"Kp": jnp.zeros(()), "Ki": jnp.zeros(())}
    return still.judged("mahony", start("mahony") | none).inclination


def _unbiased(trial: Trial) -> Trial:
    begins = int(np.argmax(~np.isnan(trial.truth).any(axis=1)))
    return replace(trial, rate=trial.rate - trial.rate[:begins].mean(axis=0))


@jax.jit
def _by_acceleration(data: Data) -> jax.Array:
    turned = jax.vmap(jax.vmap(level))(data.inputs.acc)
    return Records(Error()).each(turned, data.truth)
