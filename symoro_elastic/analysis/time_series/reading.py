"""Columns of numbers from .csv and .npz files, within size limits that are checked first.

Nothing is unpickled, no array is made before its size is known, and no more is read than was announced.
"""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
import struct
import warnings
import zipfile
import zlib
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np

from symoro_elastic.formats.kinds_of_files import FileKind, read_as
from symoro_elastic.formats.separated import (
    COMMA,
    NUMBER,
    SPACES,
    Decimals,
    cells_of,
    is_comment,
    separator_of,
    separator_of_numbers,
    without_mark,
)
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import MOST_IN_FILES, MOST_SAMPLES, TWICE, InputError
from symoro_elastic.foundation.input_files import open_file, size_of
from symoro_elastic.quantities.unit_reader import is_unit


class Columns(dict[str, Array]):
    """Columns of a file by name; `notes` are lines about omitted data."""

    notes: tuple[str, ...] = ()


Rows = Iterator[tuple[int, list[str]]]
"""Cells of lines with their numbers."""

MOST_BYTES = 1_000_000_000
MOST_COLUMNS = 1000
MOST_IN_LINE = 100_000  # characters
SEPARATORS = {"|": "bars"}
NO_UNIT = ("", "-", "1")
UNIT = re.compile(r"(?!(nan|inf(inity)?)$)[^\W\d_]|[°%]|1/", re.IGNORECASE)
_IN_BRACKETS = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<unit>[^\[\]]*)\]|\((?P<rounded>[^()]*(?:\([^()]*\)[^()]*)*)\))", re.DOTALL
)
FIRST_NAMES = ("t", "time", "f", "frequency")
MOST_ABOVE = 200
"""Lines of a preamble."""
NUMBERS, NUMBERS_AND_TEXTS = "fiu", "fiucU"  # kinds of dtype
NO_SAMPLES = "holds no samples: a header line, then one line a sample"
NO_NAMES = "the first line holds numbers: it must name the columns, such as t, q_<joint>, tau_<motor>"
BEGUN = re.compile(r"[+-]?\d*\.?\d*([eE][+-]?)?", re.ASCII)
"""The beginning of a number."""
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


