"""Formats of machine files by name, for help texts and completion: known without the readers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class FormatName(NamedTuple):
    """A format of machine files: its title, the suffixes of its files, and whether machines are written in it too.

    `is_robot` says whether files describe robots as links and joints, whose table is computed: --snap rounds it.
    """

    title: str
    suffixes: tuple[str, ...]
    is_written: bool = False
    is_robot: bool = False


TOML = FormatName("TOML", (".toml",), is_written=True)
SYMORO = FormatName("SYMORO", (".par",), is_written=True)
URDF = FormatName("URDF", (".urdf",), is_written=True, is_robot=True)
MJCF = FormatName("MJCF", (".xml",), is_written=True, is_robot=True)
DISTAL = FormatName("DH table", (".csv",), is_robot=True)
FORMAT_NAMES = (TOML, SYMORO, URDF, MJCF, DISTAL)
"""Every format, in the order of the reference."""


def suffixes(formats: Sequence[FormatName] = FORMAT_NAMES, *, written: bool = False) -> tuple[str, ...]:
    """The suffixes of formats, all or those that machines are written in."""
    return tuple(suffix for form in formats if form.is_written or not written for suffix in form.suffixes)


def is_robot(source: str) -> bool:
    """Whether a file describes a robot as links and joints, by its suffix."""
    return any(form.is_robot and source.lower().endswith(form.suffixes) for form in FORMAT_NAMES)


def in_words(words: Sequence[str], last: str = "or") -> str:
    """Words as a list of English: ".toml, .par or .urdf"."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end
