"""False alarms and found faults of the diagnostics: ``python -m benchmarks.diagnostics``.

Records of three models are simulated with and without a fault, every record is tuned by itself by
the likelihood of its innovations, and the innovations are diagnosed. A fault is shown at the size
from which on half of the records give a parameter that is wrong by a factor of two.
"""

import argparse
from collections.abc import Iterator, Mapping
from functools import cache, partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.faulty_records import BEGUN, FAULTS, MODELS, STARTS, TURN, Fault, Model, none
from filters import run
from tuner.diagnostics import Diagnostics, Innovations, diagnose

FEWER, MOVED = 50, 1.8
"""Number of records in a first trial of a size."""


# Tuning: Newton's method on all records at once, in the logarithms of q and R.


class Compiled(NamedTuple):
    """Of many records side by side: the likelihood in nats a number, its slopes and curves in ln q
    and ln R, and the innovations with their variances.
    """

    value: Any
    slopes: Any
    curves: Any
    innovations: Any


@cache
def compiled(model: Model) -> Compiled:
    def one(at: jax.Array, z: jax.Array) -> jax.Array:
        y, s = innovations(at, z)
        seen = s > 0
        s = jnp.where(seen, s, 1.0)
        return jnp.where(seen, y**2 / s + jnp.log(s), 0.0).sum() / 2 / seen.sum()

    def innovations(at: jax.Array, z: jax.Array) -> tuple[jax.Array, jax.Array]:
        outputs = run(model.filter, model.params(*jnp.exp(at)), model.samples(z))[1]
        return outputs.innovation, outputs.variance

    each = partial(jax.vmap, in_axes=(0, 1))
    slopes = jax.jacfwd(one)
    return Compiled(*(jax.jit(each(f)) for f in (one, slopes, jax.jacfwd(slopes), innovations)))


def tuned(model: Model, z: np.ndarray) -> np.ndarray:
    """ln q and ln R of each record ``(k, 2)``."""
    value, slopes, curves, _ = compiled(model)
    at = np.tile(np.log([model.q, model.R]), (z.shape[1], 1))
    best, damping = np.asarray(value(at, z)), np.full(len(at), 1e-3)
    for _ in range(60):
        g, H = np.asarray(slopes(at, z)), np.asarray(curves(at, z))
        eigen, basis = np.linalg.eigh(H)
        inside = np.einsum("kji,kj->ki", basis, g) / (np.abs(eigen) + damping[:, None])
        step = np.clip(-np.einsum("kij,kj->ki", basis, inside), -1.5, 1.5)
        there = np.clip(at + step, -25, 25)
        found = np.asarray(value(there, z))
        better = found < best
        at, best = np.where(better[:, None], there, at), np.where(better, found, best)
        damping = np.where(better, damping / 5, damping * 5).clip(1e-9, 1e6)
        if np.quantile(np.abs(step).max(axis=1), 0.99) < 1e-4:
            break
    return np.asarray(at)


def diagnoses(model: Model, z: np.ndarray, at: np.ndarray, fitted: int) -> list[Diagnostics]:
    """The diagnostics of each record's innovations with its own ln q and ln R."""

    y, s = map(np.asarray, compiled(model).innovations(at, z))
    turn = TURN * np.sqrt(model.R) / 0.1
    return [
        diagnose(
            Innovations.of(
                y[i],
                s[i],
                levels=np.where(s[i] > 0, z[:, i : i + 1] - y[i], np.nan),
                turns=(turn,),
            ),
            fitted=fitted,
        )
        for i in range(len(y))
    ]


def rates(found: list[Diagnostics]) -> dict[str, float]:
    """The share of the records in which each test failed, and any test."""
    tests = [each.test for each in found[0].findings]
    failed = [{each.test for each in one.failed} for one in found]
    shares = {test: float(np.mean([test in each for each in failed])) for test in tests}
    return shares | {"any": float(np.mean([bool(each) for each in failed]))}


def moved(model: Model, at: np.ndarray) -> float:
    """The factor by which the worse of q and R is wrong, in the median record."""
    off = np.abs(at - np.log([model.q, model.R])).max(axis=1)
    return float(np.exp(np.median(off)))


def at_size(
    model: Model, fault: Fault, size: float, count: int, seed: int
) -> tuple[float, dict[str, float]]:
    """The change of the parameters by a fault, and the tests that fail."""
    draw = np.random.default_rng(seed)
    z = fault.make(draw, model.states(draw, count), np.sqrt(model.R), size)
    at = tuned(model, z)
    return moved(model, at), rates(diagnoses(model, z, at, 2))


def nominal(model: Model, count: int, seed: int) -> dict[str, dict[str, float]]:
    """False alarms at the true values and at each record's tuned ones, and wrong variances."""
    draw = np.random.default_rng(seed)
    z = none(draw, model.states(draw, count), np.sqrt(model.R), 0)
    true = np.tile(np.log([model.q, model.R]), (count, 1))
    return {
        "true values": rates(diagnoses(model, z, true, 0)),
        "tuned values": rates(diagnoses(model, z, tuned(model, z), 2)),
        "variances x 2": rates(diagnoses(model, z, true + np.log(2), 0)),
        "variances / 2": rates(diagnoses(model, z, true - np.log(2), 0)),
    }


def main(arguments: list[str] | None = None) -> None:
    """Simulate, tune, diagnose, and print the tables' rows as they come."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--all", action="store_true", help="every size, not the first that moves")
    asked = parser.parse_args(arguments)
    print("| nominal data | values | tests that fail, % |\n|---|---|---|")
    for name, model in {**MODELS, "level begun at 0": BEGUN}.items():
        for what, shares in nominal(model, asked.records, asked.seed).items():
            print(f"| {name} | {what} | {_shares(shares)} |", flush=True)
    print("\n| model | fault | size | moves by | its test, % | any, % | others, % |")
    print("|---|---|---|---|---|---|---|")
    cases = [(m, f) for m in MODELS for f in FAULTS]
    for name, what in [*cases, ("level begun at 0", "start"), ("extended (rotor)", "start")]:
        model = MODELS.get(name, BEGUN)
        fault = FAULTS.get(what, STARTS)
        for line in _rows(model, fault, asked.records, asked.seed, every=asked.all):
            print(f"| {name} | {what} | {line} |", flush=True)


def _rows(model: Model, fault: Fault, records: int, seed: int, *, every: bool) -> Iterator[str]:
    for size in fault.sizes:
        last = every or size == fault.sizes[-1]
        if not last and at_size(model, fault, size, FEWER, seed)[0] < MOVED:
            continue
        factor, shares = at_size(model, fault, size, records, seed)
        if last or factor >= 2:
            rest = {k: v for k, v in shares.items() if k not in (fault.test, "any")}
            own = f"{100 * shares[fault.test]:.1f} | {100 * shares['any']:.1f}"
            yield f"{size:.3g} | {factor:.3g} | {own} | {_shares(rest)}"
        if factor >= 2 and not every:
            return


def _shares(shares: Mapping[str, float]) -> str:
    return ", ".join(f"{test} {100 * share:.1f}" for test, share in shares.items() if share)


if __name__ == "__main__":
    main()
