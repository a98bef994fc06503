"""The linear algebra library of NumPy and SciPy on one thread."""

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def blas_on_one_thread() -> Iterator[None]:
    """Keep the threads of the linear algebra library from matrices that are too small for them.

    A quasi-Newton step solves systems of a few numbers; threads that wait for their share of that
    take the processor from the objective. The library's number of threads is the process's: of
    searches at the same time the one that found several puts them back.
    """
    from threadpoolctl import ThreadpoolController

    libraries = ThreadpoolController().select(user_api="blas")
    if all(each["num_threads"] == 1 for each in libraries.info()):
        yield
        return
    with libraries.limit(limits=1):
        yield
