"""Files replaced together: all or none, as those that they replace."""

from __future__ import annotations

import errno
import json
import os
import signal
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from symoro_elastic.foundation import replacing
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import MANIFEST, permission, write_all, write_file, write_files
from symoro_elastic.foundation.replacing import JOURNAL, OLD, STAGING, replace_files

OLDER = {"a.c": b"old one", "b.c": b"old two", "sub/c.c": b"old three"}
NEWER = {"a.c": b"new one", "b.c": b"the new two", "d.c": b"new four"}
STALE = ("sub/c.c",)


class Killed(BaseException):
    """The end of a process that undoes nothing."""


def contents(folder: Path) -> dict[str, bytes]:
    paths = (path for path in folder.rglob("*") if path.is_file() and STAGING not in str(path))
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def leftovers(folder: Path) -> list[Path]:
    return [*folder.rglob(f"{STAGING}*")]


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    for name, content in OLDER.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    return tmp_path


def fail_at(monkeypatch: pytest.MonkeyPatch, number: int, error: BaseException) -> None:
    """Let the call of that number, of those that rename or remove, raise an error."""
    calls = iter(range(1, 100))

    def failing(real: Callable[..., None]) -> Callable[..., None]:
        def call(*arguments: Any, **named: Any) -> None:
            if next(calls) == number:
                raise error
            real(*arguments, **named)

        return call

    monkeypatch.setattr(os, "replace", failing(os.replace))
    monkeypatch.setattr(Path, "unlink", failing(Path.unlink))


