"""The protocol of a target: a language or runtime that packages are rendered for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from symoro_elastic.codegen.described import Files
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import Precision


class Target(Protocol):
    """A target: how it is asked for, what it writes, and the names that its output uses itself."""

    @property
    def name(self) -> str:
        """The name that `--target` takes."""

    @property
    def title(self) -> str:
        """One line that says what is written."""

    @property
    def suffixes(self) -> tuple[str, ...]:
        """The suffixes of the files written."""

    @property
    def precisions(self) -> tuple[Precision, ...]:
        """The precisions it can be written in, the default first."""

    @property
    def reserved(self) -> frozenset[str]:
        """Identifiers of its language and libraries, refused as names; those of its templates are avoided."""

    def render(self, package: Package, precisions: Sequence[Precision]) -> Files:
        """Return file names and texts, in each of the precisions.

        Raises `OverflowError` for constants outside the range of double precision.
        """


def words(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(text.split())
