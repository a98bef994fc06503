"""Are statuses true? ``python -m benchmarks.statuses``: 300 problems whose optima are known.

Every problem is stated twice, in JAX for the solvers and in NumPy for the judge, which knows the
optimum in closed form or from a dense search of its own, and searches near a solver's end.
"""
