"""Files of numbers from strangers: bounded, never unpickled, refused in one line."""

from __future__ import annotations

import gc
import io
import pickle
import tempfile
import tracemalloc
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from symoro_elastic.analysis.time_series import reading
from symoro_elastic.analysis.time_series.reading import name_and_unit, place_of_sample, read_arrays
from symoro_elastic.foundation.errors import InputError

t = np.arange(60) / 10
FOREIGN = ("numpy.ndarray", "pickle", "allow_pickle", "Traceback", "zlib", "zipfile")


def line_of(path: Path) -> str:
    """Return the one line with which a file is refused."""
    with pytest.raises(InputError) as caught:
        read_arrays(path)
    line = str(caught.value)
    assert line.startswith(str(path)) and "\n" not in line and not any(word in line for word in FOREIGN), line
    return line


def npz(**arrays: object) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)  # type: ignore[arg-type]
    return stream.getvalue()


def claimed(shape: str, dtype: str = "<f8", content: bytes = b"12345678", version: bytes = b"\x01\x00") -> bytes:
    """Return an archive of one array `t` whose header claims a shape and a type."""
    header = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("t.npy", b"\x93NUMPY" + version + len(header).to_bytes(2, "little") + header + content)
    return stream.getvalue()


def array_alone() -> bytes:
    stream = io.BytesIO()
    np.save(stream, t)
    return stream.getvalue()


HOSTILE: dict[str, tuple[Callable[[], bytes], str]] = {
    "empty.npz": (lambda: b"", "is empty"),
    "empty.csv": (lambda: b"", "is empty"),
    "blank.csv": (lambda: b"\n\n \n", "holds no samples"),
    "alone.npz": (array_alone, "is a single array (.npy)"),
    "parcel.npz": (lambda: pickle.dumps([1, 2]), "cannot be read as arrays of numbers"),
    "objects.npz": (lambda: npz(t=np.array([None, {}])), "t: holds text or objects"),
    "text.npz": (lambda: npz(t=np.array(["a"])), "t: holds text or objects"),
    "complex.npz": (lambda: npz(t=t, q=t * 1j), "q: holds complex numbers"),
    "scalar.npz": (lambda: npz(t=3.0), "t: has shape ()"),
    "none.npz": (npz, "holds no array"),
    "huge.npz": (lambda: claimed("(1000000000000,)"), "1000000000000 samples"),
    "wide.npz": (lambda: claimed("(1000000, 1000000)"), "1000000000000 numbers"),
    "negative.npz": (lambda: claimed("(-5,)"), "has shape (-5,)"),
    "short.npz": (lambda: claimed("(2,)"), "t: holds fewer numbers than its shape (2,) says"),
    "long.npz": (lambda: claimed("(1,)", content=b"0" * 50), "t: holds more numbers"),
    "code.npz": (lambda: claimed("__import__('os').abort()"), "cannot be read as arrays of numbers"),
    "version.npz": (lambda: claimed("(1,)", version=b"\x07\x00"), "cannot be read as arrays of numbers"),
    "many.npz": (lambda: npz(**{f"a{k}": 1.0 for k in range(1001)}), "1001 arrays, 1000 is the limit"),
    "bars.csv": (lambda: b"t|q_a|tau_a\n0|1|2\n", "line 1: columns are separated by bars"),
    "mixed.csv": (lambda: b"t;q_a\n0,5;1\n1.5;2\n", "line 3: numbers with decimal commas and with decimal points"),
    "thousands.csv": (lambda: b"t;q_a\n0;1.234,5\n", "q_a: line 2: '1.234,5' is not a number"),
    "decimal_commas.csv": (lambda: b"t,q_a\n0,5,1,5\n", "line 2: has 4 cells, the header has 2"),
    "units_twice.csv": (lambda: b"t [ms],q_a\nms,rad\n0,1\n", "t [ms]: has its unit in line 2, too"),
    "binary.csv": (lambda: b"t,\xe9\x01\n0,1\n", "UTF-8"),
    "nul.csv": (lambda: b"t,q\n0,\x001\n", "q: line 2"),
    "endless.csv": (lambda: b"t," + b"a" * 300_000, "line 1: is longer than 100000 characters"),
    "wide.csv": (lambda: ",".join(f"a{k}" for k in range(1001)).encode(), "1001 columns, 1000 is the limit"),
    "underscore.csv": (lambda: b"t\n1_000\n", "'1_000' is not a number"),
    "arabic.csv": ("t\n\u0661\n".encode, "is not a number"),
    "complex.csv": (lambda: b"t\n1j\n", "'1j' is not a number"),
}


