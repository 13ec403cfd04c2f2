"""Columns of numbers from .csv and .npz files, within bounds that are checked before any work.

Nothing is unpickled, no array is made before its size is known, and no more is read than was announced.
"""

from __future__ import annotations

import csv
import io
import math
import re
import struct
import warnings
import zipfile
import zlib
from array import array
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np

from symoro_elastic.formats.kinds_of_files import FileKind, read_as
from symoro_elastic.formats.separated import COMMA, Decimals, separator_of
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import open_file, size_of
from symoro_elastic.foundation.sizes import MOST_IN_FILES, MOST_SAMPLES

Columns = dict[str, Array]
"""Arrays of a file by name."""
Rows = Iterator[tuple[int, list[str]]]
"""Cells of lines with their numbers."""

MOST_BYTES = 1_000_000_000
MOST_COLUMNS = 1000
MOST_IN_LINE = 100_000  # characters
SEPARATORS = {"|": "bars"}
NO_UNIT = ("", "-", "1")
UNIT = re.compile(r"(?!(nan|inf(inity)?)$)[^\W\d_]|[°%]", re.IGNORECASE)
NUMBERS, NUMBERS_AND_TEXTS = "fiu", "fiucU"  # kinds of dtype
NUMBER = re.compile(r"[+-]?((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|nan|inf(inity)?)", re.ASCII | re.IGNORECASE)
ARRAY_MAGIC = b"\x93NUMPY"
DAMAGED = (
    OSError, ValueError, TypeError, EOFError, RuntimeError, NotImplementedError, KeyError, OverflowError, SyntaxError,
    MemoryError, struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def read_arrays(path: str | Path, may_be_empty: bool = False) -> Columns:
    """Return the columns of a .csv file, or the arrays of a .npz file, by name; cells that `may_be_empty` are NaN.

    Raises `InputError`.
    """
    return read_arrays_of(path, NUMBERS, may_be_empty)


def read_arrays_of(path: str | Path, kinds: str, may_be_empty: bool = False) -> dict[str, Any]:
    """Return columns and arrays as `read_arrays` does, those of a .npz file of these kinds of dtype.

    Complex ones and texts among them are as they are, of up to three axes.
    """
    path = Path(path)
    with read_as(FileKind.TABLE, path):
        return _read(path, kinds, may_be_empty)


def _read(path: Path, kinds: str, may_be_empty: bool) -> Columns:
    readers: dict[str, Callable[[Path, BinaryIO], Columns]]
    read_text = partial(_read_csv, may_be_empty=may_be_empty)
    readers = {".npz": partial(_read_npz, kinds=kinds), ".csv": read_text, ".txt": read_text}
    if path.suffix.lower() not in readers:
        raise InputError(str(path), "file name", "motions and measurements are .csv or .npz files")
    with open_file(path) as file:
        _refuse_size_of_file(path, size_of(file))
        return readers[path.suffix.lower()](path, file)


def _refuse_size_of_file(path: Path, size: int) -> None:
    if size == 0:
        raise _error(path, "is empty")
    if size > MOST_BYTES:
        raise _error(path, f"{size / 1e9:.3g} GB, {MOST_BYTES / 1e9:g} GB is the limit: cut or thin out the record")


def _error(path: Path, what: str, place: str = "file") -> InputError:
    return InputError(str(path), place, what)


def _refuse_size(path: Path, place: str, rows: int, numbers: int) -> None:
    """Raise `InputError` for more samples or numbers than there is room for."""
    if rows > MOST_SAMPLES or numbers > MOST_IN_FILES:
        what = (
            f"{rows} samples, {numbers} numbers in the file; {MOST_SAMPLES:.0e} samples and {MOST_IN_FILES:.0e} numbers"
        )
        raise _error(path, f"{what} at most are read: cut or thin out the record", place)


# CSV


def _read_csv(path: Path, file: BinaryIO, may_be_empty: bool) -> Columns:
    try:
        (rows, has_commas), decimals = _rows(path, file), Decimals()
        header, rows = _with_units(path, _header(path, *next(rows, (1, []))), rows)
        numbers = array("d")
        for line, row in rows:
            cells = row if has_commas else _with_points(path, line, row, decimals)
            numbers.extend(_numbers(path, line, cells, header, may_be_empty))
            _refuse_size(path, f"line {line}", len(numbers) // len(header), len(numbers))
    except (UnicodeDecodeError, csv.Error):
        raise _error(path, "cannot be read: is not text of comma-separated columns in UTF-8") from None
    if not numbers:
        raise _error(path, "holds no samples: a header line, then one line a sample")
    return dict(zip(header, np.array(numbers).reshape(-1, len(header)).T.copy(), strict=True))


def place_of_sample(path: str | Path, sample: int) -> str:
    """Name the place of a sample, counted from 0: its line in a .csv file too."""
    place, path = f"sample {sample + 1}", Path(path)
    if path.suffix.lower() == ".npz":
        return place
    with open_file(path) as file:
        rows = _rows(path, file)[0]
        _, rows = _with_units(path, _header(path, *next(rows)), rows)
        line, _ = next(islice(rows, sample, None))
    return f"{place}, line {line}"


def _rows(path: Path, file: BinaryIO) -> tuple[Iterator[tuple[int, list[str]]], bool]:
    """Return the cells of the lines that are not empty, with their numbers, and whether commas separate columns."""
    stream = io.TextIOWrapper(file, newline="", encoding="utf-8-sig")
    lines = iter(lambda: stream.readline(MOST_IN_LINE), "")

    def short() -> Iterator[str]:
        for number, line in enumerate(lines, start=1):
            if len(line) == MOST_IN_LINE:
                raise _error(path, f"is longer than {MOST_IN_LINE} characters: this is not a table", f"line {number}")
            yield line

    text = short()
    first, header = next(((k, line) for k, line in enumerate(text, start=1) if line.strip()), (1, ""))
    separator = separator_of(header)

    def cells() -> Iterator[tuple[int, list[str]]]:
        for number, row in enumerate(csv.reader(chain([header], text), delimiter=separator), start=first):
            if any(map(str.strip, row)):
                yield number, row

    return cells(), separator == COMMA


def _with_points(path: Path, line: int, row: Sequence[str], decimals: Decimals) -> list[str]:
    try:
        return decimals.with_points(row)
    except ValueError as error:
        raise _error(path, str(error), f"line {line}") from None


def _header(path: Path, line: int, row: Sequence[str]) -> list[str]:
    """Return the names of the columns."""
    header, place = [name.strip() for name in row], f"line {line}"
    if not header:
        raise _error(path, "holds no samples: a header line, then one line a sample")
    for separator, name in SEPARATORS.items():
        if len(header) == 1 and separator in header[0]:
            what = f"columns are separated by {name}: separate them by commas, semicolons or tabs"
            raise _error(path, what, place)
    if len(header) > MOST_COLUMNS:
        raise _error(path, f"{len(header)} columns, {MOST_COLUMNS} is the limit", place)
    if NUMBER.fullmatch(header[0]):
        what = "the first line holds numbers: it must name the columns, such as t, q_<joint>, tau_<motor>"
        raise _error(path, what, place)
    if len(set(header)) < len(header):
        double = next(name for name in header if header.count(name) > 1)
        raise _error(path, "two columns have this name", double)
    return header


def _with_units(path: Path, header: list[str], rows: Rows) -> tuple[list[str], Rows]:
    """Return names of columns with the units of a line of their own behind them, `t [s]`, and the rows of numbers.

    In such a line each cell is a unit, or none; the first one is a unit.
    """
    line, row = next(rows, (0, []))
    units = [cell.strip().strip("[]()").strip() for cell in row]
    may_be = len(units) == len(header) and all(one in NO_UNIT or UNIT.match(one) for one in units)
    if not may_be or units[0] in NO_UNIT:
        return header, chain([(line, row)] if row else [], rows)
    for name, unit in zip(header, units, strict=True):
        if unit not in NO_UNIT and name.endswith("]"):
            raise _error(path, f"has its unit in line {line}, too: keep one of the two", name)
    return [name if unit in NO_UNIT else f"{name} [{unit}]" for name, unit in zip(header, units, strict=True)], rows


def _numbers(path: Path, line: int, row: Sequence[str], header: Sequence[str], may_be_empty: bool) -> list[float]:
    if len(row) != len(header):
        raise _error(path, f"has {len(row)} cells, the header has {len(header)}", f"line {line}")
    try:
        numbers = [float(cell) for cell in row]
        if (text := "".join(row)).isascii() and "_" not in text:
            return numbers
    except ValueError:
        pass
    if may_be_empty:
        row = [cell if cell.strip() else "nan" for cell in row]
    for name, cell in zip(header, row, strict=True):
        if not NUMBER.fullmatch(cell.strip(" \t")):
            what = f"{cell.strip()[:30]!r} is not a number" if cell.strip() else "is empty: a gap in the data"
            raise _error(path, f"line {line}: {what}; cut the record there or measure again", name)
    return [float(cell) for cell in row]


# NPZ


def _read_npz(path: Path, file: BinaryIO, kinds: str) -> Columns:
    try:
        if file.read(len(ARRAY_MAGIC)) == ARRAY_MAGIC:
            raise _error(path, "is a single array (.npy): save it with numpy.savez(FILE, t=..., q=..., tau=...)")
        with zipfile.ZipFile(file) as archive:
            return _arrays(path, archive, kinds)
    except DAMAGED:
        raise _error(path, "cannot be read as arrays of numbers: damaged, or not a file of numpy.savez") from None


def _arrays(path: Path, archive: zipfile.ZipFile, kinds: str) -> Columns:
    members = [info for info in archive.infolist() if info.filename.endswith(".npy")]
    if len(members) > MOST_COLUMNS:
        raise _error(path, f"{len(members)} arrays, {MOST_COLUMNS} is the limit")
    names = [info.filename.removesuffix(".npy") for info in members]
    if len(set(names)) < len(names):
        raise _error(path, "two arrays have this name", next(name for name in names if names.count(name) > 1))
    if not names:
        raise _error(path, "holds no array")
    count, arrays = 0, {}
    for name, info in zip(names, members, strict=True):
        with archive.open(info) as stream:
            shape, fortran, dtype = _announced(path, name, stream, kinds)
            count += math.prod(shape)
            _refuse_size(path, name, shape[0], count)
            arrays[name] = _array(path, name, stream, shape, fortran, dtype)
    return arrays


def _announced(path: Path, name: str, stream: IO[bytes], kinds: str) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, order and type of an array from its header; refuse what is not a table of these kinds."""
    read = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    version = np.lib.format.read_magic(stream)
    if version not in read:
        raise ValueError
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        shape, fortran, dtype = read[version](stream)
    if dtype.kind == "c" and "c" not in kinds:
        raise _error(path, "holds complex numbers: save their real parts if that is what is meant", name)
    if dtype.kind not in kinds:
        raise _error(path, "holds text or objects, not arrays of numbers", name)
    if len(shape) not in (1, 2, 3)[: 2 if kinds == NUMBERS else 3] or min(shape) < 0:
        raise _error(path, f"has shape {shape}: one axis, or samples x joints", name)
    return shape, fortran, dtype


def _array(
    path: Path, name: str, stream: IO[bytes], shape: tuple[int, ...], fortran: bool, dtype: np.dtype[Any]
) -> Array:
    size = math.prod(shape) * dtype.itemsize
    content = stream.read(size + 1)
    if len(content) != size:
        more = "more" if len(content) > size else "fewer"
        raise _error(path, f"holds {more} numbers than its shape {shape} says", name)
    found = np.frombuffer(content, dtype).reshape(shape, order="F" if fortran else "C")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return found.astype(float) if dtype.kind in NUMBERS else found
