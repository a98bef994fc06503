"""Pictures that are drawn by processes of their own.

Importing what draws, and drawing, hold the interpreter's lock for half a second, which a search and
the exports beside them would wait for.
"""

import os
import pickle
import subprocess
import sys
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Lock

from tuner.run.drawing import picture
from tuner.run.figure import Figure
from tuner.run.painter_worker import import_drawing, read, write
from tuner.stored_programs import in_use

_START = """import sys, os
sys.path[:] = sys.argv[1].split(os.pathsep)
from tuner.run.painter_worker import serve
serve(sys.stdin.buffer, sys.stdout.buffer)
os._exit(0)"""


class Painter:
    """Draws figures: in other processes, where the command line has begun some, or in this one.

    What fails there is drawn here again, and fails here with its reason.
    """

    def __init__(self) -> None:
        self._begun: list[subprocess.Popen[bytes]] = []
        self._free: SimpleQueue[subprocess.Popen[bytes]] = SimpleQueue()
        self._here = Lock()  # Matplotlib draws in one thread at a time

    @property
    def processes(self) -> int:
        """The number of the others."""
        return len(self._begun)

    def begin(self, count: int) -> None:
        """Import what draws: in so many processes of the command line, where processors are free.

        Args:
            count: the most that are begun.
        """
        processors = os.cpu_count() or 1
        if not in_use() or processors < 2:
            import_drawing()
            return
        search = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
        for _ in range(min(count, processors)):
            with suppress(OSError):
                process = subprocess.Popen(
                    [sys.executable, "-P", "-c", _START, search],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL,
                    env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
                    start_new_session=True,
                )
                self._begun.append(process)
                self._free.put(process)

    def picture(self, figure: Figure) -> bytes:
        """The figure as a PNG; several threads may ask."""
        with suppress(Empty):
            process = self._free.get_nowait()
            if process.stdin is not None and process.stdout is not None:
                with suppress(OSError, EOFError, pickle.PicklingError):
                    write(process.stdin, pickle.dumps(figure))
                    found = read(process.stdout)
                    self._free.put(process)
                    if found:
                        return found
        with self._here:
            return picture(figure)

    def end(self) -> None:
        """Let the other processes end."""
        for process in self._begun:
            with suppress(OSError):
                process.communicate()
        self._begun.clear()
