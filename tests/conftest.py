import os

import pytest
from hypothesis import settings

# Compilation takes most of the tests' time, and half of it without the compiler's optimisation,
# which changes no formula. `XLA_FLAGS= pytest` compiles as users do. Read when JAX starts, so
# before anything imports it.
QUICKLY = (
    "--xla_backend_optimization_level=0",
    "--xla_cpu_use_fusion_emitters=false",
    "--xla_cpu_parallel_codegen_split_count=1",
)
os.environ.setdefault("XLA_FLAGS", " ".join(QUICKLY))

# No deadline: the first example compiles. The same examples in every run: a failure in CI is one
# at home; the number of examples is what half a minute on two cores allows.
settings.register_profile("tests", deadline=None, derandomize=True, max_examples=10)
settings.load_profile("tests")


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """No test touches the user's cache of compiled code."""
    os.environ.setdefault("TUNER_CACHE", str(tmp_path_factory.mktemp("compiled")))
