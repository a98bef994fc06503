"""A run's folder: its number, what is never overwritten, when it is made."""

import os
import re

import pytest

from tests.tuner.helpers import snapshot
from tuner.atomic import WriteError
from tuner.run.folder import RunFolder, open_folder


def opened(path=None, *, force=False, resume=False):
    return open_folder(path, "toy", force=force, resume=resume)


def refused(sentence, *arguments, **options):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        opened(*arguments, **options)


def test_numbering(here):
    for number in ("001", "002", "003"):
        folder = opened()
        assert folder.path == here.relative_to(here) / "runs" / f"toy-{number}"
        folder.write("study.toml", b"")
    assert opened().path.name == "toy-004"
    assert open_folder(None, "other", force=False, resume=False).path.name == "other-001"
    # A gap is filled, and a file takes a number as well.
    (here / "runs" / "toy-002" / "study.toml").unlink()
    (here / "runs" / "toy-002").rmdir()
    assert opened().path.name == "toy-002"
    (here / "runs" / "toy-002").touch()
    assert opened().path.name == "toy-004"


def test_nothing_is_made_before_the_first_file(here):
    folder = opened(here / "a" / "b")
    opened()
    assert snapshot(here) == {}
    assert folder.write("exports/gyro.json", b"{}") == "exports/gyro.json"
    assert (here / "a" / "b" / "exports" / "gyro.json").read_bytes() == b"{}"


def test_files_side_by_side_are_those_that_were_given(here):
    folder = opened(here / "out")
    files = {f"exports/{k}.txt": f"text {k}".encode() for k in range(40)} | {"one": b"1"}
    assert folder.write_all(files) == list(files)
    assert {name: (here / "out" / name).read_bytes() for name in files} == files
    assert folder.write_all({}) == []
    with pytest.raises(WriteError, match="one exists"):
        folder.write_all({"another": b"", "one": b"2"})
    assert (here / "out" / "one").read_bytes() == b"1"


def test_an_empty_folder_will_do(here):
    (here / "out").mkdir()
    assert opened(here / "out") == RunFolder(here / "out", overwrite=False)


def test_an_occupied_folder_needs_force(here):
    (here / "out").mkdir()
    (here / "out" / "mine.txt").write_text("precious")
    refused(
        f"--out {here / 'out'} is not empty; name another folder, or --force to replace its files",
        here / "out",
    )
    forced = opened(here / "out", force=True)
    forced.write("result.json", b"new")
    assert (here / "out" / "mine.txt").read_text() == "precious"


def test_files_are_replaced_only_where_that_was_asked_for(here):
    careful = opened(here / "out")
    careful.write("study.toml", b"one")
    with pytest.raises(WriteError, match=r"study.toml exists; give another name"):
        careful.write("study.toml", b"two")
    assert (here / "out" / "study.toml").read_bytes() == b"one"
    careful.write("progress.json", b"1", replace=True)
    careful.write("progress.json", b"2", replace=True)
    assert (here / "out" / "progress.json").read_bytes() == b"2"
    RunFolder(here / "out", overwrite=True).write("study.toml", b"two")
    assert (here / "out" / "study.toml").read_bytes() == b"two"


def test_a_file_is_no_folder(here):
    (here / "file").write_text("x")
    refused(f"--out {here / 'file'} is a file; name a folder", here / "file")
    refused(f"--out {here / 'file'} is a file; name a folder", here / "file", force=True)
    (here / "link").symlink_to(here / "nowhere")
    refused(f"--out {here / 'link'} is a file; name a folder", here / "link")
    assert sorted(os.listdir(here)) == ["file", "link"]


def test_a_folder_that_cannot_be_made(here):
    (here / "file").write_text("x")
    folder = opened(here / "file" / "below")
    sentence = f"the folder {here / 'file' / 'below'} cannot be made (Not a directory); choose"
    with pytest.raises(WriteError, match=f"^{re.escape(sentence)} another --out$"):
        folder.write("study.toml", b"")


def test_a_folder_that_cannot_be_read(here, monkeypatch):
    (here / "out").mkdir()

    def refuse(self):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(type(here), "iterdir", refuse)
    refused(f"--out {here / 'out'} cannot be read: Permission denied", here / "out")


RESUME = "--resume needs --out with the folder of an interrupted run"


def test_resume_needs_an_interrupted_run(here):
    refused(RESUME, resume=True)
    refused(RESUME, here / "nowhere", resume=True)
    (here / "out").mkdir()
    refused(RESUME, here / "out", resume=True)
    (here / "out" / "result.json").write_text("{}")
    refused(RESUME, here / "out", resume=True, force=True)
    (here / "out" / "study.toml").write_text("")
    refused(RESUME, here / "out", resume=True)  # finished
    (here / "out" / "progress.json").write_text("[]")
    assert opened(here / "out", resume=True).overwrite
    for name in ("progress.json", "result.json"):
        (here / "out" / name).unlink()
    assert opened(here / "out", resume=True).overwrite  # interrupted as it began


def test_remove(here):
    folder = opened(here / "out")
    folder.write("progress.json", b"")
    folder.remove("progress.json")
    folder.remove("progress.json")
    assert snapshot(here / "out") == {}
