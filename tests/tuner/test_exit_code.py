"""Where the command line ends: one line, an exit code, and nothing that a terminal would obey."""

import io
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tuner.cli.common_options import CommonOptions
from tuner.cli.exit_code import exit_code_of
from tuner.cli.fault import fault_of
from tuner.limits import LEAST, VARIABLE, check_amount, largest, memory, parse_size
from tuner.run.threads import at_once
from tuner.terminal_text import printable, write_to_stream

ROOT = Path(__file__).resolve().parents[2]


class ForeignError(Exception):
    """Another package's error."""


def raising(error):
    def run():
        raise error

    return run


ERRORS = [
    RecursionError("maximum recursion depth exceeded"),
    MemoryError(),
    OverflowError(34, "Numerical result out of range"),
    ZeroDivisionError("float division by zero"),
    KeyError("starts"),
    TypeError("an integer is required"),
    StopIteration(),
    IndexError("list index out of range"),
    AttributeError("'NoneType' object has no attribute 'x'"),
    AssertionError(),
    NotImplementedError(),
    ImportError("no module named 'x'"),
    RuntimeError("RESOURCE_EXHAUSTED: Out of memory allocating 80000000000 bytes."),
    ValueError("two\nlines"),
    OSError("what no system says"),
    FileNotFoundError(2, "No such file or directory", "x\x1b[2J"),
    ForeignError("words\nmore words\x07"),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_every_exception_is_one_sentence(capsys, error):
    code = exit_code_of(raising(error), with_traceback=False)
    out, err = capsys.readouterr()
    assert code in (1, 2)
    assert out == ""
    assert err.startswith("tuner: ")
    assert len(err.splitlines()) == 1
    assert "Traceback" not in err
    assert printable(err) == err


def test_faults_of_the_program_are_told_from_the_users(capsys):
    assert (
        exit_code_of(raising(ValueError("no column 'x'; name another")), with_traceback=False) == 2
    )
    assert exit_code_of(raising(TypeError("an integer is required")), with_traceback=False) == 1
    err = capsys.readouterr().err
    assert "no column 'x'; name another\n" in err
    assert "test_door.py" not in err  # where it was raised is asked for by --traceback


def test_the_words_of_libraries_say_where():
    with pytest.raises(ValueError, match="broadcast") as caught:
        np.zeros(3) + np.zeros(2)
    assert fault_of(caught.value).sentence.endswith("--traceback shows where")


@given(st.text())
def test_no_control_character_is_shown(text):
    safe = printable(text)
    assert all(c in "\t\n" or (c >= " " and not "\x7f" <= c <= "\x9f") for c in safe)
    assert printable(safe) == safe
    safe.encode()


def test_names_with_control_characters(cli, here):
    Path("a\x1b[2Jb.csv").write_text("t,g\x1b]0;owned\x07x\x9b31m\n" + "0,1\n1,3\n2,1\n")
    for words in (["columns"], ["run", "kownacki2010", "--map", "omega=\x1b[31m", "--log"]):
        _, out, err = cli(*words, "a\x1b[2Jb.csv")
        assert "\x1b" not in out + err
        assert "\x07" not in out + err
        assert "\x9b" not in out + err
    assert cli("run", "\udcff\x1b")[0] == 2


def test_options_of_every_command_stand_anywhere():
    assert CommonOptions.of(["--memory=4G", "fit", "--", "--traceback"]) == CommonOptions(
        ["fit", "--", "--traceback"], memory="4G"
    )
    assert CommonOptions.of(["fit", "--memory"]) == CommonOptions(["fit"], memory="")


@pytest.mark.parametrize("size", ["", "much", "-1GB", "4", "900MB", "nan", "1" * 50 + "GB"])
def test_bounds_on_memory_that_are_none(cli, size):
    code, out, err = cli("list", f"--memory={size}")
    assert (code, out) == (2, "")
    assert err.startswith("tuner: --memory ")


def test_a_bound_on_memory(cli, monkeypatch):
    monkeypatch.setenv(VARIABLE, "2GB")
    assert memory() == 2 << 30
    assert largest() < (2 << 30) // 3
    with pytest.raises(ValueError, match="1e9 samples would take 8 GB, where 0.5 GB is the most"):
        check_amount("1e9 samples", 8 << 30, "take fewer")
    assert cli("list", "--memory", "3GB")[0] == 0
    assert os.environ[VARIABLE] == "2GB"
    assert parse_size("x", "1g") == LEAST


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_signals_end_as_ctrl_c_does(tmp_path, name):
    fifo = tmp_path / "started"
    os.mkfifo(fifo)
    code = (
        "import signal, time\n"
        f"signal.signal(signal.{name}, signal.SIG_DFL)\n"  # who tests may have it ignored
        "import tuner.__main__ as m\n"
        f"import tuner.cli; tuner.cli.main = lambda: (open({str(fifo)!r}, 'w').close(), "
        "time.sleep(60))\n"
        "m.main()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    ) as process:
        with fifo.open() as stream:
            stream.read()
        process.send_signal(getattr(signal, name))
        out, err = process.communicate(timeout=60)
    told = b"tuner: interrupted before anything was saved\n"
    assert (process.returncode, out, err) == (128 + getattr(signal, name), b"", told)


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_in_the_middle_of_an_import_ends_the_process_there(tmp_path, name):
    """Packages take what is raised in their imports for an error of their own, or end by it."""
    (tmp_path / "swallowing.py").write_text(
        "import signal\n"
        "try:\n"
        f"    signal.raise_signal(signal.{name})\n"
        "except BaseException as error:\n"
        "    raise ImportError('numpy failed to import') from error\n"
    )
    code = (
        "import tuner.__main__ as m, tuner.cli\n"
        "def main():\n"
        "    import swallowing\n"
        "tuner.cli.main = main\n"
        "m.main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{tmp_path}"},
        capture_output=True,
        check=False,
    )
    told = b"tuner: interrupted before anything was saved\n"
    assert (done.returncode, done.stdout, done.stderr) == (128 + getattr(signal, name), b"", told)


@pytest.mark.skipif(os.name == "nt", reason="signals of another kind")
def test_a_signal_that_python_drops_is_sent_again(tmp_path):
    """What is raised in a finaliser is printed and forgotten."""
    code = (
        "import signal, time, tuner.__main__ as m, tuner.cli\n"
        "class Last:\n"
        "    def __del__(self):\n"
        "        signal.raise_signal(signal.SIGTERM)\n"
        "def main():\n"
        "    Last()\n"
        "    time.sleep(9)\n"
        "tuner.cli.main = main\n"
        "m.main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        check=False,
    )
    told = b"tuner: interrupted before anything was saved\n"
    assert (done.returncode, done.stderr) == (143, told)


@pytest.mark.skipif(os.name == "nt", reason="pipes of another kind")
def test_a_pipe_that_nobody_reads_is_no_fault():
    read, written = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-m", "tuner", "list", "formats"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdout=written,
        stderr=subprocess.PIPE,
        check=False,
    )
    os.close(written)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_broken_pipe_of_another_kind_is_told(capsys):
    assert (
        exit_code_of(raising(BrokenPipeError(32, "Broken pipe", "socket")), with_traceback=False)
        == 2
    )
    assert "socket: Broken pipe" in capsys.readouterr().err


def test_a_file_that_is_handed_out_to_a_terminal():
    class Terminal(io.TextIOWrapper):
        def isatty(self):
            return True

    data = "unit = '\x9b31m'\n".encode()
    for kind, expected in ((Terminal, b"unit = '\\u009b31m'\n"), (io.TextIOWrapper, data)):
        raw = io.BytesIO()
        stream = kind(raw, encoding="utf-8")
        write_to_stream(data, stream)
        stream.flush()
        assert raw.getvalue() == expected


def test_no_thread_is_waited_for_after_an_interruption():
    let_go = threading.Event()
    with pytest.raises(KeyboardInterrupt), at_once(2) as pool:  # noqa: PT012
        done = pool.submit(let_go.wait, 60)
        raise KeyboardInterrupt
    assert not done.done()
    let_go.set()
    with at_once(2) as pool:
        done = pool.submit(let_go.wait, 60)
    assert done.result()
