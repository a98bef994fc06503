"""What was reached, beside the field's best filter."""

from collections.abc import Sequence

import jax.numpy as jnp
import numpy as np

from studies.broad.contest import FREE, judged
from studies.broad.peers import vqf
from studies.broad.trials import Trial
from tuner.comparison import Comparison, Verdict, claim
from tuner.study import Solutions, best, tuned_values

REACH = 0.70
"""What a filter of this project has to reach on trials that it was not tuned on, deg."""
LABELS = {
    "room": "strapdown navigation in a room",
    "room_now": "the same without a lead",
    "gravity": "gravity and bias, constant r",
    "two_step": "gravity and bias, the paper's adaptation",
    "mahony": "Mahony",
    "madgwick": "Madgwick",
}


def compare(
    trials: Sequence[Trial], folds: Sequence[int], tuned: Sequence[str], solutions: Solutions
) -> list[Comparison]:
    """All rows."""
    rows = _left_out(trials, folds, solutions)
    rows += [_peer(trials)]
    rows += [_in_sample(name, trials, solutions) for name in tuned]
    return rows + _transferred(trials, solutions)


def fold_name(trial: Trial) -> str:
    """What the problem is called that leaves a trial out."""
    return f"without_{trial.name}"


def left_out(trials: Sequence[Trial], folds: Sequence[int], solutions: Solutions) -> np.ndarray:
    """The errors on trials with the parameters tuned on all others, deg."""
    found = []
    for at in folds:
        values = tuned_values(best(fold_name(trials[at]), solutions))
        found.append(judged("room", values, [trials[at]])[0])
    return np.array(found)


def _left_out(
    trials: Sequence[Trial], folds: Sequence[int], solutions: Solutions
) -> list[Comparison]:
    if not folds:
        return []
    errors = left_out(trials, folds, solutions)
    each = ", ".join(
        f"{trials[at].name[:2]} {error:.3f}" for at, error in zip(folds, errors, strict=True)
    )
    return [
        claim(
            "inclination_loo_deg",
            "leave one trial out, mean of the trials' RMSE in motion",
            float(errors.mean()) <= REACH,
            ours=float(errors.mean()),
            unit="deg",
            note=f"{LABELS['room']}, {len(FREE['room'])} parameters; aim {REACH}; by trial {each}",
        )
    ]


def _peer(trials: Sequence[Trial]) -> Comparison:
    found = vqf(trials)
    if found is None:
        return Comparison(
            quantity="inclination_vqf_deg",
            where="the same trials",
            paper=None,
            ours=None,
            unit="deg",
            tolerance=None,
            verdict=Verdict.NOT_IDENTIFIABLE,
            note="the package vqf is not installed: it comes with the extra 'peers'",
        )
    mean = float(found.default.mean())
    return claim(
        "inclination_vqf_deg",
        "the same trials, VQF with its own parameters",
        True,
        ours=mean,
        unit="deg",
        note=f"with its time constant tuned on these very trials ({found.tau:.2g} s) "
        f"{found.tuned.mean():.3f}",
    )


def _in_sample(name: str, trials: Sequence[Trial], solutions: Solutions) -> Comparison:
    start = {key: p.constrain(jnp.asarray(p.start())) for key, p in FREE[name].items()}
    begun = judged(name, start, trials).mean()
    found = best(name, solutions)
    return claim(
        f"inclination_{name}_deg",
        "the same trials, tuned on them all",
        True,
        ours=found.value,
        unit="deg",
        note=f"{LABELS[name]}, {len(FREE[name])} parameters; {begun:.3f} where the search began",
    )


def _transferred(trials: Sequence[Trial], solutions: Solutions) -> list[Comparison]:
    disturbed = [trial for trial in trials if trial.disturbed]
    if not disturbed or len(disturbed) == len(trials):
        return []
    values = tuned_values(best("undisturbed", solutions))
    elsewhere = float(judged("room", values, disturbed).mean())
    own = float(judged("room", tuned_values(best("room", solutions)), disturbed).mean())
    return [
        claim(
            "inclination_transfer_deg",
            "tuned on the undisturbed trials, judged on the disturbed ones",
            elsewhere <= REACH,
            ours=elsewhere,
            unit="deg",
            note=f"with the parameters tuned on all trials {own:.3f}",
        )
    ]