def read_arrays_of(path: str | Path, kinds: str, may_be_empty: bool = False) -> Columns:
    """Return columns and arrays as `read_arrays` does, those of a .npz file only if their dtype is of `kinds`.

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
        size = size_of(file)
        if size == 0:
            raise _error(path, "is empty")
        if size > MOST_BYTES:
            raise _error(path, f"{size / 1e9:.3g} GB, {MOST_BYTES / 1e9:g} GB is the limit: cut or thin out the record")
        return readers[path.suffix.lower()](path, file)


def _error(path: Path, what: str, place: str = "file") -> InputError:
    return InputError(str(path), place, what)


def _refuse_size(path: Path, place: str, rows: int, numbers: int) -> None:
    """Raise `InputError` for more samples or numbers than the limits."""
    if rows > MOST_SAMPLES or numbers > MOST_IN_FILES:
        most = f"{MOST_SAMPLES:.0e} samples and {MOST_IN_FILES:.0e} numbers at most are read"
        what = f"{rows} samples, {numbers} numbers in the file; {most}: cut or thin out the record"
        raise _error(path, what, place)


# CSV


def _read_csv(path: Path, file: BinaryIO, may_be_empty: bool) -> Columns:
    try:
        with _text(file) as text:
            return _columns(path, text, may_be_empty)
    except (UnicodeDecodeError, csv.Error):
        raise _error(path, "cannot be read: is not text of columns in UTF-8 or UTF-16") from None


def _columns(path: Path, text: io.TextIOWrapper, may_be_empty: bool) -> Columns:
    header, rows, has_commas = _table(path, text)
    numbers, decimals, columns = array("d"), Decimals(), Columns()
    for line, row in rows:
        try:
            cells = row if has_commas else _with_points(path, line, row, decimals)
            numbers.extend(_numbers(path, line, cells, header, may_be_empty))
        except InputError:
            if not numbers or not _is_cut(row, header) or next(rows, None):
                raise
            columns.notes = (f"line {line}, the last one, is cut: left out",)
        _refuse_size(path, f"line {line}", len(numbers) // len(header), len(numbers))
    if not numbers:
        raise _error(path, NO_SAMPLES)
    columns |= dict(zip(header, np.array(numbers).reshape(-1, len(header)).T.copy(), strict=True))
    return columns


def place_of_sample(path: str | Path, sample: int) -> str:
    """Return where a sample, counted from 0, is in a file: also its line in a .csv file."""
    place, path = f"sample {sample + 1}", Path(path)
    if path.suffix.lower() == ".npz":
        return place
    with open_file(path) as file, _text(file) as text:
        line, _ = next(islice(_table(path, text)[1], sample, None))
    return f"{place}, line {line}"


def _table(path: Path, text: io.TextIOWrapper) -> tuple[list[str], Rows, bool]:
    """Return names of columns, the cells of the lines below them, and whether commas are separators.

    The header is the first line that has a name for each number of the first line of numbers, preferably one that names
    the time or the frequency; lines above it are a preamble. Lines that begin as comments do hold no numbers.
    """
    lines, above = _lines(path, text), list[tuple[int, str]]()
    separator, numbers = "", list[tuple[int, str]]()
    for number, line in lines:
        separator = "" if is_comment(line) else separator_of_numbers(line)
        (numbers if separator else above).append((number, line))
        if separator or len(above) == MOST_ABOVE:
            break
    if not above:
        raise _error(path, *((NO_NAMES, f"line {numbers[0][0]}") if numbers else (NO_SAMPLES, "file")))
    separator = separator or separator_of(without_mark(above[0][1]))
    heads = [(number, cells_of(without_mark(line), separator)) for number, line in above]
    k = _place_of_header(heads, cells_of(numbers[0][1], separator) if numbers else [])
    header, below = _header(path, *heads[k]), above[k + 1 :]
    if below and _are_units(heads[k + 1][1], header):
        header, below = _with_units(path, header, *heads[k + 1]), below[1:]
    rows = _rows(chain(below, numbers, lines), separator)
    return header, ((number, _cut_to(len(header), row)) for number, row in rows), separator == COMMA


def _place_of_header(heads: Sequence[tuple[int, list[str]]], numbers: Sequence[str]) -> int:
    """Return the index of the header among the lines before the first numbers; the first line by default."""
    counts = {len(numbers), len(_cut_to(0, numbers))}
    may_be = [
        (k, cells)
        for k, (_, cells) in enumerate(heads)
        if cells
        and len(_cut_to(0, cells)) in counts
        and all(map(str.strip, cells[:-1]))
        and not NUMBER.fullmatch(cells[0])
    ]
    timed = [k for k, cells in may_be if any(name_and_unit(cell)[0].lower() in FIRST_NAMES for cell in cells)]
    return (timed or [k for k, _ in may_be] or [0])[0]


def _cut_to(count: int, cells: Sequence[str]) -> list[str]:
    """Return cells without empty ones at the end beyond `count`: a separator may end a line."""
    last = max((k for k, cell in enumerate(cells, start=1) if cell.strip()), default=1)
    return list(cells[: max(count, last)])


def _text(file: BinaryIO) -> io.TextIOWrapper:
    """Return a text stream on a binary file, with the encoding detected."""
    start = file.read(MOST_IN_LINE)
    file.seek(0)
    return io.TextIOWrapper(file, newline="", encoding=_encoding(start))


def _lines(path: Path, text: io.TextIOWrapper) -> Iterator[tuple[int, str]]:
    """Yield the lines that are not blank, with their numbers."""
    lines = iter(lambda: text.readline(MOST_IN_LINE), "")
    for number, line in enumerate(lines, start=1):
        if len(line) == MOST_IN_LINE:
            raise _error(path, f"is longer than {MOST_IN_LINE} characters: this is not a table", f"line {number}")
        if line.strip():
            yield number, line


def _encoding(start: bytes) -> str:
    """Return the encoding of a text: UTF-8 or 16, else that of Windows, whose degree sign is invalid UTF-8."""
    if start[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(start)
    except UnicodeDecodeError:
        return "utf-8-sig" if any(byte < ord("\t") for byte in start) else "cp1252"
    return "utf-8-sig"


def _rows(lines: Iterable[tuple[int, str]], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the cells of lines that are not comments, with the numbers of the lines."""
    place = [0]

    def texts() -> Iterator[str]:
        for place[0], line in lines:
            if not is_comment(line):
                yield line

    rows = map(str.split, texts()) if separator == SPACES else csv.reader(texts(), delimiter=separator)
    yield from ((place[0], row) for row in rows if any(map(str.strip, row)))


