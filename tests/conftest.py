import gc
import os
import shutil
import tempfile

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
# 700 new ones takes a tenth of the time, and a fiftieth still where that is done every 50,000.
gc.set_threshold(200_000, 20, 100)

# The gradients of long records are XLA's in tests; those of tests/tuner/test_native.py are not.
os.environ.setdefault("TUNER_NATIVE", "off")

# No deadline: the first example compiles. The same examples in every run: a failure in CI is one
# at home; the number of examples is what half a minute on two cores allows.
settings.register_profile("tests", deadline=None, derandomize=True, max_examples=10)
settings.load_profile("tests")


def pytest_configure(config):
    """One cache of compiled code for all processes of a session; no test touches the user's."""
    if "TUNER_CACHE" not in os.environ:  # workers find that of the process that started them
        os.environ["TUNER_CACHE"] = folder = tempfile.mkdtemp(prefix="compiled")
        config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
        config.add_cleanup(lambda: os.environ.pop("TUNER_CACHE", None))


@pytest.fixture(scope="session", autouse=True)
def shared_context():
    """Programs of one process share a context of MLIR.

    JAX makes one for every program, a fifth of the time of a small one, and keeps it: a megabyte.
    So does here a program that is met while another one is written down.
    """
    import jax
    from jax._src.interpreters import mlir
    from jax._src.lib.mlir import ir

    import filters  # noqa: F401  # before JAX's backend starts

    make, context = mlir.make_ir_context, mlir.make_ir_context()

    def shared():
        return context if ir.Context.current is None else make()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mlir, "make_ir_context", shared)
        # Compiled, not found among what is kept: what the compiler loads into a context, it loads
        # before there are other threads.
        jax.jit(lambda x: x + 1.0)(0.0)
        yield


@pytest.fixture(scope="session", autouse=True)
def kept_programs(shared_context):
    """What one process compiled, no other one compiles again."""
    from tuner.run.cache import use_cache

    assert use_cache()


@pytest.fixture(scope="session", autouse=True)
def rough():
    """Pictures are drawn without the layout that measures every text, half of their time.

    It is what is yielded: tests/tuner/test_drawing.py looks at where things stand.
    """
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    with pytest.MonkeyPatch.context() as patch:
        measuring = ConstrainedLayoutEngine.execute
        patch.setattr(ConstrainedLayoutEngine, "execute", lambda *_: None)
        yield measuring


@pytest.fixture(scope="session", autouse=True)
def not_synced():
    """Files are not waited for until the disk has them: no test takes the power away."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda _: None)
        yield


@pytest.fixture(scope="session", autouse=True)
def unmeasured():
    """How large code is once compiled, tests/tuner/code looks at, and no run calls a compiler."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tuner.run.machine.size", lambda *_: None)
        yield


@pytest.fixture
def first_steps(monkeypatch):
    """Steps of self-tests are drawn once, and none is brought close to a limit.

    That is most of the time of making C.
    """
    monkeypatch.setattr("tuner.code.batches._FEW", 1)
    monkeypatch.setattr("tuner.code.batches._OPERATIONS", 0)
    monkeypatch.setattr("tuner.code.batches.beside_limits", lambda *_, by_one=True: iter(()))


@pytest.fixture(autouse=True)
def first_steps_elsewhere(request):
    """What more steps find tests/tuner/code looks at."""
    if "tests/tuner/code" not in request.path.as_posix():
        request.getfixturevalue("first_steps")
