"""JAX functions of few numbers, evaluated by NumPy: nothing is compiled.

JAX compiles each operation for each shape anew, which takes more time than a hundred thousand
operations on small arrays. Here a function is traced as by ``jax.jit``, and its operations are
NumPy's, one after another. Time loops over records belong to XLA.
"""

from objectives.in_numpy.evaluate import Method as Method
from objectives.in_numpy.evaluate import in_numpy as in_numpy
