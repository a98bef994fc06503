"""Checks beside the gains: whether the proofs agree with them, one function a claim."""

from studies.design.problems import Posed
from tuner.certificate.solution import Solution, Status
from tuner.run.comparison import Comparison, Verdict, claim
from tuner.run.study import Claim, Solutions, best

AGREE = 1e-7
"""Relative tolerance of the matrix inequality's variance against the Riccati equation's."""


def _riccati_is_least(posed: Posed, solutions: Solutions) -> Comparison:
    """Whether inequality and Riccati equation agree."""
    found, proof = best("minimum_variance", solutions), solutions["minimum_variance_lmi", "sdp"]
    excess = proof.value / found.value - 1
    return claim(
        "minimum_variance.matrix_inequality",
        "the Riccati equation's variance is the least",
        abs(excess) <= AGREE,
        ours=found.value,
        note=f"the matrix inequality's gain gives {excess:+.1e} of it, and its dual proves "
        f"that no observer is below {_proved(proof)}",
    )


def _undriven(posed: Posed, solutions: Solutions) -> list[Comparison]:
    """Modes without a steady state; no row where every mode is driven."""
    if not posed.undriven:
        return []
    return [
        claim(
            "minimum_variance.every_mode_driven",
            "a steady state exists",
            False,
            ours=None,
            note=f"no noise drives {' and '.join(posed.undriven)}: its error falls as 1/t, and its "
            "steady gain is 0; store the first gains, or add noise to it in Q",
        )
    ]


def _one_lyapunov_matrix(posed: Posed, solutions: Solutions) -> Comparison:
    """The share of the decay rate that one Lyapunov matrix for both requirements reaches."""
    found, proof = best("fastest_decay", solutions), solutions["fastest_decay_lmi", "sdp"]
    reached = 1 / found.value
    share = 1 / (proof.value * reached)
    verdict = Verdict.HOLDS if share <= 1 + 1e-6 else Verdict.FAILS
    note = (
        f"decay rate over the {reached:.6g} 1/s that the search found; with one Lyapunov matrix "
        f"no time constant is below {_proved(proof)} s ({proof.status.value}), with two it may be"
    )
    if verdict is Verdict.FAILS:
        note = f"the search ({found.status.value}) missed the gain of {proof.problem}: {note}"
    if proof.status is Status.FAILED:
        verdict, note = Verdict.NOT_IDENTIFIABLE, proof.message
    where = "one Lyapunov matrix is never faster"
    name = "fastest_decay.matrix_inequality"
    return Comparison(name, where, None, share, "", None, verdict, note)


def _proved(proof: Solution) -> str:
    bound = proof.certificate.lower_bound
    return "-" if bound is None else f"{bound:.8g}"


MINIMUM_VARIANCE = (
    Claim("minimum_variance.matrix_inequality", _riccati_is_least, ("minimum_variance*",)),
    Claim("minimum_variance.every_mode_driven", _undriven),
)
FASTEST_DECAY = (
    Claim("fastest_decay.matrix_inequality", _one_lyapunov_matrix, ("fastest_decay*",)),
)


def claims_of(problem: str) -> tuple[Claim, ...]:
    """The claims of a design by its name; one that settles in time has none."""
    known = {"minimum_variance": MINIMUM_VARIANCE, "fastest_decay": FASTEST_DECAY}
    return known.get(problem, ())
