"""Functions evaluated by NumPy, operation by operation, where XLA takes longer to compile them."""

import numpy as np
import pytest

from objectives.in_numpy import evaluate, in_numpy


def evaluated(function, *arguments):
    """The same numbers as JAX's, however many operations they take."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(evaluate, "OFTEN", np.inf)
        return in_numpy(function, *arguments)
