"""Universal files that pyuff writes are read as the same responses in CSV, in all directions, spacings and types."""

from __future__ import annotations

import random
from collections import Counter
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.vibration_tests.measured import MeasuredResponse
from tests.measured.vibration_tests.files import LIST, listed, write_csv

pyuff = pytest.importorskip("pyuff")
N = 40
EVEN, UNEVEN = 10.0 + 2.5 * np.arange(N), np.round(np.geomspace(10, 900, N), 2)
OUTPUTS, INPUTS = ("", "ax", "ay", "az", "wdx", "wdy", "wdz"), ("", "fx", "fy", "fz", "mx", "my", "mz")
NAMES = ("", "X", "Y", "Z", "RX", "RY", "RZ")
UFF_LIST = LIST.replace(".csv", ".uff")


def numbers(seed: int, real: bool = False) -> np.ndarray:
    """A response of many sizes."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=N) * 10 ** rng.uniform(-8, 2, N)
    return x if real else x + 1j * rng.normal(size=N) * np.abs(x)


def function(f: np.ndarray, data: np.ndarray, out: int = 3, into: int = 3, **more: Any) -> dict[str, Any]:
    """A data set 58 from direction `into` of node 3 to `out` of node 12."""
    even = bool(np.ptp(np.diff(f)) < 1e-9)
    return {
        "type": 58, "func_type": 4, "rsp_node": 12, "rsp_dir": out, "ref_node": 3, "ref_dir": into, "data": data,
        "x": f, "abscissa_spacing": int(even), "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12,
        "orddenom_spec_data_type": 13, **more,
    }  # fmt: skip


def write(path: Path, *sets: dict[str, Any], single: bool = False) -> None:
    path.unlink(missing_ok=True)
    pyuff.UFF(str(path)).write_sets([*sets], mode="add", force_double=not single)


def renamed(**pairs: str) -> str:
    return UFF_LIST + "rename = { " + ", ".join(f'"{key}" = "{to}"' for key, to in pairs.items()) + " }\n"


def read(folder: Path, rename: dict[str, str], *sets: dict[str, Any], single: bool = False) -> list[MeasuredResponse]:
    write(folder / "m.uff", *sets, single=single)
    return [*listed(folder, renamed(**rename)).tests[0].responses]


@pytest.mark.thorough
@pytest.mark.parametrize("f", [EVEN, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize("real", [False, True], ids=["complex", "real"])
@pytest.mark.parametrize("form", ["text", "binary", "single"])
def test_every_form_is_equal_to_csv_in_every_direction(f: np.ndarray, real: bool, form: str, tmp_path: Path) -> None:
    """Of all forces and moments, both ways, to all accelerations, both ways."""
    more = {"binary": int(form == "binary")} | ({"ord_data_type": 2 if real else 5} if form == "single" else {})
    tolerance = 5e-6 if form == "single" else 1e-6
    for way_out, way_into in product((1, -1), repeat=2):
        sets, columns, rename = [], {"f": f}, {}
        for seed, (out, into) in enumerate(product(range(1, 7), repeat=2)):
            data = numbers(seed, real)
            sets.append(function(f, data, way_out * out, way_into * into, **more))
            name = f"tool.{OUTPUTS[out]}/tool.{INPUTS[into]}"
            rename[f"12:+{NAMES[out]}/3:{NAMES[into]}"] = name
            columns |= {f"re {name}": way_out * way_into * data.real, f"im {name}": way_out * way_into * data.imag}
        write_csv(tmp_path / "m.csv", columns)
        expected = {(x.output, x.input): x for x in listed(tmp_path).tests[0].responses}
        found = read(tmp_path, rename, *sets, single=form == "single")
        assert len(found) == len(expected) == 36
        for x in found:
            same = expected[x.output, x.input]
            assert np.allclose(x.f, same.f, rtol=tolerance, atol=0)
            assert np.allclose(x.H, same.H, rtol=tolerance, atol=0)


def test_negative_directions_and_signs_of_names_turn_a_response(tmp_path: Path) -> None:
    H = numbers(1)
    for out, key, name, sign in (
        (3, "12:+Z/3:+Z", "tool.az/tool.fz", 1),
        (-3, "12:+Z/3:+Z", "tool.az/tool.fz", -1),
        (-3, "12:-Z/3:+Z", "tool.az/tool.fz", 1),
        (3, "12:Z / 3:-Z", "-tool.az/tool.fz", 1),
        (3, "12:Z/3:Z", "tool.az/-tool.fz [mm/s2/N]", -1e-3),
    ):
        (found,) = read(tmp_path, {key: name}, function(EVEN, H, out))
        assert np.allclose(found.H, sign * H, rtol=1e-9, atol=0)


def test_coherence_goes_with_its_response(tmp_path: Path) -> None:
    coherence = np.linspace(0.2, 1, N)
    sets = function(EVEN, numbers(1)), function(EVEN, coherence, -3, func_type=6, ordinate_spec_data_type=0)
    (found,) = read(tmp_path, {"12:+Z/3:+Z": "tool.az/tool.fz"}, *sets)
    assert np.allclose(found.coherence, coherence, rtol=1e-9)


@pytest.mark.parametrize(
    ("more", "name", "factor"),
    [
        ({}, "tool.az/tool.fz", 1.0),
        ({"ordinate_axis_units_lab": "g", "orddenom_axis_units_lab": "N"}, "tool.az/tool.fz", 9.80665),
        ({"ordinate_axis_units_lab": "mm/s^2", "orddenom_axis_units_lab": "kN"}, "tool.az/tool.fz", 1e-6),
        ({"ordinate_axis_units_lab": "(m/s^2)/kN"}, "tool.az/tool.fz", 1e-3),
        ({"ordinate_spec_data_type": 8, "ordinate_axis_units_lab": "um"}, "tool.z/tool.fz", 1e-6),
        ({"ordinate_axis_units_lab": "EU", "orddenom_axis_units_lab": "EU"}, "tool.az/tool.fz [g/N]", 9.80665),
        ({"ordinate_spec_data_type": 11}, "tool.vz/tool.fz", 1.0),
        ({"ordinate_spec_data_type": 0, "orddenom_spec_data_type": 0}, "tool.z/tool.fz", 1.0),
        ({"rsp_dir": 5}, "tool.wdy/tool.fz", 1.0),
        ({"ref_dir": 6}, "tool.az/tool.mz", 1.0),
    ],
)
def test_units_of_labels_and_data_types_are_converted(
    more: dict[str, Any], name: str, factor: float, tmp_path: Path
) -> None:
    one = function(EVEN, numbers(1), **{k: x for k, x in more.items() if k != "rsp_dir"})
    one |= {key: more[key] for key in ("rsp_dir", "ref_dir") if key in more}
    key = f"12:{NAMES[one['rsp_dir']]}/3:{NAMES[one['ref_dir']]}"
    (found,) = read(tmp_path, {key: name}, one)
    assert np.allclose(found.H, factor * numbers(1), rtol=1e-9, atol=0)


def test_the_system_of_units_converts_what_has_no_label(tmp_path: Path) -> None:
    """Data set 164: factors by which numbers of the file are divided; mm and mN here."""
    units = {"type": 164, "units_code": 5, "length": 1e3, "force": 1e3, "temp": 1.0, "temp_offset": 273.15}
    for one, key, name, factor in (
        (function(EVEN, numbers(1)), "12:Z/3:Z", "tool.az/tool.fz", 1.0),
        (function(EVEN, numbers(1), 6), "12:RZ/3:Z", "tool.wdz/tool.fz", 1e3),
        (function(EVEN, numbers(1), 3, 6), "12:Z/3:RZ", "tool.az/tool.mz", 1e3),
        (function(EVEN, numbers(1), 3, 3, ordinate_axis_units_lab="m/s2"), "12:Z/3:Z", "tool.az/tool.fz", 1e3),
    ):
        (found,) = read(tmp_path, {key: name}, units, one)
        assert np.allclose(found.H, factor * numbers(1), rtol=1e-9, atol=0)


WRONG: list[tuple[dict[str, Any], str, str]] = [
    ({}, 'rename = { "12:+Z/4:+Z" = "tool.az/tool.fz" }', "rename, 12:+Z/4:+Z: m.uff has no such name; it has '12:"),
    ({}, "", "m.uff: responses: no response of the machine, there are '12:+Z/3:+Z': rename them"),
    ({}, 'rename = { "12:+Z/3:+Z" = "tool.z/tool.fz" }', "'m/s2 / N' cannot be converted to m / N"),
    ({"rsp_dir": 6}, 'rename = { "12:RZ/3:Z" = "tool.az/tool.fz" }', "'rad/s2 / N' cannot be converted to m/s2"),
    ({"ordinate_axis_units_lab": "EU"}, 'rename = { "12:Z/3:Z" = "tool.az/tool.fz" }', "'EU' is not a known unit:"),
    ({"abscissa_spec_data_type": 17}, "", "function 1: is not over frequency"),
    ({"abscissa_axis_units_lab": "s"}, "", "function 1: frequencies: 's' cannot be converted to Hz"),
    ({"data": np.abs(numbers(1))}, "", "function 1: holds amplitudes without phase: export complex numbers"),
    ({"func_type": 9}, "", "no frequency response and no mode; the file holds 1 power spectral density"),
    ({"func_type": 6, "data": 2 + 0 * EVEN}, "", "function 1: 2 is no coherence, which is 0 to 1"),
    ({"rsp_dir": 9}, "", "function 1: direction 9: there are -6 to 6"),
]


@pytest.mark.parametrize(("more", "rename", "said"), WRONG, ids=[said[:40] for _, _, said in WRONG])
def test_what_is_wrong_is_named(more: dict[str, Any], rename: str, said: str, tmp_path: Path) -> None:
    write(tmp_path / "m.uff", function(EVEN, numbers(1)) | more)
    with pytest.raises(InputError) as error:
        listed(tmp_path, UFF_LIST + rename + "\n")
    assert said in str(error.value) and str(tmp_path) in str(error.value)


def test_responses_that_are_there_twice_or_with_other_lines_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"function 2: 12:\+Z/3:\+Z is given twice: keep one"):
        read(tmp_path, {}, function(EVEN, numbers(1)), function(EVEN, numbers(2), -3))
    with pytest.raises(InputError, match=r"coherence of .* is at other frequencies"):
        coherence = function(UNEVEN, 0.9 + 0 * EVEN, func_type=6)
        read(tmp_path, {"12:Z/3:Z": "tool.az/tool.fz"}, function(EVEN, numbers(1)), coherence)


def test_what_is_not_renamed_is_skipped_and_said(tmp_path: Path) -> None:
    write(tmp_path / "m.uff", function(EVEN, numbers(1)), function(EVEN, numbers(2), 2))
    tests = listed(tmp_path, renamed(**{"12:Z/3:Z": "tool.az/tool.fz"}))
    assert len(tests.tests[0].responses) == 1
    assert tests.notes[0] == "m.uff: '12:+Y/3:+Z' are skipped: rename them to use them"


@pytest.mark.thorough
@pytest.mark.parametrize("binary", [0, 1])
def test_damaged_files_raise_the_readers_own_error_only(binary: int, tmp_path: Path) -> None:
    path = tmp_path / "m.uff"
    write(path, function(UNEVEN, numbers(1), binary=binary), function(UNEVEN, 0.5 + 0 * UNEVEN, func_type=6))
    whole, text = path.read_bytes(), renamed(**{"12:Z/3:Z": "tool.az/tool.fz"})
    found: Counter[str] = Counter()
    for seed in range(600):
        rng = random.Random(seed)
        content = bytearray(whole)
        for _ in range(rng.choice((1, 1, 3, 20))):
            k = rng.randrange(len(content))
            way = rng.randrange(4)
            if way == 0:
                content[k] = rng.randrange(256)
            elif way == 1:
                del content[k : k + rng.choice((1, 10, 500))]
            elif way == 2:
                content[k:k] = rng.choice((b"\n", b"    -1\n", b"nan", b"9" * 30, b" -1 58"))
            else:
                content[k : k + 1] = rng.choice((b" ", b"-", b"e", b"."))
        path.write_bytes(content)
        try:
            responses = listed(tmp_path, text).tests[0].responses
        except InputError as error:
            assert str(error).startswith(str(tmp_path)) and "\n" not in str(error) and len(str(error)) < 800, error
            found["refused"] += 1
            continue
        found["read"] += 1
        assert all(np.isfinite(one.H).all() and (np.diff(one.f) > 0).all() for one in responses)
    assert min(found.values()) > 20 and len(found) == 2


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("response", "force", "name", "factor"),
    [
        ("MM/S^2", "N", "tool.az/tool.fz", 1e-3), ("G", "LBF", "tool.az/tool.fz", 9.80665 / 4.4482216152605),
        ("in/s2", "lbf", "tool.az/tool.fz", 0.0254 / 4.4482216152605), ("m/sec^2", "Newton", "tool.az/tool.fz", 1.0),
        ("m/s\u00b2", "kN", "tool.az/tool.fz", 1e-3), ("\u00b5m", "N", "tool.z/tool.fz", 1e-6),
    ],
)  # fmt: skip
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
@pytest.mark.parametrize("hertz", ["HZ", "hz", "Hertz", "HERTZ"])
def test_labels_are_read_without_case(
    response: str, force: str, name: str, factor: float, encoding: str, hertz: str, tmp_path: Path
) -> None:
    more = {"ordinate_axis_units_lab": response, "orddenom_axis_units_lab": force, "abscissa_axis_units_lab": hertz}
    write(tmp_path / "m.uff", function(EVEN, numbers(1), **more))
    text = (tmp_path / "m.uff").read_text(encoding="utf-8")
    (tmp_path / "m.uff").write_text(text, encoding=encoding)
    (found,) = listed(tmp_path, renamed(**{"12:Z/3:Z": name})).tests[0].responses
    assert np.allclose(found.H, factor * numbers(1), rtol=1e-9, atol=0) and np.allclose(found.f, EVEN)


@pytest.mark.parametrize("f", [EVEN, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize("count", [N - 1, N - 2])
@pytest.mark.parametrize("single", [True, False])
def test_a_last_line_that_is_filled_with_zeros_is_cut(f: np.ndarray, count: int, single: bool, tmp_path: Path) -> None:
    data = numbers(1)[:count]
    write(tmp_path / "m.uff", function(f[:count], data, **({"ord_data_type": 5} if single else {})), single=single)
    lines = (tmp_path / "m.uff").read_text().splitlines()
    last = max(k for k, line in enumerate(lines[:-1]) if line.strip() != "-1")
    width = len(lines[last - 1].rstrip("\n"))
    number = "  0.00000e+00" if width % 13 == 0 else f"{0.0:20.11e}"
    lines[last] = lines[last].rstrip() + number * ((width - len(lines[last].rstrip())) // len(number))
    (tmp_path / "m.uff").write_text("\n".join(lines) + "\n")
    (found,) = listed(tmp_path, renamed(**{"12:Z/3:Z": "tool.az/tool.fz"})).tests[0].responses
    assert len(found.H) == count and np.allclose(found.H, data, rtol=1e-5)


def test_values_beyond_those_announced_are_refused(tmp_path: Path) -> None:
    write(tmp_path / "m.uff", function(EVEN, numbers(1)))
    text = (tmp_path / "m.uff").read_text()
    (tmp_path / "m.uff").write_text(text.replace(f"{N:10d}", f"{N - 1:10d}", 1))
    with pytest.raises(InputError, match=f"{N} values, {N - 1} are announced: the file is damaged"):
        listed(tmp_path, renamed(**{"12:Z/3:Z": "tool.az/tool.fz"}))


def mode(k: int, f: float, zeta: float, complex_: bool, nodes: tuple[int, ...] = (12, 3)) -> dict[str, Any]:
    """A data set 55: a normal or a complex mode of two nodes, whose shape is different in each direction."""
    shape = {f"r{n}": np.array([k + 0.1 * n, -k + 0.2 * n]) * (1 + 0.3j if complex_ else 1) for n in (1, 2, 3)}
    pole = 2 * np.pi * f * (-zeta + 1j * np.sqrt(1 - zeta**2))
    of = {"analysis_type": 3, "eig": pole, "modal_a": 1j, "modal_b": 1j} if complex_ else {
        "analysis_type": 2, "freq": f, "modal_m": 1.0, "modal_damp_vis": zeta, "modal_damp_his": 0.0}  # fmt: skip
    return {
        "type": 55, "model_type": 1, "id1": "", "id2": "", "id3": "", "id4": "", "id5": "", "data_ch": 2,
        "spec_data_type": 8, "data_type": 5 if complex_ else 2, "n_data_per_node": 3, "node_nums": list(nodes),
        "load_case": 1, "mode_n": k, **shape, **of,
    }  # fmt: skip


@pytest.mark.parametrize("complex_", [True, False])
def test_data_sets_55_are_modes(complex_: bool, tmp_path: Path) -> None:
    """In any order, by nodes and directions; what is not renamed is skipped and said."""
    write(tmp_path / "m.uff", mode(2, 80.0, 0.03, complex_), mode(1, 25.0, 0.01, complex_))
    tests = listed(tmp_path, renamed(**{"12:+Z": "tool.z", "3:-X": "tool.x [mm]"}))
    modes = tests.tests[0].modes
    assert modes is not None and modes.zeta is not None and modes.shapes is not None
    assert np.allclose(modes.f, [25, 80], rtol=1e-5) and np.allclose(modes.zeta, [0.01, 0.03], rtol=1e-4)
    assert set(modes.outputs) == {"tool.z", "tool.x"}
    by_name = dict(zip(modes.outputs, modes.shapes.T, strict=True))
    assert np.allclose(by_name["tool.z"] / by_name["tool.x"], [1.3 / 0.8e-3, 2.3 / 1.8e-3], rtol=1e-4)
    assert any("shapes at '12:+X'" in note for note in tests.notes)


def test_a_name_that_no_mode_has_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "m.uff", mode(1, 25.0, 0.01, False))
    with pytest.raises(InputError, match=r"rename, 9:\+Z: m.uff has no such name; it has .*'12:\+X'"):
        listed(tmp_path, renamed(**{"12:+Z": "tool.z", "9:+Z": "tool.x"}))


def test_a_file_without_responses_says_what_it_holds(tmp_path: Path) -> None:
    time = function(EVEN, numbers(1, real=True), func_type=1, abscissa_spec_data_type=17)
    write(tmp_path / "m.uff", time, time | {"rsp_dir": 1}, function(EVEN, np.abs(numbers(2)), func_type=2))
    with pytest.raises(InputError, match="the file holds 2 time records, 1 auto spectrum"):
        listed(tmp_path, renamed(**{"12:Z/3:Z": "tool.az/tool.fz"}))
