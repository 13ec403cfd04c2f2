"""Output files: never an input, existing ones only with --force, complete or not at all.

`replacing` does the last; what may be written is checked here.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
import tempfile
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import OF_FILES, why_not_on_windows
from symoro_elastic.foundation.input_files import AT_ONCE, NO_LINK, is_plain_file, kind_of_file, read_file
from symoro_elastic.foundation.replacing import STAGING, is_within, lock, lock_folder, replace_files, undo_killed_runs

MANIFEST = "generated.json"
MOST_BYTES = 5_000_000
"""Of a list of files: 30 000 names with their hashes."""


@dataclass(frozen=True)
class Permission:
    """Permission to write files: none of `inputs`, existing ones only with `force`."""

    inputs: tuple[Path, ...] = ()
    force: bool = False


_permission: ContextVar[Permission] = ContextVar("permission", default=Permission())  # noqa: B039  (frozen)


@contextmanager
def permission(inputs: Collection[str | Path] = (), force: bool = False) -> Iterator[None]:
    """Set the permission within a block; outside of one existing files are kept."""
    token = _permission.set(Permission(tuple(map(Path, inputs)), force))
    try:
        yield
    finally:
        _permission.reset(token)


def is_forced() -> bool:
    """Return whether existing files may be replaced."""
    return _permission.get().force


def refuse_file(path: str | Path, place: str = "file") -> None:
    """Raise `InputError` for a file that `write_file` would refuse."""
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
    """Raise `InputError` for a folder that is a file, or that a file prevents.

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


def write_file(content: bytes, path: str | Path, place: str = "file", follow: bool = True) -> None:
    """Write a file named by the user; its folder must exist. Links are followed, or never.

    Raises `InputError`.
    """
    refuse_file(path, place)
    if not follow:
        refuse_link(path, place)
    target = Path(os.path.realpath(path)) if follow else Path(path)
    with failures(path, place):
        if _takes_bytes(target):
            target.write_bytes(content)
        else:
            replace_files(target.parent, {target.name: content})


def write_text(text: str, path: str | Path, place: str = "file") -> None:
    """Write a text as UTF-8 with plain line ends, as `write_file` does. Raises `InputError`."""
    write_file(text.encode("utf-8"), path, place)


def write_all(
    contents: Mapping[str, bytes],
    folder: Path,
    place: str = "folder",
    own: Collection[str] = (),
    stale: Collection[str] = (),
) -> list[Path]:
    """Write files to a folder, all or none, and return their paths; the folder is made, links in it are replaced.

    Folders in names are made; one that is a link is refused. The files `own` may be replaced without --force, those
    that are `stale` are removed. Raises `InputError`, and leaves no empty folder behind then.
    """
    refuse_folder(folder, place)
    with failures(folder, place):
        for name in (*contents, *stale):
            _refuse_to_replace(folder / name, place, own=name in own or name in stale)
        with ExitStack() as stack:
            for parent in sorted({(folder / name).parent for name in contents} | {folder}):
                _refuse_link(folder, parent, place)
                stack.enter_context(make_folder(parent))
            replace_files(folder, contents, stale)
    return [folder / name for name in contents]


def temporary_folder() -> tempfile.TemporaryDirectory[str]:
    """Return a folder that is removed at the end of a block, except for libraries that Windows locks."""
    return tempfile.TemporaryDirectory(prefix="symoro_elastic_", ignore_cleanup_errors=True)


def fill_folder(folder: Path, texts: Mapping[str, str]) -> None:
    """Write texts to a folder of the program, such as a temporary one, which is made. Raises `OSError`."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


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
    if os.name == "nt" and (kind := why_not_on_windows(name)):
        raise InputError(name, place, f"is the name of {kind}: choose another name")


def _refuse_to_replace(target: Path, place: str, own: bool = False) -> None:
    """Raise `InputError` for a file that must stay: an input, or an existing one."""
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
    if target.exists() and not is_writable(target):
        raise InputError(str(target), place, "is read-only: make it writable, or choose another name")


def is_writable(path: Path) -> bool:
    """Return whether a file may be written by this user, and its mode allows writing."""
    return os.access(path, os.W_OK) and bool(os.stat(path).st_mode & 0o222)


def _refuse_link(folder: Path, parent: Path, place: str) -> None:
    """Raise `InputError` for a folder below another one that is a link, or that a file prevents."""
    steps = parent.relative_to(folder).parts
    for part in (folder.joinpath(*steps[: k + 1]) for k in range(len(steps))):
        if part.is_symlink():
            raise InputError(str(part), place, "is a link: files are written to real folders only, move it away")
        refuse_folder(part, place)


def _takes_bytes(path: Path) -> bool:
    """Whether a path is a character device, such as /dev/null or a terminal; not a pipe."""
    return path.is_char_device()


@contextmanager
def make_folder(folder: Path) -> Iterator[None]:
    """Make a folder and its parents; if the block fails, remove the new and empty ones."""
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for path in missing:
            with suppress(OSError):
                path.rmdir()
        raise


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Wait until no other run writes generated files to a folder, at most a minute, and block others."""
    for _ in range(600):
        opened = lock_folder(folder)
        if opened is not None:
            break
        time.sleep(0.1)
    try:
        yield
    finally:
        if opened is not None:
            os.close(opened)


