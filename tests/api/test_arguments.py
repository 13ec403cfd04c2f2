"""Arguments that are no real numbers are refused by every backend with the same sentence."""

from __future__ import annotations

import datetime
from functools import cache
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.api.loaded import BACKENDS
from symoro_elastic.codegen.real_numbers import real_numbers
from tests.golden import ROOT

PLANAR = str(ROOT / "examples" / "planar_2r.toml")
NEEDS = {"casadi": "casadi", "jax": "jax"}
DAY = datetime.date(2026, 1, 1)
REFUSED: dict[str, tuple[Any, str]] = {
    "complex": (np.array([0.1, 0.2 + 1e-20j]), "complex ones"),
    "complex in a list": ([0.1, 0.2 + 0j], "complex ones"),
    "single complex": (np.zeros(2, "c8"), "complex ones"),
    "text": ("ab", "text"),
    "texts": (["0.1", "0.2"], "text"),
    "an array of text": (np.array(["0.1", "0.2"]), "text"),
    "bytes": (np.array([b"0.1", b"0.2"]), "text"),
    "text among numbers": ([0.1, "0.2"], "text"),
    "dates": (np.array(["2026-01-01", "2026-01-02"], "M8[D]"), "dates"),
    "spans": (np.array([1, 2], "m8[s]"), "dates"),
    "dates of Python": ([DAY, DAY], "dates"),
    "objects that are dates": (np.array([DAY, 0.1], dtype=object), "dates"),
    "a mask": (np.ma.array([0.1, 0.2], mask=[True, False]), "masked ones"),
    "a mask in a list": ([np.ma.array([0.1, 0.2], mask=[True, False])], "masked ones"),
    "nothing": ([None, 0.1], "None"),
}


class _Library:
    """An array library that is not numpy by its name."""

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)


@cache
def model(backend: str) -> Any:
    if backend in NEEDS:
        pytest.importorskip(NEEDS[backend])
    return se.load(PLANAR, "inverse_dynamics", backend=_Library() if backend == "array library" else backend)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("backend", [*BACKENDS, "array library"])
@pytest.mark.filterwarnings("ignore:JAX computes in single precision")
@pytest.mark.filterwarnings("error")
def test_every_backend_refuses_with_the_same_sentence(backend: str) -> None:
    call = model(backend).inverse_dynamics
    for name, (given, what) in REFUSED.items():
        for arguments in ((given, [0.0, 0.0]), ([0.0, 0.0], given)):
            with pytest.raises(TypeError) as said:
                call(*arguments, [0.0, 0.0])
            assert str(said.value) == f"arguments are real numbers, not {what}", name
        with pytest.raises(TypeError, match=f"^arguments are real numbers, not {what}$"):
            call([0.0, 0.0], [0.0, 0.0], [0.0, 0.0], p=given)


@pytest.mark.filterwarnings("ignore:JAX computes in single precision")
def test_arrays_of_jax_are_refused_too() -> None:
    numpy = pytest.importorskip("jax.numpy")
    with pytest.raises(TypeError, match="not complex ones"):
        model("jax").inverse_dynamics(numpy.array([1j, 0.0]), [0.0, 0.0], [0.0, 0.0])


@pytest.mark.sampled(5)
@pytest.mark.parametrize("backend", ["numpy", "c", "array library"])
def test_numbers_of_all_kinds_are_taken(backend: str) -> None:
    call = model(backend).inverse_dynamics
    expected = call([1.0, 2.0], [0.0, 0.0], [0.0, 0.0])
    unmasked = np.ma.array([1.0, 2.0], mask=[False, False])
    for q in ([1, 2], (1, np.int8(2)), np.array([1, 2], "i4"), unmasked, np.array([1.0, 2.0], "f8")[::1]):
        np.testing.assert_array_equal(call(q, [0, 0], [False, False]), expected)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("backend", [*BACKENDS, "array library"])
@pytest.mark.filterwarnings("ignore:JAX computes in single precision")
def test_too_many_arguments_are_counted(backend: str) -> None:
    zero = [0.0, 0.0]
    with pytest.raises(TypeError, match=r"too many positional arguments|takes .* positional arguments but"):
        model(backend).inverse_dynamics(zero, zero, zero, zero, zero)
    with pytest.raises(TypeError, match="missing"):
        model(backend).inverse_dynamics(zero) if backend != "sympy" else pytest.skip("symbols stand for the others")


def test_what_is_seen_of_numbers() -> None:
    assert real_numbers([[1, 2], [3, 4]]).shape == (2, 2)
    assert real_numbers(np.float32(1)).dtype == np.float32
