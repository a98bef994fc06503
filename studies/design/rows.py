"""What is said beside the gains: whether the proofs agree with them."""

from tuner.certificate.solution import Solution, Status
from tuner.run.comparison import Comparison, Verdict, claim
from tuner.run.study import Solutions, best

AGREE = 1e-7
"""How closely the matrix inequality has to give the Riccati equation's variance."""


def compare_minimum_variance(undriven: list[str], solutions: Solutions) -> list[Comparison]:
    """Whether inequality and Riccati equation agree, and what has no steady state."""
    found, proof = best("minimum_variance", solutions), solutions["minimum_variance_lmi", "sdp"]
    excess = proof.value / found.value - 1
    rows = [
        claim(
            "minimum_variance.matrix_inequality",
            "the Riccati equation's variance is the least",
            abs(excess) <= AGREE,
            ours=found.value,
            note=f"the matrix inequality's gain gives {excess:+.1e} of it, and its dual proves "
            f"that no observer is below {_proved(proof)}",
        )
    ]
    if undriven:
        rows.append(
            claim(
                "minimum_variance.every_mode_driven",
                "a steady state exists",
                False,
                ours=None,
                note=f"nothing drives {' and '.join(undriven)}: its error falls to zero as 1/t, "
                "and the steady gain leaves it alone; store the first gains, or let Q drive it",
            )
        )
    return rows


def compare_fastest_decay(solutions: Solutions) -> list[Comparison]:
    """Which share of the decay rate one Lyapunov matrix for both demands reaches."""
    found, proof = best("fastest_decay", solutions), solutions["fastest_decay_lmi", "sdp"]
    reached = 1 / found.value
    share = 1 / (proof.value * reached)
    verdict = Verdict.HOLDS if share <= 1 + 1e-6 else Verdict.FAILS
    note = (
        f"with one Lyapunov matrix for both demands, which designs with two need not have, no time "
        f"constant below {_proved(proof)} s is possible ({proof.status.value}); ours is the decay "
        f"rate of its gain as a share of the {reached:.6g} 1/s that the search found"
    )
    if verdict is Verdict.FAILS:
        note = f"the search ({found.status.value}) missed the gain of {proof.problem}: {note}"
    if proof.status is Status.FAILED:
        verdict, note = Verdict.NOT_IDENTIFIABLE, proof.message
    where = "one Lyapunov matrix is never faster"
    return [
        Comparison("fastest_decay.matrix_inequality", where, None, share, "", None, verdict, note)
    ]


def _proved(proof: Solution) -> str:
    bound = proof.certificate.lower_bound
    return "-" if bound is None else f"{bound:.8g}"
