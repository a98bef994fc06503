"""The user's description of a model, and the model that follows."""

from typing import Annotated

import numpy as np
from pydantic import Field, Strict, field_validator, model_validator

from objectives import LinearSystem, covariance, require_detectable
from tuner.export.checks import require, require_name, require_once
from tuner.names import unknown
from tuner.run.settings import StudySettings

Number = Annotated[float, Strict()]
Matrix = tuple[tuple[Number, ...], ...]

_LARGEST = 1e60


class Settings(StudySettings):
    """The model, and the requirements on its observer."""

    A: Matrix = Field(
        description="matrix of the dynamics, dx/dt = A x + G w, or x' = A x + G w with dt"
    )
    C: Matrix = Field(description="matrix of the measurements, y = C x + v")
    Q: Matrix = Field(
        description="two-sided spectral density of w; with dt its covariance per sample"
    )
    R: Matrix = Field(
        description="spectral density of v; with dt or sample_time its covariance per sample"
    )
    error: str | tuple[Number, ...] = Field(
        description="state whose error is bounded or minimised, or a row of weights"
    )
    G: Matrix | None = Field(None, description="input matrix of w; the unit matrix if unset")
    bound: float | None = Field(
        None, gt=0, description="upper bound of that error's variance; minimum variance if unset"
    )
    settles_s: float | None = Field(
        None,
        gt=0,
        description="settling time to 2 %, s: minimum variance among observers that meet it",
    )
    states: tuple[str, ...] | None = Field(
        None, description="names of the states; x1, x2, ... if unset"
    )
    dt: float | None = Field(None, gt=0, description="sample time of a discrete model, s")
    sample_time: float | None = Field(
        None, gt=0, description="sample time of the measurements of a continuous model, s"
    )
    unit: str = Field("", description="unit of that error, for the exports")
    starts: int = Field(4, ge=1, description="number of starts of each search")

    @field_validator("A", "C", "Q", "R", "G")
    @classmethod
    def _rectangular(cls, value: Matrix | None) -> Matrix | None:
        if value is not None and (not value or len({len(row) for row in value}) != 1):
            raise ValueError("must be a matrix: rows of one length")
        return value

    @field_validator("A", "C", "Q", "R", "G", "error")
    @classmethod
    def _of_usual_size(cls, value: Matrix | str | tuple[Number, ...] | None) -> object:
        """A design multiplies squares of them: those have to be numbers as well."""
        if value is None or isinstance(value, str):
            return value
        size = np.abs(np.array(value, float))
        if not np.isfinite(size).all():
            raise ValueError("must be finite numbers")
        if ((size > _LARGEST) | ((size > 0) & (size < 1 / _LARGEST))).any():
            raise ValueError(
                f"must be 0 or of a size between {1 / _LARGEST:g} and {_LARGEST:g}; take other "
                "units"
            )
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
        if self.bound is not None and self.settles_s is not None:
            raise ValueError(
                "bound asks for the fastest within a variance, settles_s for the least variance "
                "within a time: give one"
            )
        return self


def system_of(settings: Settings) -> LinearSystem:
    """The system of the design; a sampled continuous one is discretised exactly.

    Raises:
        ValueError: where a matrix does not fit, noise is no covariance, or a mode is unseen.
    """
    A, Q, R = (np.array(part, float) for part in (settings.A, settings.Q, settings.R))
    G = np.eye(len(A)) if settings.G is None else np.array(settings.G, float)
    if A.shape != (len(A), len(A)) or G.shape != (len(A), len(Q)):
        raise ValueError(
            f"A {A.shape}, G {G.shape} and Q {Q.shape} do not fit; give (n, n), (n, p) and (p, p); "
            "without G it is the unit matrix"
        )
    for name, matrix in (("Q", Q), ("R", R)):
        try:
            covariance(matrix)
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    W, states = G @ Q @ G.T, settings.states or ()
    system = LinearSystem(A, settings.C, W, R, dt=settings.dt, states=states)
    if settings.sample_time is not None:
        system = system.sampled(settings.sample_time, R)
    require_detectable(system)
    return system


def error_of(settings: Settings, system: LinearSystem) -> np.ndarray:
    """The weights of the error that counts, ``(n,)``."""
    if not isinstance(settings.error, str):
        return np.array(settings.error, float)
    if settings.error not in system.states:
        raise unknown("state", settings.error, system.states)
    return np.asarray(np.eye(len(system.A))[system.states.index(settings.error)])
