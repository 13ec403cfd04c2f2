"""Folders of generated files: written completely or not at all, never over files or changes of the user."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.foundation.output_files import (
    STAGING,
    alone_in,
    failures,
    is_forced,
    make_folder,
    refuse_folder,
    write_all,
)

MANIFEST = "generated.json"


@dataclass(frozen=True)
class Manifest:
    """Names of the files that a run has written to a folder, and SHA-256 of their texts by name."""

    names: frozenset[str] = frozenset()
    hashes: Mapping[str, str] = field(default_factory=dict)

    def wrote(self, name: str, hashed: str) -> bool:
        """Return whether the run may have written a file with this hash; a list without hashes leaves that open."""
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
        earlier = _earlier(folder)
        own = {MANIFEST, *(name for manifest in earlier for name in manifest.names)}
        _refuse_others(folder, [name for name in files if name not in own])
        _refuse_changed(folder, [*earlier, Manifest(frozenset(hashes), hashes)])
        written = write_all(texts, folder, "--out", own)
        for name in own - set(texts):
            _remove(folder, name)
    return written


def _earlier(folder: Path) -> list[Manifest]:
    """What earlier runs have written to a folder, and those were writing that were killed."""
    others = [path for path in folder.iterdir() if not path.name.startswith(STAGING)]
    paths = [*folder.glob(f"{STAGING}*/{MANIFEST}"), folder / MANIFEST]
    found = [manifest for path in paths if (manifest := _read(path))]
    if others and not found and not is_forced():
        what = "holds files that were not generated: choose another folder with --out, or write into it with --force"
        raise InputError(str(folder), "--out", what)
    return found


def _remove(folder: Path, name: str) -> None:
    """Remove a file, and the folders in `folder` that are empty then."""
    path = folder / name
    path.unlink(missing_ok=True)
    with suppress(OSError):
        for parent in path.parents[: len(Path(name).parts) - 1]:
            parent.rmdir()


def _is_within(folder: Path, name: str) -> bool:
    """Whether a listed name is a file below a folder, not reached through links or steps upwards."""
    parts = name.split("/")
    if not all(part not in ("", "..") and Path(part).name == part for part in parts):
        return False
    return not any((folder / "/".join(parts[:k])).is_symlink() for k in range(1, len(parts)))


def _read(path: Path) -> Manifest | None:
    """The list of files at a path, None where there is none."""
    if not os.path.exists(path):
        return None
    try:
        found = json.loads(read_file(path, "files").decode("utf-8"))
        names = frozenset(name for name in found["files"] if _is_within(path.parent, name))
        return Manifest(names, {str(name): str(value) for name, value in found.get("sha256", {}).items()})
    except (ValueError, KeyError, TypeError, AttributeError):
        if is_forced() or path.parent.name.startswith(STAGING):
            return None
        raise InputError(str(path), "files", "is not a list of generated files: move the folder away") from None


def _refuse_changed(folder: Path, known: Sequence[Manifest]) -> None:
    """Raise `InputError` for a file whose text is not one of those known."""
    listed = {name for manifest in known for name in manifest.names}
    for name in sorted(name for name in listed if is_plain_file(folder / name) and not is_forced()):
        path = folder / name
        text = _hash(read_file(path, "--out"))
        if not any(manifest.wrote(name, text) for manifest in known):
            what = "was changed since it was generated: keep a copy elsewhere, or replace it with --force"
            raise InputError(str(path), "--out", what)


def _refuse_others(folder: Path, names: Iterable[str]) -> None:
    for path in (folder / name for name in names):
        if os.path.lexists(path) and not is_forced():
            what = "was not generated: move it away, choose another folder with --out, or replace it with --force"
            raise InputError(str(path), "--out", what)


def _hash(text: bytes) -> str:
    """SHA-256 of a text, whatever the line ends of its checkout."""
    return hashlib.sha256(text.replace(b"\r\n", b"\n")).hexdigest()
