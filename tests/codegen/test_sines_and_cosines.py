"""Sines and cosines of generated C against high precision: errors in units in the last place of the value itself."""

from __future__ import annotations

import ctypes
import subprocess
from functools import cache
from pathlib import Path

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from symoro_elastic.codegen.precision import DOUBLE, SINGLE
from symoro_elastic.codegen.targets.c import MOST_SIDE_BY_SIDE, MOST_STATEMENTS, lines_of_sines
from symoro_elastic.codegen.templates import render

pytestmark = pytest.mark.sampled(5)

LARGEST = {"double": 65536.0, "float": 1024.0}
DTYPE = {"double": np.float64, "float": np.float32}
PRECISION = {"double": DOUBLE, "float": SINGLE}
SIDE_BY_SIDE = 16
REORDERED = ("-O2", "-fassociative-math", "-fno-signed-zeros", "-fno-trapping-math")
EXACT = ("-O2", "-mfma"), ("-O3",), ("-O3", "-DLANES"), REORDERED
FLAGS = *EXACT, ("-O2", "-DTEST_LIBM"), ("-O2", "-DTEST_LIBM", "-DLANES")
NAMES = {"name": "test", "macro": "TEST", "has_angles": True, "called": {}, "functions": (), "has_rows": False}
SCALAR = """
void circles(size_t count, const %(kind)s *angle, %(kind)s *sine, %(kind)s *cosine)
{
    for (size_t k = 0; k < count; k++) {
        test_sincos(angle[k], &sine[k], &cosine[k]);
    }
    test_sincos_large(count, angle, sine, cosine);
}
"""
IN_LINES = """
void circles(size_t count, const %(kind)s *angle, %(kind)s *sine, %(kind)s *cosine)
{
    (void)count;
    %(lines)s
}
"""
VECTORS = """
void circles(size_t count, const %(kind)s *angle, %(kind)s *sine, %(kind)s *cosine)
{
    sincos_lanes(count/WIDTH, (const angles *)angle, (angles *)sine, (angles *)cosine);
}
"""


@cache
def library(kind: str, folder: Path, flags: tuple[str, ...], lines: str = "") -> ctypes.CDLL:
    """The sines and cosines of the templates, for one angle after another, in these lines or in vectors."""
    templates, call = (("sincos_declared", "sincos"), SCALAR) if "-DLANES" not in flags else (("vectors",), VECTORS)
    call = IN_LINES if lines else call
    head = "".join(f"#include <{name}.h>\n" for name in ("float", "math", "stddef", "stdint", "string"))
    text = "".join(render(f"c/{name}.c.j2", precision=PRECISION[kind], **NAMES) for name in templates)
    (folder / "circles.c").write_text(head + text + call % {"kind": kind, "lines": lines}, encoding="utf-8")
    subprocess.run(
        ["gcc", "-std=c99", "-Wno-psabi", "-shared", "-fPIC", *flags, "circles.c", "-o", "c.so", "-lm"],
        cwd=folder,
        check=True,
    )
    return ctypes.CDLL(str(folder / "c.so"))


