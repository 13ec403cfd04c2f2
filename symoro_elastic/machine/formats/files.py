"""Reading of text files; every failure is an `InputError`."""

from __future__ import annotations

import re
from pathlib import Path

from symoro_elastic.errors import InputError

MAX_BYTES = 5_000_000


def load_text(path: str | Path) -> str:
    """The text of a file: UTF-8, a byte order mark dropped, at most 5 MB."""
    file = Path(path)
    try:
        if not file.is_file():
            missing = "is no file" if file.exists() else "there is no such file"
            raise InputError(str(path), "file", missing)
        with file.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise InputError(str(path), "file", f"cannot be read: {reason}") from None
    if len(content) > MAX_BYTES:
        raise InputError(str(path), "file", f"larger than {MAX_BYTES // 10**6} MB: no machine is described so")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        what = f"byte {error.start + 1} is not UTF-8: save the file as UTF-8 text"
        raise InputError(str(path), "file", what) from None


def name_of(source: str) -> str:
    """A machine's name from the name of its file."""
    stem = re.sub(r"[^A-Za-z0-9_]", "_", Path(source).stem)
    return stem if re.match("[A-Za-z]", stem) else f"m{stem}"
