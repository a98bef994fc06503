"""Pictures that are drawn by a process of their own.

Importing what draws, and drawing, hold the interpreter's lock for half a second, which a search and
the exports beside them would wait for.
"""

import os
import pickle
import subprocess
import sys
from contextlib import suppress

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
    """Draws figures: in another process, where the command line has begun one, or in this one.

    What fails there is drawn here again, and fails here with its reason.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def begin(self) -> None:
        """Import what draws: in another process of the command line, where a processor is free."""
        if not in_use() or (os.cpu_count() or 1) < 2:
            import_drawing()
            return
        search = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
        with suppress(OSError):
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", _START, search],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
                start_new_session=True,
            )

    def picture(self, figure: Figure) -> bytes:
        """The figure as a PNG."""
        process = self._process
        if process is not None and process.stdin is not None and process.stdout is not None:
            with suppress(OSError, EOFError, pickle.PicklingError):
                write(process.stdin, pickle.dumps(figure))
                found = read(process.stdout)
                if found:
                    return found
        return picture(figure)

    def end(self) -> None:
        """Let the other process end."""
        if self._process is not None:
            with suppress(OSError):
                self._process.communicate()
            self._process = None
