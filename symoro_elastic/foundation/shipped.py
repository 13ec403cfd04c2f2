"""Folders that come with the package: inside it when it is installed from a wheel, beside it in a checkout."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
EXAMPLES, SCENES = "examples", "scenes"
SUFFIXES = (".toml", ".par", ".urdf", ".xml")
"""Of examples, in the order in which a name without suffix is looked for."""


def shipped_folder(name: str, holding: str) -> Path:
    """Return a folder that comes with the package, which has another one in it; raises `FileNotFoundError`."""
    places = (PACKAGE / name, PACKAGE.parent / name)
    for place in places:
        if (place / holding).is_dir():
            return place
    raise FileNotFoundError(f"no {name} in {places[0]} nor in {places[1]}: reinstall symoro-elastic")


def examples(*, scenes: bool = True) -> dict[str, Path]:
    """Return the examples by name, without suffix where no other is called so: machines, and scenes of them."""
    files = list(_files(scenes))
    found: dict[str, Path] = {}
    for path in sorted(files, key=lambda path: (path.stem, SUFFIXES.index(path.suffix))):
        found[path.name if path.stem in found else path.stem] = path
    return dict(sorted(found.items()))


def example_called(name: str) -> str:
    """Return the name of the example whose file has this name, empty where there is none."""
    return next((known for known, path in examples().items() if path.name == name), "")


def _files(scenes: bool) -> Iterator[Path]:
    try:
        folder = shipped_folder(EXAMPLES, SCENES)
    except FileNotFoundError:
        return
    folders = (folder, folder / SCENES) if scenes else (folder,)
    yield from (path for each in folders for path in each.iterdir() if path.suffix in SUFFIXES)