@pytest.mark.parametrize("number", range(1, 6))
@pytest.mark.parametrize("error", [PermissionError(errno.EACCES, "held open"), KeyboardInterrupt(), SystemExit(143)])
def test_an_error_at_any_file_puts_the_old_ones_back(
    number: int, error: BaseException, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fail_at(monkeypatch, number, error)
    with pytest.raises(type(error)):
        replace_files(folder, NEWER, STALE)
    assert contents(folder) == OLDER and not leftovers(folder)


@pytest.mark.parametrize("number", range(1, 6))
def test_the_next_run_undoes_what_a_killed_one_began(
    number: int, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        fail_at(patched, number, Killed())
        patched.setattr(replacing, "_undo", lambda *_: None)
        with pytest.raises(Killed):
            replace_files(folder, NEWER, STALE)
    assert (contents(folder) == OLDER) == (number == 1) and len(leftovers(folder)) == 1
    replace_files(folder, {"other": b""})
    assert contents(folder) == {**OLDER, "other": b""} and not leftovers(folder)


def test_files_that_were_changed_after_a_kill_stay(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patched:
        fail_at(patched, 4, Killed())
        patched.setattr(replacing, "_undo", lambda *_: None)
        with pytest.raises(Killed):
            replace_files(folder, NEWER, STALE)
    (folder / "a.c").write_bytes(b"mine")
    replace_files(folder, {"other": b""})
    assert contents(folder) == {**OLDER, "a.c": b"mine", "other": b""}


def test_a_killed_run_is_healed_whatever_the_next_one_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_files(tmp_path, {"a.c": "one", "b.c": "two", "c.c": "three"})
    for number in range(1, 5):
        with monkeypatch.context() as patched:
            fail_at(patched, number, Killed())
            patched.setattr(replacing, "_undo", lambda *_: None)
            with pytest.raises(Killed):
                write_files(tmp_path, {"a.c": "new one", "d.c": "four"})
        write_files(tmp_path, {"a.c": f"one {number}", "b.c": "two", "c.c": "three"})
        assert set(contents(tmp_path)) == {"a.c", "b.c", "c.c", MANIFEST} and not leftovers(tmp_path)


def test_old_files_that_cannot_be_put_back_are_kept_for_the_next_run(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        held = os.replace

        def replace(source: Path, target: Path) -> None:
            if target.name == "b.c" or OLD in Path(source).parts:
                raise PermissionError(errno.EACCES, "held open")
            held(source, target)

        patched.setattr(os, "replace", replace)
        with pytest.raises(OSError, match="held open; some files are new now, and others old: write all of them again"):
            replace_files(folder, NEWER)
    assert contents(folder)["a.c"] == b"new one"
    replace_files(folder, {"other": b""})
    assert contents(folder) == {**OLDER, "other": b""} and not leftovers(folder)


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, '{"replaced": 3}', '{"replaced": {}, "in_place": 1}', "[]"])
def test_a_journal_that_was_not_finished_changes_nothing(text: str, folder: Path) -> None:
    (folder / f"{STAGING}dead").mkdir()
    (folder / f"{STAGING}dead" / JOURNAL).write_text(text)
    replace_files(folder, {"other": b""})
    assert contents(folder) == {**OLDER, "other": b""} and not leftovers(folder)


def test_a_journal_reaches_no_file_outside_of_the_folder(folder: Path) -> None:
    outside = folder.parent / f"{folder.name} outside"
    outside.mkdir()
    (outside / "mine").write_bytes(b"mine")
    (folder / "link").symlink_to(outside)
    left = folder / f"{STAGING}dead"
    (left / OLD).mkdir(parents=True)
    digest = replacing._digest(outside / "mine")
    names = (f"../{outside.name}/mine", "link/mine", str(outside / "mine"))
    (left / JOURNAL).write_text(json.dumps({"replaced": dict.fromkeys(names, digest), "in_place": []}))
    replace_files(folder, {"other": b""})
    assert (outside / "mine").read_bytes() == b"mine"


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="there are no owners of files")
def test_what_other_users_left_is_neither_put_back_nor_followed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They could have files of a folder that all write to, such as /tmp, replaced by theirs."""
    left = folder / f"{STAGING}dead"
    (left / OLD).mkdir(parents=True)
    (left / OLD / "a.c").write_bytes(b"theirs")
    (left / JOURNAL).write_text(json.dumps({"replaced": {"a.c": replacing._digest(folder / "a.c")}, "in_place": []}))
    (folder / f"{STAGING}link").symlink_to(left)
    with monkeypatch.context() as patched:
        patched.setattr(os, "getuid", lambda: 4321)
        replace_files(folder, {"other": b""})
    assert contents(folder) == {**OLDER, "other": b""} and len(leftovers(folder)) > 1
    replace_files(folder, {"other": b""})
    assert contents(folder) == {**OLDER, "a.c": b"theirs", "other": b""}
    assert [path.name for path in folder.glob(f"{STAGING}*")] == [f"{STAGING}link"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_wait_until_all_files_are_in_place(
    number: signal.Signals, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replaced, heard = os.replace, []

    def interrupted(source: Path, target: Path) -> None:
        signal.raise_signal(number)
        replaced(source, target)

    monkeypatch.setattr(os, "replace", interrupted)
    before = signal.signal(number, lambda *_: heard.append(contents(folder)))
    try:
        replace_files(folder, NEWER, STALE)
    finally:
        signal.signal(number, before)
    assert heard == [NEWER] * 3


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="names of open files are not known here")
def test_files_are_on_the_disk_before_and_folders_after_renaming(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    replaced = os.replace
    monkeypatch.setattr(os, "fsync", lambda opened: done.append(os.readlink(f"/proc/self/fd/{opened}")))
    monkeypatch.setattr(os, "replace", lambda source, target: (done.append("rename"), replaced(source, target)))
    replace_files(folder, NEWER)
    first, last = done.index("rename"), len(done) - done[::-1].index("rename")
    assert [Path(name).name for name in done[:first]] == [*NEWER, JOURNAL]
    assert done[last:] == [str(folder)]


# As those that they replace


def forced(content: bytes, path: Path) -> None:
    with permission(force=True):
        write_file(content, path)


def test_read_only_files_are_refused(tmp_path: Path) -> None:
    """Those that this user may not write, and those that nobody may, whom the first user could write, too."""
    path = tmp_path / "a.c"
    path.write_bytes(b"mine")
    path.chmod(0o444)
    with pytest.raises(InputError, match=r"a\.c: file: is read-only: make it writable, or choose another name"):
        forced(b"new", path)
    with permission(force=True), pytest.raises(InputError, match="is read-only"):
        write_all({"b.c": b"", "a.c": b""}, tmp_path)
    assert contents(tmp_path) == {"a.c": b"mine"} and path.stat().st_mode & 0o777 == 0o444


def test_generated_files_that_are_read_only_are_neither_replaced_nor_removed(tmp_path: Path) -> None:
    write_files(tmp_path, {"a.c": "one", "b.c": "two"})
    before = contents(tmp_path)
    (tmp_path / "b.c").chmod(0o444)
    for files in ({"a.c": "new"}, {"a.c": "new", "b.c": "new"}):
        with pytest.raises(InputError, match=r"b\.c: --out: is read-only"):
            write_files(tmp_path, files)
    assert contents(tmp_path) == before


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only the first user gives files away")
def test_owner_and_group_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"old")
    os.chown(path, 4321, 1234)
    path.chmod(0o4750)
    forced(b"new", path)
    found = path.stat()
    assert (found.st_uid, found.st_gid, found.st_mode & 0o7777) == (4321, 1234, 0o4750)
    assert path.read_bytes() == b"new"


def test_a_file_whose_owner_or_attributes_cannot_be_kept_is_written_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"a longer old text")
    number = path.stat().st_ino
    with monkeypatch.context() as patched:
        patched.setattr(replacing, "_attributes", lambda path: {"security.of": bytes(path)})
        forced(b"new", path)
    assert (path.stat().st_ino, contents(tmp_path)) == (number, {"a": b"new"}) and not leftovers(tmp_path)

    def refuse(*_: object) -> None:
        raise PermissionError(errno.EPERM, "not permitted")

    monkeypatch.setattr(os, "chown", refuse)
    monkeypatch.setattr(os, "stat", lambda path, **more: Owned(real(path, **more), Path(path).parent == tmp_path))
    forced(b"newer", path)
    assert (real(path).st_ino, path.read_bytes()) == (number, b"newer")


real = os.stat


class Owned:
    """What is known of a file, which belongs to another user."""

    def __init__(self, of: os.stat_result, is_foreign: bool) -> None:
        self.of, self.is_foreign = of, is_foreign

    def __getattr__(self, name: str) -> Any:
        return 4321 if name == "st_uid" and self.is_foreign else getattr(self.of, name)

    def __getitem__(self, place: int) -> Any:
        return self.of[place]


def test_extended_attributes_are_kept(tmp_path: Path) -> None:
    """An access control list is one: for user 4321 to read and write."""
    path = tmp_path / "a"
    path.write_bytes(b"old")
    entries = ((1, 6, -1), (2, 6, 4321), (4, 4, -1), (16, 6, -1), (32, 4, -1))
    access = struct.pack("<I", 2) + b"".join(struct.pack("<HHi", *entry) for entry in entries)
    try:
        os.setxattr(path, "user.note", b"mine")
        os.setxattr(path, "system.posix_acl_access", access)
    except (AttributeError, OSError):
        pytest.skip("no extended attributes here")
    forced(b"new", path)
    assert path.read_bytes() == b"new"
    assert (os.getxattr(path, "user.note"), os.getxattr(path, "system.posix_acl_access")) == (b"mine", access)


def test_all_names_of_a_file_have_the_new_text(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old, and longer")
    (tmp_path / "b").hardlink_to(tmp_path / "a")
    with permission(force=True):
        write_all({"a": b"new", "c": b"third"}, tmp_path)
    assert contents(tmp_path) == {"a": b"new", "b": b"new", "c": b"third"} and not leftovers(tmp_path)


@pytest.mark.parametrize("written", [0, 2, 20])
@pytest.mark.parametrize("is_killed", [False, True])
def test_a_file_that_is_half_written_in_place_gets_its_old_text_back(
    written: int, is_killed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a").write_bytes(b"the old text")
    (tmp_path / "b").hardlink_to(tmp_path / "a")
    write = os.write

    def fail(opened: int, content: bytes) -> int:
        if bytes(content).startswith(b"a new"):
            write(opened, content[:written])
            raise Killed if is_killed else OSError(errno.ENOSPC, "No space left on device")
        return write(opened, content)

    with monkeypatch.context() as patched:
        patched.setattr(os, "write", fail)
        if is_killed:
            patched.setattr(replacing, "_undo", lambda *_: None)
        with pytest.raises(Killed if is_killed else InputError):
            forced(b"a new and longer text", tmp_path / "a")
    if is_killed:
        write_file(b"", tmp_path / "c")
        (tmp_path / "c").unlink()
    assert contents(tmp_path) == {"a": b"the old text", "b": b"the old text"} and not leftovers(tmp_path)


def test_a_link_is_followed_or_never(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"mine")
    (tmp_path / "link").symlink_to(tmp_path / "a")
    with permission(force=True), pytest.raises(InputError, match="is a link: give the name of the file itself"):
        write_file(b"new", tmp_path / "link", follow=False)
    assert (tmp_path / "a").read_bytes() == b"mine"
    forced(b"new", tmp_path / "link")
    assert (tmp_path / "a").read_bytes() == b"new" and (tmp_path / "link").is_symlink()
