"""Files of a folder replaced together: all of them, or none.

New files wait in a folder `.writing-XXXX` near their targets, where old ones stay until all new ones are in place. An
error puts the old ones back; after a kill the next run that writes to the folder does so.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import signal
import stat
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from symoro_elastic.foundation.input_files import AT_ONCE, NO_LINK

if sys.platform == "win32":
    import msvcrt
else:
    try:
        import fcntl
    except ImportError:  # a browser: there is one process
        fcntl = None  # type: ignore[assignment]

STAGING = ".writing-"
NEW, OLD, JOURNAL = "new", "old", "journal.json"
LOCK = f"{STAGING}lock"
"""A file that is locked in place of its folder, where folders cannot be opened."""
LOCKED_BYTE = 2**31 - 2
"""Byte that is locked of a file on Windows, where locked bytes cannot be read: the last one that can be, 2 GB on."""
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


def replace_files(folder: Path, contents: Mapping[str, bytes], stale: Iterable[str] = ()) -> None:
    """Remove `stale` files of a folder and write others, in this order: all or none.

    Owner, mode and extended attributes of a file are preserved. A file with several names (hard links), and one whose
    owner or attributes cannot be given to another, is overwritten in place. Links are replaced. Raises `OSError`.
    """
    with delayed_signals(), _staging(folder) as staging:
        in_place = [name for name in contents if not _write_staged(folder / name, staging / NEW / name, contents[name])]
        stale = [name for name in stale if os.path.lexists(folder / name)]
        try:
            if len(contents) + len(stale) > 1 or in_place:
                _write_journal(folder, staging, contents, in_place, stale)
            for name in stale:
                (folder / name).unlink()
            for name, content in contents.items():
                if name in in_place:
                    _overwrite(folder / name, content)
                else:
                    os.replace(staging / NEW / name, folder / name)
            for parent in {(folder / name).parent for name in contents}:
                with suppress(OSError):  # not every system opens folders
                    _sync(parent, os.O_RDONLY)
            if (staging / JOURNAL).exists():
                (staging / JOURNAL).unlink()
        except BaseException:
            _undo_or_report(folder, staging)
            raise


def _write_staged(target: Path, staged: Path, content: bytes) -> bool:
    """Write the new content of a target; return whether that file can replace it."""
    staged.parent.mkdir(parents=True, exist_ok=True)
    staged.write_bytes(content)
    _sync(staged, os.O_RDWR)
    if not os.path.lexists(target) or not stat.S_ISREG(os.lstat(target).st_mode):
        return True
    replaced, present = os.stat(target), os.stat(staged)
    with suppress(OSError):
        if (replaced.st_uid, replaced.st_gid) != (present.st_uid, present.st_gid):
            os.chown(staged, replaced.st_uid, replaced.st_gid)
        shutil.copystat(target, staged)
        os.utime(staged)
        return replaced.st_nlink == 1 and _attributes(staged) == _attributes(target)
    return False


def _attributes(path: Path) -> dict[str, bytes]:
    """The extended attributes of a file, including its access control list; none if the system has none."""
    with suppress(AttributeError, OSError):
        return {name: os.getxattr(path, name) for name in os.listxattr(path)}
    return {}


def _write_journal(
    folder: Path, staging: Path, contents: Mapping[str, bytes], in_place: Iterable[str], stale: Iterable[str]
) -> None:
    """Back up the old files of a folder, and record which ones are about to be replaced, and by what."""
    for name in (*contents, *stale):
        _keep(folder / name, staging / OLD / name, name in in_place)
    replaced = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    journal = {"replaced": replaced | dict.fromkeys(stale, ""), "in_place": [*in_place]}
    (staging / JOURNAL).write_text(json.dumps(journal), encoding="utf-8")
    _sync(staging / JOURNAL, os.O_RDWR)


def _keep(path: Path, backup: Path, is_overwritten: bool) -> None:
    """Back up a file, if it exists: by a hard link, or by a copy if it is overwritten or cannot be linked."""
    backup.parent.mkdir(parents=True, exist_ok=True)
    if not os.path.lexists(path):
        return
    if not is_overwritten:
        with suppress(OSError, NotImplementedError):
            os.link(path, backup, follow_symlinks=False)
            return
    shutil.copy2(path, backup, follow_symlinks=False)


def _overwrite(path: Path, content: bytes) -> None:
    """Overwrite the content of a file from its beginning; it is truncated last."""
    opened = os.open(path, os.O_WRONLY | AT_ONCE | NO_LINK)
    try:
        remaining = memoryview(content)
        while remaining:
            remaining = remaining[os.write(opened, remaining) :]
        os.ftruncate(opened, len(content))
        os.fsync(opened)
    finally:
        os.close(opened)


def _sync(path: Path, flags: int) -> None:
    """Wait until a file is on the disk, if the file system supports it."""
    opened = os.open(path, flags | AT_ONCE)
    try:
        os.fsync(opened)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS):
            raise
    finally:
        os.close(opened)


# Old files put back


def _undo_or_report(folder: Path, staging: Path) -> None:
    try:
        _undo(folder, staging)
    except OSError as error:
        what = f"{error.strerror}; some files are new now, and others old: write all of them again"
        raise OSError(error.errno, what) from None


def _undo(folder: Path, staging: Path) -> None:
    """Restore the old files of a journal; files that changed since they were replaced stay.

    Without a journal nothing was replaced. Raises `OSError`, and can be repeated then.
    """
    try:
        journal = json.loads((staging / JOURNAL).read_bytes())
        replaced, in_place = dict(journal["replaced"]), [*journal["in_place"]]
    except FileNotFoundError:
        return
    except (ValueError, TypeError, KeyError, RecursionError):  # it was not finished
        replaced, in_place = {}, []
    for name, digest in replaced.items():
        path, old = folder / name, staging / OLD / name
        if not is_within(folder, name):
            continue
        if name in in_place:
            _undo_overwriting(path, (staging / NEW / name).read_bytes(), old.read_bytes())
        elif _digest(path) in ("", digest):
            if os.path.lexists(old):
                os.replace(old, path)
            else:
                path.unlink(missing_ok=True)
    (staging / JOURNAL).unlink()


def _undo_overwriting(path: Path, new: bytes, old: bytes) -> None:
    """Restore the old content of a file that holds the new content, or its beginning followed by the old rest."""
    present = path.read_bytes()
    least = min(len(present), len(new))
    common = next((k for k in range(least) if present[k] != new[k]), least)
    if present == new or present[common:] == old[common:]:
        _overwrite(path, old)


def _digest(path: Path) -> str | None:
    """SHA-256 of a regular file; empty for a missing one, None for other types."""
    if not os.path.lexists(path):
        return ""
    if path.is_symlink() or not stat.S_ISREG(os.lstat(path).st_mode):
        return None
    return hashlib.sha256(path.read_bytes()).hexdigest()


def is_within(folder: Path, name: str) -> bool:
    """Return whether a listed name is a file below a folder, without links and parent steps."""
    parts = name.split("/")
    if not all(part not in ("", "..") and Path(part).name == part and part.isprintable() for part in parts):
        return False
    return not any((folder / "/".join(parts[:k])).is_symlink() for k in range(1, len(parts)))


def undo_killed_runs(folder: Path) -> None:
    """Undo the replacements of this user's killed runs in a folder, and remove their folders.

    Those of live processes are locked, and stay.
    """
    for leftover in folder.glob(f"{STAGING}*"):
        if _is_ours(leftover) and (lock := lock_folder(leftover)) is not None:
            with suppress(OSError):
                _undo(folder, leftover)
            _remove(leftover, lock)


def _is_ours(leftover: Path) -> bool:
    """Whether a folder exists, is not a link, and belongs to this user."""
    with suppress(OSError):
        status = os.lstat(leftover)
        return stat.S_ISDIR(status.st_mode) and (sys.platform == "win32" or status.st_uid == os.getuid())
    return False


@contextmanager
def _staging(folder: Path) -> Iterator[Path]:
    """An empty folder in `folder`, locked while the process lives; removed unless it holds old files."""
    undo_killed_runs(folder)
    staging, lock = _lock(folder)
    try:
        yield staging
    finally:
        _remove(staging, lock)


def _remove(staging: Path, lock: int | None) -> None:
    """Remove and unlock a folder, unless its journal must be undone."""
    if lock is not None:
        os.close(lock)
    for _ in range(2):  # what another process holds open for a moment is removed the second time
        if not (staging / JOURNAL).exists():
            shutil.rmtree(staging, ignore_errors=True)


def _lock(folder: Path) -> tuple[Path, int | None]:
    """Return a new folder and its lock; another one if a cleaning run locked it first."""
    while True:
        staging = Path(tempfile.mkdtemp(prefix=STAGING, dir=folder))
        lock = lock_folder(staging)
        if staging.is_dir():
            return staging, lock
        if lock is not None:
            os.close(lock)


def lock_folder(folder: Path) -> int | None:
    """Lock a folder until the result is closed; None if another process has it, or locks fail."""
    try:
        if sys.platform == "win32":
            opened = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT | os.O_TEMPORARY)
        else:
            opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return None
    if lock(opened):
        return opened
    os.close(opened)
    return None


def lock(opened: int) -> bool:
    """Lock an open file until it is closed; return whether it was free."""
    try:
        if sys.platform == "win32":
            os.lseek(opened, LOCKED_BYTE, os.SEEK_SET)
            msvcrt.locking(opened, msvcrt.LK_NBLCK, 1)
        elif fcntl is not None:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:  # the file system has no locks
        return True
    return True


@contextmanager
def delayed_signals() -> Iterator[None]:
    """Delay signals that would end the block until its end."""
    if threading.current_thread() is not threading.main_thread():  # others are not interrupted
        yield
        return
    delayed: list[int] = []
    numbers = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
    handlers = {number: signal.getsignal(number) for number in numbers}
    try:
        for number, handler in handlers.items():
            if handler not in (None, signal.SIG_IGN):
                signal.signal(number, lambda number, _: delayed.append(number))
        yield
    finally:
        for number, handler in handlers.items():
            if handler not in (None, signal.SIG_IGN):
                signal.signal(number, handler)
        for number in delayed:
            signal.raise_signal(number)
