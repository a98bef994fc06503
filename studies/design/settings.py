"""What a user says about a model, and the model that follows."""

from typing import Annotated

import jax
import jax.numpy as jnp
import numpy as np
from pydantic import Field, Strict, field_validator, model_validator

from filters import van_loan
from tuner.export.checks import require, require_name, require_once
from tuner.names import unknown
from tuner.observers import LinearDesign
from tuner.problem.parameters import covariance
from tuner.run.settings import StudySettings

Number = Annotated[float, Strict()]
Matrix = tuple[tuple[Number, ...], ...]


class Settings(StudySettings):
    """The model, and what is wanted of its observer."""

    A: Matrix = Field(description="dynamics: dx/dt = A x + G w; x' = A x + G w with dt")
    C: Matrix = Field(description="measurements: y = C x + v")
    Q: Matrix = Field(description="spectral density of w (two-sided); covariance with dt")
    R: Matrix = Field(description="spectral density of v; covariance with dt or sample_time")
    error: str | tuple[Number, ...] = Field(description="the state whose error counts, or a row")
    G: Matrix | None = Field(None, description="where w enters; the unit matrix if unset")
    bound: float | None = Field(None, gt=0, description="of that error's variance; none: least")
    states: tuple[str, ...] | None = Field(None, description="names of the states; x1, x2, ...")
    dt: float | None = Field(None, gt=0, description="sample time of a discrete model, s")
    sample_time: float | None = Field(
        None, gt=0, description="of the measurements of a continuous model, s"
    )
    unit: str = Field("", description="of the error that counts, for the exports")
    starts: int = Field(4, ge=1, description="starts of each search")

    @field_validator("A", "C", "Q", "R", "G")
    @classmethod
    def _rectangular(cls, value: Matrix | None) -> Matrix | None:
        if value is not None and (not value or len({len(row) for row in value}) != 1):
            raise ValueError("must be a matrix: rows of one length")
        return value

    @field_validator("states")
    @classmethod
    def _names(cls, value: tuple[str, ...] | None) -> tuple[str, ...] | None:
        for name in value or ():
            require_name("a state", name, 25)
        if value is not None:
            require_once("state", [name.lower() for name in value])
            require(len(value) > 0, "name every state, or leave the names out")
        return value

    @model_validator(mode="after")
    def _one_clock(self) -> "Settings":
        if self.dt is not None and self.sample_time is not None:
            raise ValueError("dt says that A is discrete, sample_time that it is not: give one")
        return self


def model(settings: Settings) -> LinearDesign:
    """The model as it is designed for; a sampled continuous one is discretised exactly.

    Raises:
        ValueError: where a matrix does not fit, noise is no covariance, or a mode is unseen.
    """
    A, C, Q, R = (
        np.array(part, float) for part in (settings.A, settings.C, settings.Q, settings.R)
    )
    n = len(A)
    G = np.eye(n) if settings.G is None else np.array(settings.G, float)
    if A.shape != (n, n) or G.shape != (n, len(Q)):
        raise ValueError(
            f"A {A.shape}, G {G.shape} and Q {Q.shape} do not fit; they are (n, n), (n, p) and "
            "(p, p), and G is the unit matrix where it is not given"
        )
    for name, matrix in (("Q", Q), ("R", R)):
        try:
            covariance(matrix)
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    states = settings.states or tuple(f"x{i + 1}" for i in range(n))
    if len(states) != n:
        raise ValueError(f"{len(states)} names ({', '.join(states)}) for {n} states; give one each")
    W, dt = G @ Q @ G.T, settings.dt
    if settings.sample_time is not None:
        dt = settings.sample_time
        given = (jnp.asarray(part) for part in (A, G, Q, dt))
        step = jax.jit(van_loan)(*given)
        A, W = np.asarray(step.F), np.asarray(step.Q)
    return LinearDesign(states, A, C, W, R, _error(settings.error, states), dt)


def _error(given: str | tuple[float, ...], states: tuple[str, ...]) -> np.ndarray:
    if not isinstance(given, str):
        if not any(given):
            raise ValueError("the error that counts is zero in every state; name one, or weights")
        return np.array(given, float)
    if given not in states:
        raise unknown("state", given, states)
    return np.asarray(np.eye(len(states))[states.index(given)])
