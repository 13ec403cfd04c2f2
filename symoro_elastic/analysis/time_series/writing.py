"""Files of sampled motions and torques: .csv without loss of digits, .npz."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.file_forms import COLUMNS, form_of
from symoro_elastic.foundation.output_files import refuse_file as refuse_to_write
from symoro_elastic.foundation.output_files import write_file, write_text

CSV, NPZ = ".csv", ".npz"


def columns_of(t: Array, *blocks: tuple[str, Array, Sequence[str]]) -> dict[str, Array]:
    """Return the column `t` and a column `<quantity>_<name>` for each column of the blocks, without -0."""
    columns = {"t": t}
    for quantity, block, names in blocks:
        columns |= {f"{quantity}_{name}": block[:, k] + 0.0 for k, name in enumerate(names)}
    return columns


def refuse_file(path: str | Path) -> None:
    """Raise `InputError` for a file that `write_columns` cannot write."""
    form_of(path, COLUMNS, "--out")
    refuse_to_write(path, "--out")


def write_columns(columns: Mapping[str, AnyArray], path: str | Path, units: Mapping[str, str] | None = None) -> None:
    """Write columns of equal length to a .csv file with one header line, or to a .npz file; raises `InputError`.

    `units` by column are written in brackets in the header line. Columns of a .csv file may be texts.
    """
    refuse_file(path)
    if Path(path).suffix.lower() == NPZ:
        stream = io.BytesIO()
        np.savez(stream, **columns)  # type: ignore[arg-type]
        write_file(stream.getvalue(), path)
        return
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"{name} [{units[name]}]" if units and name in units else name for name in columns])
    writer.writerows(zip(*(x.tolist() for x in columns.values()), strict=True))
    write_text(text.getvalue(), path)
