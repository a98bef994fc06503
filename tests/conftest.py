import gc
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
    # What optimisation would have been told, a sixth of the time of a large compilation:
    "--xla_llvm_enable_alias_scope_metadata=false",
    "--xla_llvm_enable_noalias_metadata=false",
    "--xla_llvm_enable_invariant_load_metadata=false",
)
os.environ.setdefault("XLA_FLAGS", " ".join(QUICKLY))
# Threads that wait by turning take a worker's processor away from the other one.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Tables are as wide as where nobody tells how wide; pytest-xdist does.
os.environ.pop("COLUMNS", None)
# Nor are there lines of progress where a test takes long.
os.environ["TUNER_PROGRESS"] = "0"

# Tracing makes many small objects that live: to look through all of them for circles after every
# 700 new ones takes a tenth of the time.
gc.set_threshold(50_000, 20, 20)

# The gradients of long records are XLA's in tests; those of tests/tuner/test_native.py are not.
os.environ.setdefault("TUNER_NATIVE", "off")

# No deadline: the first example compiles. The same examples in every run: a failure in CI is one
# at home; the number of examples is what half a minute on two cores allows.
settings.register_profile("tests", deadline=None, derandomize=True, max_examples=10)
settings.load_profile("tests")


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """No test touches the user's cache of compiled code."""
    os.environ.setdefault("TUNER_CACHE", str(tmp_path_factory.mktemp("compiled")))
