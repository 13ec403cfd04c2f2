"""Errors that a user can mend: each names the file, the place in it, and the way out."""

from __future__ import annotations


class InputError(Exception):
    """What is wrong with a user's input, as one line `file: place: what, and what to do`."""

    def __init__(self, file: str, place: str, what: str) -> None:
        super().__init__(f"{file}: {place}: {what}")
        self.file, self.place, self.what = file, place, what
