"""Files of sweeps: .csv with a row for each point, NetCDF with a dimension for each quantity of a grid, .npz."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.errors import InputError
from symoro_elastic.output_files import write_file, write_text
from symoro_elastic.packages import imported
from symoro_elastic.sweeps.sweep import REASON, Sweep
from symoro_elastic.time_series.writing import CSV, NPZ, write_columns

NETCDF = ".nc"
FORMS = (CSV, NETCDF, NPZ)


def refuse_form(path: str | Path) -> None:
    """Raise `InputError` for a file whose ending is none of the forms, or whose form needs a package."""
    suffix = Path(path).suffix.lower()
    if suffix not in FORMS:
        what = f"no form {Path(path).suffix!r}: end the name with {', '.join(FORMS[:-1])} or {FORMS[-1]}"
        raise InputError(str(path), "--out", what)
    if suffix == NETCDF:
        _xarray()


def save(found: Sweep, path: str | Path) -> None:
    """Write a sweep in the form of the file's ending, the same bytes for the same numbers. Raises `InputError`."""
    refuse_form(path)
    suffix = Path(path).suffix.lower()
    if suffix == CSV:
        write_text(_csv(found), path, "--out")
    elif suffix == NETCDF:
        write_file(bytes(dataset(found).to_netcdf(engine="scipy", format="NETCDF3_64BIT")), path, "--out")
    else:
        write_columns(found.arrays(), path)


def _csv(found: Sweep) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    columns = found.arrays()
    writer.writerow([*(_header(found, name) for name in columns), REASON])
    rows = np.column_stack(list(columns.values())).tolist()
    writer.writerows([*row, reason] for row, reason in zip(rows, found.reasons, strict=True))
    return text.getvalue()


def _header(found: Sweep, name: str) -> str:
    return f"{name} [{found.units[name]}]" if name in found.units else name


def dataset(found: Sweep) -> Any:
    """Return an `xarray.Dataset` with units and, where points failed, their reasons; raises `InputError`."""
    design = found.design
    dims = design.names if design.is_grid else ("point",)
    shape = design.lengths or (-1,)
    if design.is_grid:
        coords: dict[str, Any] = {name: (name, design.along(k)) for k, name in enumerate(design.names)}
    else:
        coords = {name: ("point", found.points[:, k]) for k, name in enumerate(design.names)}
    figures: dict[str, Any] = {name: (dims, x.reshape(shape)) for name, x in found.figures.items()}
    if found.failed:
        figures[REASON] = (dims, np.array([x.encode("utf-8") for x in found.reasons]).reshape(shape))
    names = {name: name.replace("/", "over") for name in figures}
    made = _xarray().Dataset({names[name]: x for name, x in figures.items()}, coords, _attributes(found))
    for name in (*coords, *figures):
        if name in found.units:
            made[names.get(name, name)].attrs["units"] = found.units[name]
    return made


def _attributes(found: Sweep) -> dict[str, Any]:
    seed = {} if found.design.is_grid else {"seed": found.design.seed}
    return {"title": f"{found.of} of {found.machine}", "sampling": found.design.sampling, **seed}


def _xarray() -> Any:
    imported("scipy.io", "NetCDF", "sweep")
    return imported("xarray", "NetCDF", "sweep")
