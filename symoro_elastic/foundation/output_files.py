"""Files that the program writes: never one of its inputs, existing ones with --force only, whole or not at all.

Contents are written to a folder `.writing-XXXX` beside their targets and then renamed: a full disk or a kill leaves
the old files. A folder of that name that a killed run has left is removed by the next run that writes there.
"""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import OF_FILES
from symoro_elastic.foundation.input_files import AT_ONCE, is_plain_file, kind_of_file

try:
    import fcntl
except ImportError:  # Windows: leftovers of killed runs stay there
    fcntl = None  # type: ignore[assignment]

STAGING = ".writing-"


@dataclass(frozen=True)
class Permission:
    """Which files may be written: none of `inputs`, existing ones only with `force`."""

    inputs: tuple[Path, ...] = ()
    force: bool = False


_permission: ContextVar[Permission] = ContextVar("permission", default=Permission())  # noqa: B039  (frozen)


@contextmanager
def permission(inputs: Collection[str | Path] = (), force: bool = False) -> Iterator[None]:
    """Set what may be written within a block; outside of one existing files are kept."""
    token = _permission.set(Permission(tuple(map(Path, inputs)), force))
    try:
        yield
    finally:
        _permission.reset(token)


def is_forced() -> bool:
    """Return whether existing files may be replaced."""
    return _permission.get().force


def refuse_file(path: str | Path, place: str = "file") -> None:
    """Raise `InputError` for a file that `write_file` would not write."""
    _refuse_name(path, place)
    target = Path(path)
    with failures(path, place):
        if target.is_dir():
            raise InputError(str(path), place, "cannot be written: it is a folder, give the name of a file")
        if not Path(os.path.realpath(target)).parent.is_dir():
            raise InputError(str(path), place, "cannot be written: its folder does not exist: create it first")
        if not _takes_bytes(target):
            _refuse_to_replace(target, place)


def refuse_folder(path: str | Path, place: str = "folder") -> None:
    """Raise `InputError` for a folder that is a file, or that cannot be made since a file is in its way.

    One that is not there yet is none that is called as a file: `report.txt`.
    """
    _refuse_name(path, place)
    with failures(path, place):
        for folder in (Path(path), *Path(path).parents):
            if folder.suffix.lower() in OF_FILES and not os.path.lexists(folder):
                what = (
                    f"a folder would be made, and {folder.suffix} ends names of files: leave it out, or make it first"
                )
                raise InputError(str(folder), place, what)
            if folder.exists() and not folder.is_dir():
                what = "is a file, not a folder: choose another folder"
                raise InputError(str(folder), place, what)


def write_file(content: bytes, path: str | Path, place: str = "file") -> None:
    """Write a file that the user has named; links are followed, its folder must exist. Raises `InputError`."""
    refuse_file(path, place)
    target = Path(os.path.realpath(path))
    with failures(path, place):
        if _takes_bytes(target):
            target.write_bytes(content)
        else:
            replace_files(target.parent, {target.name: content})


def write_text(text: str, path: str | Path, place: str = "file") -> None:
    """Write a text as UTF-8 with plain line ends, as `write_file` does. Raises `InputError`."""
    write_file(text.encode("utf-8"), path, place)


def write_all(
    contents: Mapping[str, bytes], folder: Path, place: str = "folder", own: Collection[str] = ()
) -> list[Path]:
    """Write files to a folder, all or none, and return their paths; the folder is made, links in it are replaced.

    Folders in names are made; one that is a link is refused. The files `own` may be replaced without --force. Raises
    `InputError`, and leaves no empty folder behind then.
    """
    refuse_folder(folder, place)
    with failures(folder, place):
        for name in contents:
            _refuse_to_replace(folder / name, place, own=name in own)
        with ExitStack() as stack:
            for parent in sorted({(folder / name).parent for name in contents} | {folder}):
                _refuse_link(folder, parent, place)
                stack.enter_context(make_folder(parent))
            replace_files(folder, contents)
    return [folder / name for name in contents]


def fill_folder(folder: Path, texts: Mapping[str, str]) -> None:
    """Write texts to a folder of the program itself, such as a temporary one, which is made. Raises `OSError`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


def replace_files(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Write files beside those of the same names, then rename them, in this order. Raises `OSError`."""
    with _staging(folder) as staging:
        for name, content in contents.items():
            (staging / name).parent.mkdir(parents=True, exist_ok=True)
            (staging / name).write_bytes(content)
            with suppress(FileNotFoundError):
                shutil.copymode(folder / name, staging / name)
        for name in contents:
            os.replace(staging / name, folder / name)


@contextmanager
def failures(path: str | Path, place: str) -> Iterator[None]:
    """Turn errors of the operating system into `InputError`."""
    try:
        yield
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(str(path), place, f"cannot be written ({reason}): choose another place") from None


def _refuse_name(path: str | Path, place: str) -> None:
    name = str(path)
    if not name.strip() or not name.isprintable():
        what = "is not a name of a file: give one of printable characters, on one line"
        raise InputError(repr(name), place, what)