WRITTEN = {
    "semicolons and decimal commas": "t;q_a [deg];tau_a\n0;1,5;-2,25E-3\n,001;1e2;+3,\n",
    "semicolons and points": "t;q_a [deg];tau_a\n0;1.5;-2.25E-3\n.001;1e2;+3.\n",
    "tabs and decimal commas": "\n \nt\tq_a [deg]\ttau_a\n0\t1,5\t-2,25E-3\n\n0,001\t100\t3\n",
    "a line of units": "t,q_a,tau_a\ns,[deg],-\n0,1.5,-2.25e-3\n0.001,100,3\n",
    "numpy.savetxt": "# t,q_a [deg],tau_a\n0.0,1.5,-2.25e-03\n1.0e-03,1.0e+02,3.0\n",
    "Klipper": "#t,q_a [deg],tau_a\n0.0,1.5,-0.00225\n0.001,100.0,3.0\n",
    "comments": "% on a Monday\nt,q_a [deg],tau_a\n# as above\n0,1.5,-2.25e-3\n// a pause\n0.001,100,3\n",
    "spaces": "t q_a [deg] tau_a\n0.000  1.5  -2.25e-3\n0.001 100.0   3\n",
    "spaces and decimal commas": "t q_a [deg] tau_a\n0,000  1,5  -2,25e-3\n0,001 100,0   3\n",
    "preamble": "Name;Axis scope\nFile;c:\\scope.svdx\n\nt;q_a [deg];tau_a\n0;1,5;-2,25E-3\n0,001;100;3\n",
    "delimiter at the end": "t,q_a [deg],tau_a,\n0,1.5,-2.25e-3,\n0.001,100,3,\n",
    "delimiter at the end of rows": "t;q_a [deg];tau_a\n0;1.5;-2.25e-3;\n0.001;100;3;\n",
    "units behind a comment": "# t q_a tau_a\n# [s] [deg] [-]\n0 1.5 -2.25e-3\n0.001 100 3\n",
    "cut": "t,q_a [deg],tau_a\n0,1.5,-2.25e-3\n0.001,100,3\n0.002,10",
    "cut in a number": "t,q_a [deg],tau_a\n0,1.5,-2.25e-3\n0.001,100,3\n0.002,100,3.2e-",
    "quoted": '"t";"q_a [deg]";"tau_a"\n"0";"1,5";"-0,00225"\n"0,001";"100";"3"\n',
}


@pytest.mark.parametrize("written", WRITTEN)
def test_tables_of_other_spreadsheets_are_those_of_commas(written: str, tmp_path: Path) -> None:
    """As LibreOffice and Excel write them where the decimal sign is a comma."""
    head = "t [s],q_a [deg],tau_a" if "units" in written else "t,q_a [deg],tau_a"
    (tmp_path / "a.csv").write_text(f"{head}\n0,1.5,-2.25e-3\n0.001,100,3\n")
    expected = read_arrays(tmp_path / "a.csv")
    for encoding in ("utf-8-sig", "utf-8", "utf-16"):
        (tmp_path / "b.csv").write_text(WRITTEN[written], encoding=encoding)
        found = read_arrays(tmp_path / "b.csv")
        assert found.keys() == expected.keys() and all(np.array_equal(found[name], expected[name]) for name in expected)
        assert bool(found.notes) == ("cut" in written)
    lines = WRITTEN[written].split("\n")
    line = next(k for k, text in enumerate(lines, start=1) if "100" in text or "1e2" in text or "e+02" in text)
    assert place_of_sample(tmp_path / "b.csv", 1) == f"sample 2, line {line}"


