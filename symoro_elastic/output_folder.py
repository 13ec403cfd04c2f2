"""Folders of generated files: written completely or not at all, never over files of the user."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from symoro_elastic.errors import InputError

MANIFEST = "generated.json"


def write_files(folder: Path, files: dict[str, str]) -> list[Path]:
    """Write generated files and a list of them; remove files of an earlier run that are no longer generated.

    Raises `InputError` for a folder that holds other things or cannot be written.
    """
    files = {**files, MANIFEST: json.dumps({"generator": "symoro_elastic", "files": sorted(files)}, indent=2) + "\n"}
    try:
        earlier = _earlier_files(folder)
        _refuse_to_replace([folder / name for name in files if name not in earlier and name != MANIFEST])
        folder.mkdir(parents=True, exist_ok=True)
        _write_all(folder, files)
        for name in earlier - set(files):
            (folder / name).unlink(missing_ok=True)
    except OSError as error:
        raise InputError(str(folder), "--out", f"cannot be written ({error.strerror}): choose another folder") from None
    return [folder / name for name in files]


def _earlier_files(folder: Path) -> set[str]:
    if not folder.exists():
        return set()
    if not folder.is_dir():
        raise InputError(str(folder), "--out", "is a file: choose another folder")
    manifest = folder / MANIFEST
    if manifest.is_file():
        return _listed(manifest)
    if any(folder.iterdir()):
        raise InputError(
            str(folder), "--out", "holds files that were not generated: choose another folder with --out, or move them"
        )
    return set()


def _refuse_to_replace(paths: Iterable[Path]) -> None:
    for path in paths:
        if path.exists() or path.is_symlink():
            raise InputError(str(path), "--out", "was not generated: move it away, or choose another folder with --out")


def _listed(manifest: Path) -> set[str]:
    try:
        names = json.loads(manifest.read_text(encoding="utf-8"))["files"]
        return {name for name in names if name not in ("", "..") and Path(name).name == name}
    except (ValueError, KeyError, TypeError):
        raise InputError(str(manifest), "files", "is no list of generated files: move the folder away") from None


def _write_all(folder: Path, files: dict[str, str]) -> None:
    """Write temporary files first, so that a full disk leaves the old files unchanged."""
    with tempfile.TemporaryDirectory(prefix=".writing-", dir=folder) as staging:
        for name, text in files.items():
            (Path(staging) / name).write_text(text, encoding="utf-8", newline="\n")
        for name in files:
            os.replace(Path(staging) / name, folder / name)
