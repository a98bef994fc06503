"""The page docs/performance.md: the table, how to read it, and what is missing."""

from collections.abc import Sequence

from benchmarks.machine import Machine
from benchmarks.table import NARROW, Row, markdown

_TEXT = """\
# Performance

Written by `python -m benchmarks --write docs/performance.md`. The numbers of a part come from one
run; where the noise is above 10 %, **at best** is more reliable than **figure**.

- Work: Kownacki's gyroscope filter, {samples} samples, 2 states, a scalar measurement, float64.
- Machine: {machine}.
- Noise: repeated timings of the same pass varied by {noise:.0%} (interquartile range).

## How to read it

The **C limit** is the same recursion in C (`benchmarks/*.c`), compiled for this machine when
the benchmark starts. A sequential filter cannot be faster than the chain of dependent operations
from one sample to the next, and C spends its time waiting for that chain.

- All calls that are compared run in one process and take turns, A B C A B C. **figure** is the
  median over the rounds of each call's time divided by that of its neighbours; **at best** is the
  ratio of the shortest times, which is closer to what an idle machine shows.
- **target** is what the project set out to reach; **reached** is judged by the figure alone, and
  is *narrowly* where it is within {narrow:.0%} of the target: another run may fall on the other
  side.
- Compare ratios: milliseconds depend on the machine and on its load. Ratios between
  latency-bound code (C, one sequence) and throughput-bound code (gradients, batches) still vary by
  a third from one processor to another.
- A pass is `filters.run`; cost and gradient are those of `Problem.value` and
  `Problem.value_and_gradient`; batches are `tuner.values` and
  `tuner.values_and_gradients`, compared with C in as many threads. R1 and R6 are the readings of
  the cost explained in docs/kownacki2010.md: R1 needs a pass over the data, R6 the spectrum as
  well, so it is compared with C's pass plus `numpy.fft.rfft` of the same segments.
- Likelihoods by size are compared by their shortest times alone, which **figure** tells there, with
  a hand-written adjoint in C, whose cost does not depend on the number of parameters.
  **forwards** carries a tangent for each parameter, **backwards** goes back over the record once,
  *in parts* computes each part twice. These rows determine a problem's choice
  (`tuner.problem.paths`): a linear Kalman filter goes backwards from 5 parameters, from 4 with 6
  states and from 2 with 9; an extended one in parts from 6 parameters, from 4 with 5 states and
  from 3 with 9: with fewer it takes longer to compile, by two to four seconds, than it saves. A
  solution's `gradient_by` names the choice, and `Problem(way=...)` overrides it.
- Every output was compared with C's or, for the small R, with a loop that carries 40 digits.

## Two ways to a gradient

A search spends its time in `Problem.value_and_gradient`. XLA computes it at first; where the record
is long enough, C is compiled for it, by the compiler that `CC` names or by `cc`. The time loop is
traced to a graph of scalars. Whatever never changes over time (structural zeros above all) is left
out, and only one half of a symmetric matrix is stored. What precedes the loop (from a point to the
filter's parameters) and what follows from sums is C, too, where it takes few operations; JAX keeps
the rest (matrix exponentials, spectra). Derivatives are computed in one of two ways:

- **Forwards, for few parameters.** The derivatives by up to eight parameters share one vector
  register. Common factors of a derivative are multiplied once for all directions, sums of products
  are ordered for multiply-add instructions, and in a short loop the first division of a sample, on
  which everything else depends, is started while the derivatives of the previous sample are
  computed. Of a start of which nothing is known (`P0 = inf`), much of what is carried is zero for
  good once the first measurements are taken: from there on the loop has a second phase without it,
  a fifth of the operations of the first.
- **A pass over the record and one back**, for any number of parameters: from nine on always, from
  five on where it takes less time, in which a number that is stored and loaded again counts as
  seven operations. The way back is JAX's own derivative of the step, with the covariance's steps
  by hand (`filters.way_back`). What is stored of a sample, and what the pass back computes again
  from it, is that choice of all which takes least time (a minimum cut). Going back, a processor
  does not foresee what is read next: what is stored of a sample is fetched two samples ahead of its
  turn. Above 64 MB the state is stored at the beginning of parts of the record, and each part is
  run again before the pass back goes through it. A gradient takes 1.6 to 2.1 times as long as a
  value in C. Where matrices are large and dense (linear filters from about eight states on), both
  passes are written as loops over rows, of which several entries are computed at once, in place of
  scalars. Of a symmetric product, as that of a covariance, one half is computed and copied to the
  other; rows that end within a vector register are filled up.

Passes of up to 6000 scalar operations, and extended filters' loops forwards, are put in order. Each
sample waits for the one before it, so a processor that multiplies twice in a cycle has nothing to
do most of the time, unless what it looks ahead at, some hundred statements, holds what is ready.
So the terms of a sum are added as they get ready, the last one last, with times that follow from
the recursion itself; and statements stand in the order in which a simple processor of two
multiplications and two sums in a cycle would begin them: first what the next sample waits for, and
what uses up numbers where too many of them wait. A number is stored where it is computed, and the
compiler keeps it in line there. All of an objective that needs nothing but sums of the record, and
of its gradient, is one call of C: by a record of megabytes the interpreter is displaced from the
caches, and each step in between would wait for it. The tilt filter's gradient takes a third less
time so.

Values without a gradient, as a simplex search needs them, are C without derivatives; where they go
by C, so do those of many points, as of a search's random starts and of a report's map.

Sine and cosine of an angle come from two series at once, in the two halves of a register, without a
call. In `tuner.values_and_gradients` eight points share a vector, unless the objective keeps
samples until after the loop.

- **XLA is the judge.** At the first point both compute value and gradient; where they differ by
  more than 1e-9 of the largest of these numbers, only XLA is used; a value alone is compared in the
  same way. A point at which a step of 1e-13 changes XLA's own numbers by as much judges nothing, as
  in a likelihood that is chaotic far from its optimum. Hessians always come from XLA.
- **When.** C pays where a search would spend more time in XLA's loop than the compiler takes:
  (N (1 + n) - 20 000) times the operations of a step is above 70 million, for N samples and n
  parameters; with six parameters and 500 operations that is from about 23 000 samples. Where later
  runs find what was written (*Programs between runs*), it does above 10 million. XLA's own
  way back through the loop costs about three passes for any n, and five in parts. There C is used
  if it takes at most half as many operations as a step (in parts five sixths) forwards, or as many
  (in parts five thirds) with a pass back, where three on entries of a row count as one: it does for
  most filters. Where C takes half of the record with constant gains at the first point, or more, it
  goes forwards for up to eight parameters; for more, XLA's loop with constant gains is used.
  `TUNER_NATIVE=on` uses C wherever it can be compiled, `off` never. `gradient_by` of a `Solution`,
  also in `result.json`, states the choice and the reason, as in `XLA, forwards: the record is too
  short for compiling C to pay`.
- **What has no C.** XLA runs loops with an operation that scalars do not have (a while loop, a
  decomposition), and loops of more than 12 000 operations with their derivatives and of more than
  20 000 with their way back, where rows have no loop either. Without a compiler, or where it fails
  or takes more than 30 s, nothing changes.
- **The cache.** Libraries are stored in `~/.cache/filter-tuner/native` (`TUNER_CACHE/native`),
  under a hash of source, flags, compiler and processor and a hash of their contents. A file that
  another user owns or may write to, or that is reached through a link, is never loaded: then, and
  where the folder cannot be written, the code is compiled for the current process only.

`python -m benchmarks.native` measures both ways in turns (see *Gradients by compiled C*
below).

## Programs between runs

The command line keeps what XLA compiled. JAX's own cache saves the compilation, by the text of a
traced program; the tracing before it takes longer than that by then. So programs of a problem
are kept by the text of all that they follow from, too, and found without tracing: the filter of the
catalogue or the model, the objective, how parameters follow from a point (not their ranges and
starts), the shapes of the data, the contents of every source file of this package, the versions of
Python, JAX, NumPy and SciPy, all settings of JAX and XLA, and the processor.

- A filter or an objective of your own, and one of another package, has no such text: it is traced
  in every run.
- The C of a gradient is kept in the same way, as text with what a call needs besides: a later run
  uses the compiled library at once, still only if it agrees with XLA at the first point.
- Loading a program takes XLA a tenth of a second. Those that the last run of the same filter,
  settings and lengths of logs took are loaded by another thread while the logs are read.
- Files lie in `~/.cache/filter-tuner/programs` (`TUNER_CACHE/programs`), are named by a hash of
  their contents, and are loaded under the conditions of the libraries above.
- Where a source file of this package changed within 5 s before a process began, or later, nothing
  is kept or looked up.
- `TUNER_PROGRAMS=traced` traces everything in every run, as a call from Python does.

## Constant gains

The covariance of a Kalman filter with a constant model and samples at one rate converges, and its
gains become constant. From there on the filter is a linear recursion, and no covariance is
computed. Nothing is approximated, in C or by XLA.

In C whatever follows from parameters and from itself alone, covariances and their derivatives, is
computed once when it has settled; what is left of a sample are a few products (of a track in two
axes with four parameters 76 operations of 247).

- **When gains count as constant.** The full loop runs for 16 samples, and then each time for half
  as many as since the start. The gains are constant where covariances and derivatives are the same
  as before the last of these spells, to 2^-44 of the variances and so that the same drift up to the
  end of the record stays below 2^-36; where they are still the same a sample later, so that nothing
  turns in circles; and where nothing was missing in the spell. A filter that forgets slowly, or
  never, takes every sample by itself to the end.
- **Missing numbers.** At a sample in which one is missing, or with which another recording begins,
  the full loop takes over until the gains have settled again.
- **Which filters.** All whose covariance depends neither on samples nor on the state; this is read
  from the step itself. Several points at once settle together.
- **The choice.** See *When* above. `gradient_by` tells the share at the first point: `C, compiled
  by cc 12.2.0, constant gains for 99.6%`. `Problem(steady=False)` switches it off.

XLA does it in a likelihood by `filters.Settling` around a filter: the innovations of eight samples
are sums of products of these samples and the state before them.

- **When gains count as constant.** After each block of samples (a 128th of the record) the
  covariance is compared with the one from which it began to repeat itself, to 2^-44 of the
  variances, and the products of the filter's error transition since then must have shrunk below
  1e-8, so that any error of the start, and of the derivatives at the start, is below rounding.
- **Missing numbers.** A block in which one is missing is taken sample by sample, and so are those
  after it until the gains have settled again. Gaps in every block leave nothing to gain.
- **Which filters.** All whose step is linear in state and measurements and whose covariance
  depends on neither. Gates, transitions that come with the samples, records end to end and extended
  filters take every sample.
- **The choice.** A `Problem` does it for the values and gradients that XLA computes, where the
  record has 2 000 000 / (2 + n)^2 samples or more, for n states, and half of them are taken with
  constant gains where the search begins; `Problem(steady=...)` forces it or switches it off.
  `gradient_by` tells the share: `XLA, backwards, constant gains for 98.4%: ...`.

Values equal those of the full recursion to 1e-12 and gradients to 1e-10. `python -m
benchmarks.long_records` measures both in turns.

## Several starts

The starts of `l-bfgs-b`, `trust-constr`, `nelder-mead` and `alternating` run side by side in as
many threads as there are processors: compiled code, XLA's and C's, runs without the
interpreter's lock. The results equal those of one start after another, to the last bit. `python -m
benchmarks.starts` measures both in turns:

- Random starts are begun before the initial values, from which a descent is mostly the shortest: a
  short one at the end lets the processors end together. Of 18 draws of four starts, for six
  problems, the evaluations then let two threads gain 1.87 x on average (1.78 x in the order of the
  starts).
- A sum over a long record is rounded by more than a step near the minimum lowers it, and a line
  search takes that for a rise: it rejects better points by the dozen. A descent of `l-bfgs-b` ends
  where six values in a row are equal but for rounding (8 eps sqrt(N) of the value), at the point of
  the smallest gradient. Over 300 000 samples descents need 19 to 39 evaluations instead of 19 to
  102, and no start is much longer than the others.
- The calling thread makes descents itself, and the threads of the other processors, which are kept
  from one search or reading to the next, make others: starting a thread takes .1 to .3 ms, and one
  that starts beside a computing one begins its work .5 to 4.5 ms later.
- They begin at once over records of 10 000 samples or more, and over shorter ones where the
  shortest of a problem's first five evaluations takes more than an eighth of a millisecond; a
  problem that was searched before is known. A third of the time of shorter evaluations goes to
  Python, of which only one thread runs at a time: over 300 samples of a small filter two threads
  gained .9 to 1.1 x, over 100 they took half as long again.
- Starts as lanes of one call were measured and are not used. Four points in one call of XLA take
  twice the time of one, which would save 10 ms of 35 in four descents over 300 samples; the call
  takes half a second longer to compile. In C the derivatives of one point already fill a vector.
- Meanwhile the linear algebra library of NumPy and SciPy uses one thread: its systems have a few
  unknowns, and its waiting threads would slow the objective, which then took 1.4 to 2 x the
  processor time.
- Where two runs at a time would need more than a quarter of the permitted memory, the starts run
  one after another.
- `ipopt` holds the interpreter's lock and runs its starts one after another. So do starts that
  several processes share.

## Many recordings

Recordings side by side have the length of the longest, and what fills the others up is computed
too. From 20 000 samples on a likelihood or a mean square is evaluated in lines instead: the
recordings lie end to end, each begins from the filter's start, lines of about 4000 samples lie
eight side by side, and the processors take such parts in turns. The samples after the last one
with a truth, and recordings without any, as those held out, are left out. `python -m
benchmarks.recordings` measures 1000 recordings of 200 to 2000 samples, 4 states, 6 parameters, in
ns a true sample. Filters whose gradient goes by C take one line a thread. What a fit does besides,
its outputs, what is held out and the diagnostics, still has the length of the longest recording:
where that would take more memory than there is, the recordings are refused.

## Results

{table}

## What was not reached

{missed}

## The guard

`python -m benchmarks.guard` runs in CI. It fails where the loop option has no effect, where a
gradient costs far more than a pass, or where a pass is hardly faster than a loop in Python: these
are the ways to lose speed without an error. Likelihoods of linear filters of 4, 9 and 15 states and
their gradients are held against C by their shortest times, and so are those of compiled C that
computes entries of a row at once; a likelihood with constant gains is held against every step. It
judges ratios, not milliseconds. For larger filters, whose loops are the first to be lost, it
inspects the compiled code; `python -m benchmarks.whole_loops` inspects that of every filter.
`python -m benchmarks.studies` runs studies from an empty cache and counts their compilations.
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