def circles(
    kind: str, folder: Path, x: NDArray[np.floating], flags: tuple[str, ...], lines: str = ""
) -> tuple[NDArray[np.floating], ...]:
    count = -(-len(x) // SIDE_BY_SIDE) * SIDE_BY_SIDE
    given, sine, cosine = (aligned(count, DTYPE[kind]) for _ in range(3))
    given[:] = np.resize(x, count)
    made = library(kind, folder, flags, lines)
    made.circles.argtypes = [ctypes.c_size_t, *[ctypes.c_void_p] * 3]
    made.circles(count, *(array.ctypes.data for array in (given, sine, cosine)))
    return sine[: len(x)], cosine[: len(x)]


def aligned(size: int, dtype: type) -> NDArray[np.floating]:
    """Numbers at an address that suits any vector."""
    boundary = SIDE_BY_SIDE * np.dtype(dtype).itemsize
    room = np.zeros(size * np.dtype(dtype).itemsize + boundary, np.uint8)
    start = -room.ctypes.data % boundary
    return room[start : start + size * np.dtype(dtype).itemsize].view(dtype)


def angles(kind: str, count: int) -> NDArray[np.floating]:
    """Of every size, and as near to quarter turns as numbers of this type come."""
    draw = np.random.default_rng(1)
    size = LARGEST[kind] * 2.0 ** draw.uniform(-60, 0, count)
    turns = draw.integers(-int(LARGEST[kind] * 0.63), int(LARGEST[kind] * 0.63), count) * (np.pi / 2)
    found = np.concatenate([size * draw.choice((-1, 1), count), turns, np.nextafter(turns, np.inf), [0.0, -0.0]])
    return np.ascontiguousarray(found[np.abs(found) <= LARGEST[kind]].astype(DTYPE[kind]))


@pytest.mark.parametrize("flags", EXACT)
@pytest.mark.parametrize("kind", ["double", "float"])
def test_within_its_bound(kind: str, flags: tuple[str, ...], tmp_path: Path) -> None:
    x = angles(kind, 2000)
    found = circles(kind, tmp_path, x, flags)
    with mpmath.workdps(60):
        for function, values in zip((mpmath.sin, mpmath.cos), found, strict=True):
            exact = [function(mpmath.mpf(float(v))) for v in x]
            below = np.nextafter(DTYPE[kind](1), DTYPE[kind](0))
            unit = np.spacing(np.minimum(np.array([abs(float(v)) for v in exact], DTYPE[kind]), below))
            off = [
                abs(float((mpmath.mpf(float(v)) - e) / float(u))) for v, e, u in zip(values, exact, unit, strict=True)
            ]
            assert max(off) < 1.5


@pytest.mark.parametrize("flags", FLAGS)
@pytest.mark.parametrize("kind", ["double", "float"])
def test_outside_its_range_the_library_answers(kind: str, flags: tuple[str, ...], tmp_path: Path) -> None:
    x = np.array([LARGEST[kind] * 1.01, -1e15, 1e30, np.inf, np.nan, 0.3], DTYPE[kind])
    sine, cosine = circles(kind, tmp_path, x, flags)
    with np.errstate(invalid="ignore"):
        wanted = np.sin(x.astype(float)), np.cos(x.astype(float))
    unit = 2.0 ** (-52 if kind == "double" else -23)
    np.testing.assert_allclose(sine, wanted[0], rtol=0, atol=unit)
    np.testing.assert_allclose(cosine, wanted[1], rtol=0, atol=unit)


@pytest.mark.parametrize("kind", ["double", "float"])
def test_neighbours_do_not_change_an_angle(kind: str, tmp_path: Path) -> None:
    x = np.linspace(-3, 3, SIDE_BY_SIDE, dtype=DTYPE[kind])
    spoilt = x.copy()
    spoilt[3::5] = np.nan, np.inf, 1e30
    for alone, beside in zip(*(circles(kind, tmp_path, y, ("-O3", "-DLANES")) for y in (x, spoilt)), strict=True):
        np.testing.assert_array_equal(alone[np.isin(spoilt, x)], beside[np.isin(spoilt, x)])


@pytest.mark.parametrize(
    ("count", "statements"),
    [
        (1, 9),
        (MOST_SIDE_BY_SIDE, MOST_STATEMENTS),
        (MOST_SIDE_BY_SIDE + 1, 9),
        (MOST_SIDE_BY_SIDE, MOST_STATEMENTS + 1),
    ],
)
@pytest.mark.parametrize("kind", ["double", "float"])
def test_lines_of_few_and_of_many_angles(kind: str, count: int, statements: int, tmp_path: Path) -> None:
    """The last angle may be far, and the sum of all too large though none is."""
    lines = "\n    ".join(lines_of_sines("test", [f"angle[{k}]" for k in range(count)], statements))
    assert ("for (" in lines) == (count > MOST_SIDE_BY_SIDE or statements > MOST_STATEMENTS)
    near = np.full(count, 0.9 * LARGEST[kind], DTYPE[kind])
    for last in (0.3, 1e3 * LARGEST[kind], np.inf, np.nan):
        near[-1] = last
        found = circles(kind, tmp_path, near, ("-O2",), lines)
        with np.errstate(invalid="ignore"):
            for function, values in zip((np.sin, np.cos), found, strict=True):
                wanted = function(near.astype(float))
                np.testing.assert_allclose(values, wanted, rtol=0, atol=2.0 ** (-52 if kind == "double" else -23))