@pytest.mark.parametrize(
    ("header", "name", "unit"),
    [
        ("q_a [deg]", "q_a", "deg"), ("q_a (deg)", "q_a", "deg"), ("q_a(deg)", "q_a", "deg"), ("q_a/deg", "q_a", "deg"),
        ("q_a [°]", "q_a", "°"), ("qd_a / (rad/s)", "qd_a", "(rad/s)"), ("qd_a/deg/s", "qd_a", "deg/s"),
        ("t [ns]", "t", "ns"),
        ("tau_a (N m)", "tau_a", "N m"), ("q_a", "q_a", None),
        ("re tool.ax/tool.fx [g/N]", "re tool.ax/tool.fx", "g/N"),
        ("re tool at (0.1, 0, L2).ax/tool.fx", "re tool at (0.1, 0, L2).ax/tool.fx", None), ("a/b", "a/b", None),
    ],
)  # fmt: skip
def test_units_stand_behind_names_in_three_ways(header: str, name: str, unit: str | None) -> None:
    assert name_and_unit(header) == (name, unit)


def test_degree_signs_of_windows_are_read(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes("t;q_a [°]\n0;1,5\n0,1;2\n".encode("cp1252"))
    assert [*read_arrays(tmp_path / "a.csv")] == ["t", "q_a [°]"]


@pytest.mark.thorough
def test_a_file_is_closed(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,q\n0,1\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error", ResourceWarning)
        read_arrays(tmp_path / "a.csv")
        place_of_sample(tmp_path / "a.csv", 0)
        (tmp_path / "a.csv").write_text("t,q\n0,x\n")
        with pytest.raises(InputError):
            read_arrays(tmp_path / "a.csv")
        gc.collect()


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused_in_one_line(name: str, tmp_path: Path) -> None:
    content, words = HOSTILE[name]
    (tmp_path / name).write_bytes(content())
    assert words in line_of(tmp_path / name)


def test_a_bomb_is_not_unpacked(tmp_path: Path) -> None:
    """13 arrays of 320 MB of zeros in 4 MB took 108 s and 4.2 GB: what is too much is not even read."""
    header = claimed("(40000000,)", "<f8", b"")
    with zipfile.ZipFile(io.BytesIO(header)) as archive:
        start = archive.read("t.npy")
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("t.npy", start + bytes(8_000_000))
    tracemalloc.start()
    assert "40000000 samples" in line_of(tmp_path / "bomb.npz")
    assert tracemalloc.get_traced_memory()[1] < 2_000_000
    tracemalloc.stop()


def test_the_numbers_of_all_arrays_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reading, "MOST_IN_FILES", 100)
    (tmp_path / "two.npz").write_bytes(npz(t=t, q=t))
    assert "120 numbers" in line_of(tmp_path / "two.npz")
    (tmp_path / "long.csv").write_text("t,q\n" + "0,1\n" * 60)
    assert "line 52: 51 samples, 102 numbers" in line_of(tmp_path / "long.csv")
    monkeypatch.setattr(reading, "MOST_BYTES", 50)
    assert "cut or thin out the record" in line_of(tmp_path / "long.csv")


def test_folders_and_devices_are_no_files(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    assert "is not a file" in line_of(tmp_path / "folder.csv")
    (tmp_path / "zero.csv").symlink_to("/dev/zero")
    assert "is not a file" in line_of(tmp_path / "zero.csv")


EDITS = st.lists(st.tuples(st.integers(0, 2), st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=6)
TABLE = "t,q_a,tau_a [N m]\n" + "".join(f"{x},{x**2},{-x}\n" for x in t)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("name", "whole"), [("x.csv", TABLE.encode()), ("x.npz", npz(t=t, q=np.stack([t, t], axis=1)))]
)
@settings(max_examples=200, deadline=None)
@given(edits=EDITS)
@example(edits=[(1, 0, 141)])
def test_damaged_files_are_read_or_refused(name: str, whole: bytes, edits: list[tuple[int, int, int]]) -> None:
    """Bytes changed, cut out, doubled: numbers, or one line, and nothing else."""
    content = bytearray(whole)
    for kind, place, value in edits:
        where = place % (len(content) or 1)
        if kind == 0:
            content[where : where + 1] = bytes([value])
        elif kind == 1:
            del content[where : where + value % 40]
        else:
            content[where:where] = content[where : where + value % 40]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        try:
            found = read_arrays(path)
        except InputError as error:
            file, _, line = str(error).partition(name)  # the random name of the folder may hold any word
            assert file.startswith(folder) and not any(word in line for word in FOREIGN), line
        else:
            assert all(array.dtype == float for array in found.values())