def _refuse_to_replace(target: Path, place: str, own: bool = False) -> None:
    """Raise `InputError` for a file that stays: an input, or one that is there already."""
    if not os.path.lexists(target):
        return
    for path in _permission.get().inputs:
        if path.exists() and target.exists() and os.path.samefile(path, target):
            raise InputError(str(target), place, "is read by this command: choose another name")
    if target.is_dir():
        raise InputError(str(target), place, "is a folder: move it away, or choose another place")
    if target.exists() and not is_plain_file(target):
        raise InputError(str(target), place, f"is a {kind_of_file(os.stat(target))}: give the name of a file")
    if not (own or is_forced()):
        raise InputError(str(target), place, "exists already: choose another name, or replace it with --force")


def _refuse_link(folder: Path, parent: Path, place: str) -> None:
    """Raise `InputError` for a folder below another one that is a link, or that a file stands in the way of."""
    steps = parent.relative_to(folder).parts
    for each in (folder.joinpath(*steps[: k + 1]) for k in range(len(steps))):
        if each.is_symlink():
            raise InputError(str(each), place, "is a link: files are written to real folders only, move it away")
        refuse_folder(each, place)


def _takes_bytes(path: Path) -> bool:
    """Whether a path is a device that takes bytes one by one, such as /dev/null or a terminal; a pipe is none."""
    return path.is_char_device()


@contextmanager
def make_folder(folder: Path) -> Iterator[None]:
    """Make a folder and its parents; where the block fails, remove those that were made and are empty."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for each in missing:
            with suppress(OSError):
                each.rmdir()
        raise


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Wait until no other run writes generated files to a folder, at most a minute, and keep others waiting."""
    for _ in range(600):
        lock = _lock(folder)
        if lock is not None or fcntl is None:
            break
        time.sleep(0.1)
    try:
        yield
    finally:
        if lock is not None:
            os.close(lock)


@contextmanager
def _staging(folder: Path) -> Iterator[Path]:
    """An empty folder in `folder`, locked while the process lives, and removed in the end."""
    for leftover in folder.glob(f"{STAGING}*"):
        _remove_leftover(leftover)
    staging, lock = _locked(folder)
    try:
        yield staging
    finally:
        shutil.rmtree(staging, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def _locked(folder: Path) -> tuple[Path, int | None]:
    """A new folder and its lock; another one where a run that cleans up was faster than the lock."""
    while True:
        staging = Path(tempfile.mkdtemp(prefix=STAGING, dir=folder))
        lock = _lock(staging)
        if staging.is_dir():
            return staging, lock
        if lock is not None:
            os.close(lock)


def _lock(staging: Path) -> int | None:
    """The open, locked folder; None where it is locked by another process, or cannot be locked."""
    if fcntl is None:
        return None
    try:
        opened = os.open(staging, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return None
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(opened)
        return None
    return opened


def _remove_leftover(staging: Path) -> None:
    """Remove a folder of a killed run; one of a live process is locked, and stays."""
    lock = _lock(staging)
    if lock is not None:
        shutil.rmtree(staging, ignore_errors=True)
        os.close(lock)


@contextmanager
def open_at_end(path: str | Path, place: str = "file") -> Iterator[Callable[[bytes], None]]:
    """Open a file at its end, and give what writes a block to it, whole and at once; other runs are kept out.

    Raises `InputError` where it cannot be written, where it is a link or no plain file, and where another run writes
    it.
    """
    _refuse_name(path, place)
    with failures(path, place):
        opened = _opened_at_end(path, place)

    def write(block: bytes) -> None:
        with failures(path, place):
            while block:
                block = block[os.write(opened, block) :]

    try:
        _lock_or_refuse(opened, path, place)
        yield write
    finally:
        os.close(opened)


def _opened_at_end(path: str | Path, place: str) -> int:
    """Return a plain file opened at its end without waiting; it is made where nothing is there."""
    if os.path.islink(path):
        raise InputError(str(path), place, "is a link: give the name of the file itself")
    if os.path.exists(path) and not is_plain_file(path):
        raise InputError(str(path), place, f"is a {kind_of_file(os.stat(path))}: give the name of a file")
    opened = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | AT_ONCE | getattr(os, "O_NOFOLLOW", 0), 0o666)
    if stat.S_ISREG(os.fstat(opened).st_mode):
        return opened
    os.close(opened)
    raise InputError(str(path), place, "is not a plain file: give the name of one")


def _lock_or_refuse(opened: int, path: str | Path, place: str) -> None:
    if fcntl is None:
        return
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        what = "is being written by another run: wait for it, or choose another name"
        raise InputError(str(path), place, what) from None


def cut_file(path: str | Path, length: int, place: str = "file") -> None:
    """Shorten a file to its first bytes. Raises `InputError`."""
    with failures(path, place):
        os.truncate(path, length)


def remove_file(path: str | Path) -> None:
    """Remove a file of the program itself, if it is there."""
    with suppress(OSError):
        os.unlink(path)
