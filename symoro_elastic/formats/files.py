"""Reading of text files; every failure is an `InputError`."""

from __future__ import annotations

import codecs
import re
from collections.abc import Sequence
from pathlib import Path

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import read_file

MAX_BYTES = 5_000_000
UTF_8, WESTERN = "utf-8-sig", "cp1252"


def load_text(path: str | Path, encodings: Sequence[str] = (UTF_8,)) -> str:
    """The text of a file in the first valid encoding, at most 5 MB, without byte order mark."""
    return text_of(read_file(path, most=MAX_BYTES + 1), str(path), encodings)


def text_of(content: bytes, source: str, encodings: Sequence[str] = (UTF_8,)) -> str:
    """Return the text of the content of a file, as `load_text` does."""
    if len(content) > MAX_BYTES:
        raise InputError(source, "file", f"larger than {MAX_BYTES // 10**6} MB: too large for a machine description")
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise InputError(source, "line 1, column 1", "the file is UTF-16 text: save it as UTF-8")
    failed = None
    for encoding in encodings:
        try:
            return content.decode(encoding)
        except UnicodeDecodeError as error:
            failed = failed or error
    assert failed is not None
    before = content[: failed.start].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    line, column = before.count(b"\n") + 1, len(before.rpartition(b"\n")[2].decode("utf-8", "replace")) + 1
    what = f"the byte {content[failed.start]:#04x} is not UTF-8: save the file as UTF-8 text"
    raise InputError(source, f"line {line}, column {column}", what)


def name_of(text: str) -> str:
    """Return a valid machine name made from a free text, such as the name of its file without suffix."""
    stem = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_")
    return stem if re.match("[A-Za-z]", stem) else f"m{stem}"
