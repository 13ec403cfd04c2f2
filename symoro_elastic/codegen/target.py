"""A target: a language or runtime that packages are rendered for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import Precision


@dataclass(frozen=True)
class Target:
    """A target of code generation: its name, its files, and the names that its output reserves.

    `name` is what `--target` takes, `title` one line that says what is written, `suffixes` are those of its files,
    `precisions` those it can be written in, the default first. `reserved` are identifiers of its language and
    libraries, refused as names; those of its templates are avoided. `files` writes a package in one precision.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    precisions: tuple[Precision, ...]
    reserved: frozenset[str]
    files: Callable[[Package, Precision], Files]

    def render(self, package: Package, precisions: Sequence[Precision]) -> Files:
        """Return the texts of the files by name, in each of the precisions or in the default one.

        Raises `OverflowError` for constants outside the range of double precision.
        """
        files: Files = {}
        for precision in precisions or self.precisions[:1]:
            files |= self.files(package, precision)
        return files


def words(text: str) -> frozenset[str]:
    """The set of words of a text."""
    return frozenset(text.split())