@contextmanager
def open_at_end(path: str | Path, place: str = "file") -> Iterator[Callable[[bytes], None]]:
    """Open a file at its end, and yield a function that appends a block atomically; other runs are excluded.

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
        if not lock(opened):
            what = "is being written by another run: wait for it, or choose another name"
            raise InputError(str(path), place, what)
        yield write
    finally:
        os.close(opened)


def refuse_link(path: str | Path, place: str) -> None:
    """Raise `InputError` for a link."""
    if os.path.islink(path):
        raise InputError(str(path), place, "is a link: give the name of the file itself")


def _opened_at_end(path: str | Path, place: str) -> int:
    """Return a regular file opened at its end without blocking; a missing one is made."""
    refuse_link(path, place)
    if os.path.exists(path) and not is_plain_file(path):
        raise InputError(str(path), place, f"is a {kind_of_file(os.stat(path))}: give the name of a file")
    opened = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | AT_ONCE | NO_LINK, 0o666)
    if stat.S_ISREG(os.fstat(opened).st_mode):
        return opened
    os.close(opened)
    raise InputError(str(path), place, "is not a plain file: give the name of one")


def cut_file(path: str | Path, length: int, place: str = "file") -> None:
    """Shorten a file to its first bytes. Raises `InputError`."""
    with failures(path, place):
        os.truncate(path, length)


def remove_file(path: str | Path) -> None:
    """Remove a file of the program, if it exists."""
    with suppress(OSError):
        os.unlink(path)


@dataclass(frozen=True)
class Manifest:
    """Names of the files that a run has written to a folder, and SHA-256 of their texts by name."""

    names: frozenset[str] = frozenset()
    hashes: Mapping[str, str] = field(default_factory=dict)

    def wrote(self, name: str, hashed: str) -> bool:
        """Return whether the run may have written a file with this hash; True for a list without hashes."""
        return name in self.names and self.hashes.get(name, hashed) == hashed


def write_files(folder: Path, files: Mapping[str, str | bytes]) -> list[Path]:
    """Write generated files and a list of them; remove files of an earlier run that are no longer generated.

    Names may have folders (`parts/arm.m`), which are made. Raises `InputError` for a folder that cannot be written, or
    that holds other files, or files that were changed since they were generated, unless --force is given.
    """
    texts = {name: text.encode() if isinstance(text, str) else text for name, text in files.items()}
    hashes = {name: _hash(texts[name]) for name in sorted(texts)}
    manifest = {"generator": "symoro_elastic", "files": sorted(files), "sha256": hashes}
    texts[MANIFEST] = (json.dumps(manifest, indent=2) + "\n").encode()
    refuse_folder(folder, "--out")
    with failures(folder, "--out"), make_folder(folder), alone_in(folder):
        undo_killed_runs(folder)
        earlier = _earlier(folder)
        own = {MANIFEST, *earlier.names}
        _refuse_others(folder, [name for name in files if name not in own])
        _refuse_changed(folder, [earlier, Manifest(frozenset(hashes), hashes)])
        stale = own - texts.keys()
        written = write_all(texts, folder, "--out", own, stale)
        for name in stale:
            _remove_empty_parents(folder, name)
    return written


def _earlier(folder: Path) -> Manifest:
    """The manifests of earlier runs in a folder, for existing and removed files."""
    manifest = _read(folder / MANIFEST)
    if manifest is None and not is_forced() and any(not path.name.startswith(STAGING) for path in folder.iterdir()):
        what = "holds files that were not generated: choose another folder with --out, or write into it with --force"
        raise InputError(str(folder), "--out", what)
    return manifest or Manifest()


def _remove_empty_parents(folder: Path, name: str) -> None:
    """Remove the folders between `folder` and a removed file `name` in it that are empty now."""
    with suppress(OSError):
        for parent in (folder / name).parents[: len(Path(name).parts) - 1]:
            parent.rmdir()


def _read(path: Path) -> Manifest | None:
    """The list of files at a path, regular ones only; None without a list."""
    if not os.path.exists(path):
        return None
    try:
        content = read_file(path, "files", MOST_BYTES + 1)
        if len(content) > MOST_BYTES:
            raise ValueError(MOST_BYTES)
        listed = json.loads(content)
        names = frozenset(name for name in listed["files"] if _may_be_generated(path.parent, name))
        return Manifest(names, {str(name): str(value) for name, value in listed.get("sha256", {}).items()})
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        if is_forced():
            return None
        raise InputError(str(path), "files", "is not a list of generated files: move the folder away") from None


def _may_be_generated(folder: Path, name: str) -> bool:
    """Whether a listed name is a regular file below a folder, or missing."""
    return is_within(folder, name) and (is_plain_file(folder / name) or not os.path.lexists(folder / name))


def _refuse_changed(folder: Path, manifests: Sequence[Manifest]) -> None:
    """Raise `InputError` for a file whose text is in none of the manifests."""
    listed = {name for manifest in manifests for name in manifest.names}
    for name in sorted(name for name in listed if is_plain_file(folder / name) and not is_forced()):
        path = folder / name
        text = _hash(read_file(path, "--out"))
        if not any(manifest.wrote(name, text) for manifest in manifests):
            what = "was changed since it was generated: keep a copy elsewhere, or replace it with --force"
            raise InputError(str(path), "--out", what)


def _refuse_others(folder: Path, names: Iterable[str]) -> None:
    for path in (folder / name for name in names):
        if os.path.lexists(path) and not is_forced():
            what = "was not generated: move it away, choose another folder with --out, or replace it with --force"
            raise InputError(str(path), "--out", what)


def _hash(text: bytes) -> str:
    """SHA-256 of a text, independent of line ends."""
    return hashlib.sha256(text.replace(b"\r\n", b"\n")).hexdigest()
