"""Files appear whole or not at all, and none is lost."""

import errno
import os
import threading
from pathlib import Path

import pytest

from tests.tuner.export_cases import gyroscope, tuned
from tuner.atomic import WriteError, write_bytes
from tuner.export import FORMATS, ExportError, dump, load, suffix, write


def refuse(code):
    def call(*_args, **_kwargs):
        raise OSError(code, os.strerror(code))

    return call


@pytest.mark.parametrize("format", FORMATS)
def test_writes_every_format(tmp_path, format):
    path = write(gyroscope(), tmp_path / f"gyro{suffix(format)}", format)
    assert load(path.read_bytes(), format) == gyroscope()
    assert os.listdir(tmp_path) == [path.name]


def test_takes_a_path_as_text_in_this_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert write(gyroscope(), "gyro.h", "c") == Path("gyro.h")
    assert (tmp_path / "gyro.h").read_bytes() == dump(gyroscope(), "c")


def test_has_the_rights_of_any_new_file(tmp_path):
    (tmp_path / "plain").write_bytes(b"")
    path = write(gyroscope(), tmp_path / "gyro.h", "c")
    assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_takes_the_longest_names(tmp_path):
    write_bytes(tmp_path / ("x" * 255), b"x")
    assert os.listdir(tmp_path) == ["x" * 255]


def test_keeps_what_is_there(tmp_path):
    path = write(gyroscope(), tmp_path / "gyro.json", "json")
    with pytest.raises(ExportError) as raised:
        write(tuned(), path, "json")
    assert str(raised.value) == f"{path} exists; give another name, or replace it with --force"
    assert load(path.read_bytes(), "json") == gyroscope()
    write(tuned(), path, "json", overwrite=True)
    assert load(path.read_bytes(), "json") == tuned()
    assert os.listdir(tmp_path) == [path.name]


def test_keeps_a_link_that_leads_nowhere(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    with pytest.raises(WriteError, match="exists"):
        write_bytes(tmp_path / "link", b"x")
    assert os.listdir(tmp_path) == ["link"]


@pytest.mark.parametrize("call", ["fsync", "replace", "link"])
@pytest.mark.parametrize("overwrite", [False, True])
def test_leaves_nothing_after_a_failure(tmp_path, monkeypatch, call, overwrite):
    old = tmp_path / "old"
    old.write_bytes(b"old")
    monkeypatch.setattr(os, call, refuse(errno.ENOSPC))
    path = old if overwrite else tmp_path / "new"
    unused = {False: "replace", True: "link"}[overwrite]
    if call == unused:
        write_bytes(path, b"new", overwrite=overwrite)
        assert path.read_bytes() == b"new"
        return
    with pytest.raises(WriteError) as raised:
        write_bytes(path, b"new", overwrite=overwrite)
    reason = "No space left on device"
    assert str(raised.value) == f"{path} cannot be written ({reason}); choose another place"
    assert os.listdir(tmp_path) == ["old"]
    assert old.read_bytes() == b"old"


def test_leaves_nothing_after_an_interrupt(tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "link", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_bytes(tmp_path / "new", b"new")
    assert os.listdir(tmp_path) == []


def test_another_process_that_is_faster_keeps_its_file(tmp_path, monkeypatch):
    path, link = tmp_path / "gyro.h", os.link

    def overtaken(*args):
        path.write_bytes(b"theirs")
        link(*args)

    monkeypatch.setattr(os, "link", overtaken)
    with pytest.raises(WriteError, match="exists"):
        write_bytes(path, b"ours")
    assert path.read_bytes() == b"theirs"
    assert os.listdir(tmp_path) == [path.name]


def test_of_many_writers_one_wins(tmp_path):
    path, lost = tmp_path / "gyro.h", []
    start = threading.Barrier(8)

    def attempt(i):
        start.wait()
        try:
            write_bytes(path, bytes([i]) * 100_000)
        except WriteError:
            lost.append(i)

    threads = [threading.Thread(target=attempt, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (winner,) = set(range(8)) - set(lost)
    assert path.read_bytes() == bytes([winner]) * 100_000
    assert os.listdir(tmp_path) == [path.name]


class TestWithoutLinks:
    """Memory cards have no hard links."""

    @pytest.fixture(autouse=True)
    def _no_links(self, monkeypatch):
        monkeypatch.setattr(os, "link", refuse(errno.EPERM))

    def test_writes(self, tmp_path):
        write_bytes(tmp_path / "new", b"new")
        assert (tmp_path / "new").read_bytes() == b"new"
        assert os.listdir(tmp_path) == ["new"]

    def test_leaves_nothing_after_a_failure(self, tmp_path, monkeypatch):
        monkeypatch.setattr(os, "replace", refuse(errno.EIO))
        with pytest.raises(WriteError, match="cannot be written"):
            write_bytes(tmp_path / "new", b"new")
        assert os.listdir(tmp_path) == []

    def test_another_process_that_is_faster_keeps_its_file(self, tmp_path, monkeypatch):
        path = tmp_path / "new"

        def overtaken(*_):
            path.write_bytes(b"theirs")
            raise OSError(errno.EPERM, "no links")

        monkeypatch.setattr(os, "link", overtaken)
        with pytest.raises(WriteError, match="exists"):
            write_bytes(path, b"ours")
        assert path.read_bytes() == b"theirs"
        assert os.listdir(tmp_path) == ["new"]


def test_says_in_one_sentence_why_it_cannot_write(tmp_path, monkeypatch):
    for path, reason in (
        (tmp_path / "none" / "gyro.h", "No such file or directory"),
        (Path(__file__) / "gyro.h", "Not a directory"),
    ):
        with pytest.raises(ExportError) as raised:
            write(gyroscope(), path, "c")
        assert str(raised.value) == f"{path} cannot be written ({reason}); choose another place"
    with pytest.raises(ExportError, match=r"cannot be written \(Is a directory\)"):
        write(gyroscope(), tmp_path, "c", overwrite=True)
    monkeypatch.setattr(Path, "open", refuse(errno.EACCES))
    with pytest.raises(ExportError, match=r"cannot be written \(Permission denied\)"):
        write(gyroscope(), tmp_path / "gyro.json", "json")


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(ExportError, match=r"cannot be written \(Permission denied\)"):
        write(gyroscope(), tmp_path / "gyro.h", "c")
    tmp_path.chmod(0o700)
    assert os.listdir(tmp_path) == []
