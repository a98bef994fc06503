"""The page docs/performance.md: the table, how to read it, and what is missing."""

from collections.abc import Sequence

from benchmarks.machine import Machine
from benchmarks.table import NARROW, Row, markdown

_TEXT = """\
# Performance

Made by `python -m benchmarks --write docs/performance.md`; the numbers below are one run's,
and where the noise is above 10 % **at best** says more than **figure**.

- Work: Kownacki's gyroscope filter, {samples} samples, 2 states, a scalar measurement, float64.
- Machine: {machine}.
- Noise: the time of one and the same pass varied by {noise:.0%} (distance of the quartiles).

## How to read it

The **C limit** is the same recursion in C (`benchmarks/*.c`), compiled for the very machine when
the benchmark starts. A sequential filter cannot be faster than the chain of operations from one
sample to the next; C spends its time waiting for that chain.

- All calls that are compared run in one process and take turns, A B C A B C. **figure** is the
  median over the rounds of each call's time over that of its neighbours; **at best** is the ratio
  of the shortest times, which is nearer to what an idle machine shows.
- **target** is what the project set out to reach; **reached** is judged by the figure alone, and
  *narrowly* where it is within {narrow:.0%} of the target: another run may fall on the other side.
- Trust ratios; milliseconds depend on the machine and on what else it does. Ratios between code
  that waits (C, one sequence) and code that is busy (gradients, batches) still move by a third from
  one processor to another.
- A pass is `filters.run`; cost and gradient are what `Problem.value` and
  `Problem.value_and_gradient` evaluate; batches are `tuner.values` and
  `tuner.values_and_gradients`, with C in as many threads. R1 and R6 are the readings of the cost
  that docs/kownacki2010.md explains: R1 needs a pass over the data, R6 the spectrum as well, so it
  is held against C's pass plus `numpy.fft.rfft` of the same segments.
- Likelihoods by size are judged by the processor's time, with C's adjoint, which costs the same
  for any number of parameters. **forwards** carries a tangent for each parameter, **backwards**
  goes back once, in parts twice through each. By these rows a problem chooses
  (`tuner.problem.paths`): a linear Kalman filter goes backwards from 5 parameters on, from 4 with
  6 states and from 2 with 9; an extended one in parts from 6, and from 4 with 5 states. A
  solution's `gradient_by` says which it was, and `Problem(way=...)` forces one.
- Every output was compared with C's or, for the small R, with a loop that carries 40 digits.

## Two ways to a gradient

A search spends its time in `Problem.value_and_gradient`. XLA works it out, and wherever the
record is long enough C is compiled for it instead, by the compiler that `CC` names or `cc`: the
time loop is traced to a graph of scalars with its derivatives, what never changes over time
(structural zeros above all) is left out, symmetric matrices are kept by halves, and the
derivatives by up to eight parameters lie in one vector of the processor. What comes before the
loop (from a point to the filter's parameters) and after it (spectra, means) stays JAX. In
`tuner.values_and_gradients` eight points share a vector, where the objective keeps no samples for
after the loop. The first division of a sample, for which all that follows has to wait, is begun
while the derivatives of the sample before are worked out, and factors of a derivative are
multiplied with one another first, once for all directions.

- **XLA is the judge.** At the first point both work out value and gradient; where they differ by
  more than 1e-9 of the largest of these numbers, XLA goes on alone. Values without gradient,
  Hessians and the certificate are XLA's anyway.
- **When.** C pays where a search would spend more time in XLA's loop than the compiler takes: (N
  (1 + n) - 20 000) times the operations of a step above 8 million, for N samples and n
  parameters; with six parameters and 500 operations from about 5000 samples on. Where XLA goes
  backwards through the loop, which costs about three passes for any n, C has to take at most half
  as many operations as a step: so it does where matrices have zeros, and not where they are
  dense. `TUNER_NATIVE=on` asks for it wherever it can be made, `off` never. `gradient_by` of a
  `Solution`, in `result.json` too, says which way it was and why, as in `XLA, forwards: the
  record is too short for compiling C to pay`.
- **What has no C.** A loop with an operation that scalars do not have (a while loop, a
  decomposition), or of more than 12 000 operations with its derivatives, is XLA's. Without a
  compiler, or with one that fails or takes more than 30 s, nothing changes.
- **What is kept.** Libraries lie in `~/.cache/filter-tuner/native` (`TUNER_CACHE/native`), under
  a hash of source, flags, compiler and processor and a hash of what is in them. Nothing is loaded
  that another user owns or may write to, nor through a link: then, and where the folder cannot be
  written, the code is compiled for the process alone.

`python -m benchmarks.native` measures both ways in turns (the part *Gradients by compiled C*
below).

## Several starts

The starts of `l-bfgs-b`, `trust-constr`, `nelder-mead` and `alternating` run side by side in
threads, as many as there are processors: compiled code, XLA's and C's, runs without the
interpreter's lock. The ends are the same as one after another, to the last bit. `python -m
benchmarks.starts` measures both in turns:

- A descent that ends within 20 ms is followed by the next one, for up to about 1000 samples of a
  small filter: there Python takes a third of the time, which one thread runs at a time, and
  threads would cost up to a fifth more. Of 100 000 samples two threads gained 1.7 to 2.0 x where
  the starts end together, and 1.6 x of 1.8 x that unequal ones allowed, for the last one leaves a
  processor idle.
- Starts as lanes of one call were measured and are not used. Four points in one call of XLA take
  twice the time of one, which would save 10 ms of 35 in four descents over 300 samples; the call
  takes half a second more to compile. In C a vector is full with the derivatives of one point
  already.
- Meanwhile the linear algebra library of NumPy and SciPy has one thread: its systems are of a few
  numbers, and its threads would wait at the expense of the objective, which took 1.4 to 2 x the
  processor's time.
- Where two runs at a time would need more than a quarter of the memory that may be used, there is
  one.
- `ipopt` holds the interpreter's lock, and takes its starts one after another. So do starts that
  several processes share.

## Results

{table}

## What was not reached

{missed}

## The guard

`python -m benchmarks.guard` runs in CI. It fails where the loop option has no effect, where a
gradient costs far more than a pass, or where a pass is hardly faster than a loop in Python: the
ways in which speed is lost without an error. It judges ratios, not milliseconds. What was compiled
of larger filters is read, whose loops are the first to be lost; `python -m benchmarks.whole_loops`
reads it of every filter.
"""


def page(rows: Sequence[Row], machine: Machine, samples: int, noise: float) -> str:
    """The whole page in Markdown."""
    return _TEXT.format(
        samples=f"{samples:,}".replace(",", " "),
        machine=machine.words,
        noise=noise,
        narrow=NARROW,
        table=markdown(rows),
        missed=_missed(rows),
    )


def _missed(rows: Sequence[Row]) -> str:
    lines = [_reason(row) for row in rows if row.reached is False]
    lines += [
        f"- {row.what}: not measured; {row.note}."
        for row in rows
        if row.target is not None and row.reached is None
    ]
    return "\n".join(lines) or "Every target was reached in this run."


def _reason(row: Row) -> str:
    best = "" if row.best is None else f" ({row.with_unit(row.best)} at best)"
    where = f"- {row.part}, {row.what}: {row.with_unit(row.figure)}{best}"
    return f"{where}, not {row.with_unit(row.target)}" + (f": {row.why}." if row.why else ".")