def _with_points(path: Path, line: int, row: Sequence[str], decimals: Decimals) -> list[str]:
    try:
        return decimals.with_points(row)
    except ValueError as error:
        raise _error(path, str(error), f"line {line}") from None


def _header(path: Path, line: int, row: Sequence[str]) -> list[str]:
    """Return the names of the columns from a header row."""
    header, place = [name.strip() for name in _cut_to(0, row)], f"line {line}"
    if not any(header):
        raise _error(path, NO_SAMPLES)
    for separator, name in SEPARATORS.items():
        if len(header) == 1 and separator in header[0]:
            what = f"columns are separated by {name}: separate them by commas, semicolons, tabs or spaces"
            raise _error(path, what, place)
    if len(header) > MOST_COLUMNS:
        raise _error(path, f"{len(header)} columns, {MOST_COLUMNS} is the limit", place)
    if NUMBER.fullmatch(header[0]):
        raise _error(path, NO_NAMES, place)
    if len(set(header)) < len(header):
        double = next(name for name in header if header.count(name) > 1)
        raise _error(path, TWICE, double)
    return header


def _are_units(row: Sequence[str], header: Sequence[str]) -> bool:
    """Return whether each cell of a line is a unit or empty, and the first is a unit."""
    units = _units_in(row)
    return len(units) == len(header) and units[0] not in NO_UNIT and all(x in NO_UNIT or UNIT.match(x) for x in units)


def _units_in(row: Sequence[str]) -> list[str]:
    return [cell.strip().strip("[]()").strip() for cell in row]


def _with_units(path: Path, header: Sequence[str], line: int, row: Sequence[str]) -> list[str]:
    """Return names of columns with units from a separate line appended, `t [s]`."""
    for name, unit in zip(header, units := _units_in(row), strict=True):
        if unit not in NO_UNIT and name_and_unit(name)[1] is not None:
            raise _error(path, f"has its unit in line {line}, too: keep one of the two", name)
    return [name if unit in NO_UNIT else f"{name} [{unit}]" for name, unit in zip(header, units, strict=True)]


def name_and_unit(text: str, is_pair: bool = False) -> tuple[str, str | None]:
    """Return a name and its unit, `q [deg]`, `q (deg)` or `q/deg`; None without a unit. Spaces are single.

    The slash of a pair, `OUT/IN`, is not that of a unit.
    """
    text = " ".join(text.split())
    name, _, unit = (part.strip() for part in text.partition("/"))
    if not is_pair and name.isidentifier() and is_unit(unit):
        return name, unit
    match = _IN_BRACKETS.fullmatch(text)
    return (match["name"], (match["unit"] or match["rounded"] or "").strip()) if match else (text, None)


def _is_cut(row: Sequence[str], header: Sequence[str]) -> bool:
    """Return whether a line of numbers is incomplete, as at the end of a stopped recording."""
    *complete, last = [cell.strip().replace(",", ".") for cell in row]
    is_begun = len(row) < len(header) or (BEGUN.fullmatch(last) and not NUMBER.fullmatch(last))
    return len(row) <= len(header) and all(map(NUMBER.fullmatch, complete)) and bool(is_begun)


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
        raise _error(path, TWICE, next(name for name in names if names.count(name) > 1))
    if not names:
        raise _error(path, "holds no array")
    count, arrays = 0, Columns()
    for name, info in zip(names, members, strict=True):
        with archive.open(info) as stream:
            shape, fortran, dtype = _layout(path, name, stream, kinds)
            count += math.prod(shape)
            _refuse_size(path, name, shape[0], count)
            arrays[name] = _array(path, name, stream, shape, fortran, dtype)
    return arrays


def _layout(path: Path, name: str, stream: IO[bytes], kinds: str) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, order and type of an array from its header; refuse tables of other kinds."""
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
    array = np.frombuffer(content, dtype).reshape(shape, order="F" if fortran else "C")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return array.astype(float) if dtype.kind in NUMBERS else array
