"""Vibration tests are read as they were measured, and what is wrong with them is named in one line."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.vibration.export import save_response
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.measured.vibration_tests.reading import read_tests
from symoro_elastic.measured.vibration_tests.signal_names import split_pair
from symoro_elastic.quantities.unit_reader import conversion, is_unit
from tests.fuzz import DAMAGE
from tests.measured.vibration_tests.files import LIST, PAIR, F, H, cartesian, listed, machine, the_test, write_csv

G = 9.80665
POINT = "tool at (L12/2, 0, 0).ax/tool.fx"
COHERENCE = np.array([0.5, 0.9, 1.0, 0.99])


def test_a_test_is_what_its_entry_says(tmp_path: Path) -> None:
    more = """at = { motor_x = "300 mm", q9 = 0 }
hold = ["q5"]
pd = { motor_y = [1.5e7, "40 kN s/m"] }
averages = 10
validate = true
band = [12, "0.04 kHz"]
"""
    test = the_test(tmp_path, cartesian(), more)
    assert test.name == "m.csv" and test.at == {"motor_x": 0.3, "motor_y": 0.0}
    assert test.hold == ("motor_x",) and test.pd == {"motor_y": (1.5e7, 4e4)}
    assert test.averages == 10 and test.validate
    (found,) = test.responses
    assert (found.output, found.input, found.coherence) == ("tool.ax", "tool.fx", None)
    assert found.f.tolist() == [12.5, 20.0, 40.0] and found.H.tolist() == H[1:].tolist()


def test_all_motors_are_held_and_gains_may_be_unknown(tmp_path: Path) -> None:
    assert the_test(tmp_path, cartesian(), 'hold = ["all"]\n').hold == ("motor_x", "motor_y")
    assert the_test(tmp_path, cartesian(), 'pd = { motor_x = "unknown" }\n').pd == {"motor_x": None}


WAYS = {
    "as it is": (cartesian(), ""),
    "a point with a formula": (cartesian(POINT), ""),
    "spaces": ({key.replace("/", " / "): x for key, x in cartesian().items()}, ""),
    "kHz": ({"f [kHz]": F / 1e3} | dict([*cartesian().items()][1:]), ""),
    "rad/s": ({"f [rad/s]": F * 2 * np.pi} | dict([*cartesian().items()][1:]), ""),
    "g": (cartesian(unit=" [g/kN]"), G / 1e3),
    "brackets": (cartesian(unit=" [(mm/s^2)/N]"), 1e-3),
    "turned": (cartesian("-tool.ax/tool.fx"), -1),
    "turned twice": (cartesian("-tool.ax/-tool.fx"), 1),
    "amplitude": ({"f": F, f"mag {PAIR}": abs(H), f"phase {PAIR} [deg]": np.degrees(np.angle(H))}, ""),
    "decibels": ({"f": F, f"mag {PAIR} [dB]": 20 * np.log10(abs(H)), f"phase {PAIR} [rad]": np.angle(H)}, ""),
    "of a unit": ({"f": F, f"mag {PAIR} [dB re 1 g/N]": 20 * np.log10(abs(H)), f"phase {PAIR} [rad]": np.angle(H)}, G),
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("form", ["commas", "semicolons", "arrays"])
def test_every_way_to_write_a_response_is_read(way: str, form: str, tmp_path: Path) -> None:
    columns, factor = WAYS[way]
    if form == "arrays":
        np.savez(tmp_path / "m.npz", **columns)
        (test,) = listed(tmp_path, LIST.replace(".csv", ".npz")).tests
    else:
        test = the_test(tmp_path, columns, **({"delimiter": ";", "comma": True} if form == "semicolons" else {}))
    (found,) = test.responses
    assert np.allclose(found.f, F, rtol=1e-15, atol=0)
    assert np.allclose(found.H, (factor or 1) * H, rtol=1e-14, atol=1e-16)
    assert found.output == split_pair(POINT if way.startswith("a point") else PAIR)[0]


def test_names_of_a_file_are_renamed_with_sign_and_unit(tmp_path: Path) -> None:
    columns = cartesian("acc 1/hammer") | dict([*cartesian("acc 2 / hammer").items()][1:])
    rename = 'rename = { "acc 1 / hammer" = "-tool.ax/tool.fx [g/N]", "acc 2/hammer" = "tool.ay/tool.fx" }\n'
    first, second = the_test(tmp_path, columns, rename).responses
    assert np.array_equal(first.H, -G * H) and np.array_equal(second.H, H)
    assert (first.output, second.output) == ("tool.ax", "tool.ay")


def test_units_are_converted_and_dimensions_checked() -> None:
    factors = {
        ("m / N", "um/N"): 1e-6, ("m/s2 / N", "g/N"): G, ("m/s2 / N", "mg/kN"): G / 1e6, ("rad / (N m)", "deg/(N m)"):
        np.pi / 180, ("m/s2 / (N m)", "(g)/(N m)"): G, ("m / N", "m/kN"): 1e-3,
    }  # fmt: skip
    for (si, unit), factor in factors.items():
        assert conversion(unit, si).number == pytest.approx(factor, rel=1e-15)
    for si, unit in (("m / N", "g/N"), ("m/s2 / N", "m/N"), ("m / N", "m"), ("m / N", "EU/N"), ("m / N", "")):
        assert not is_unit(unit, si)


@pytest.mark.thorough
def test_what_response_writes_is_read_again_exactly(tmp_path: Path) -> None:
    for name in ("m.csv", "m.npz"):
        for options in (
            {"inputs": ["motor_x.tau", "tool.fx"], "outputs": ["tool at (0.1, 0, L12).ax", "motor_x.q", "tool.wdz"]},
            {"inputs": ["tool.mz"], "outputs": ["tool.vx", "tool.rz"], "hold": ["motor_y"], "damping": 0.02},
            {},
        ):
            written = se.response(machine(), band=(3, 500, 40), **options)
            (tmp_path / name).unlink(missing_ok=True)
            save_response(written, tmp_path / name)
            (test,) = listed(tmp_path, LIST.replace("m.csv", name)).tests
            assert len(test.responses) == len(written.outputs) * len(written.inputs)
            for found in test.responses:
                i, j = written.outputs.index(found.output), written.inputs.index(found.input)
                assert np.array_equal(found.f, written.frequencies)
                assert np.array_equal(found.H, written.values[:, i, j])


def test_lines_that_are_filled_are_left_out_and_said(tmp_path: Path) -> None:
    f = np.arange(1.0, 61.0)
    re = np.sin(f)
    re[20:40] = re[20]
    write_csv(tmp_path / "m.csv", {"f": f, f"re {PAIR}": re, f"im {PAIR}": np.where(re == re[20], 1.0, np.cos(f))})
    tests = listed(tmp_path)
    assert len(tests.tests[0].responses[0].f) == 41
    assert "m.csv: tool.ax / tool.fx: 19 of 60 lines, which repeat the one before, are left out" in tests.notes


def test_lines_without_a_number_are_left_out_and_said(tmp_path: Path) -> None:
    columns = {key: np.insert(x, 0, x[0]) for key, x in cartesian().items()} | {
        f"coherence {PAIR} [%]": np.append(100 * COHERENCE, 80.0)
    }
    columns["f [Hz]"] = np.insert(F, 0, 0.0)
    columns[f"im {PAIR}"][2] = np.nan
    write_csv(tmp_path / "m.csv", columns)
    tests = listed(tmp_path)
    (found,) = tests.tests[0].responses
    assert found.f.tolist() == [10.0, 20.0, 40.0] and found.coherence.tolist() == [0.9, 0.99, 0.8]
    assert tests.notes == (
        "m.csv: tool.ax / tool.fx: 1 of 5 lines, at 0 Hz, are left out",
        "m.csv: tool.ax / tool.fx: 1 of 5 lines, without a number, are left out",
        "m.csv: no averages: the noise is estimated from the residuals, so chi2 does not test the model",
    )


def test_modes_are_read(tmp_path: Path) -> None:
    columns = {
        "frequency [Hz]": [12.0, 30.0, 70.0],
        "damping_ratio [%]": [1.0, np.nan, 3.0],
        "std_frequency": [0.1, 0.1, 0.2],
        "-tool.ax": [1.0, 2.0, 3.0],
        "motor_x.q [mm]": [1.0, -1.0, 0.5],
    }
    modes = the_test(tmp_path, columns, "band = [10, 50]\n").modes
    assert modes.f.tolist() == [12, 30] and modes.std_f.tolist() == [0.1, 0.1] and modes.std_zeta is None
    assert modes.zeta[0] == 0.01 and np.isnan(modes.zeta[1])
    assert modes.outputs == ("tool.ax", "motor_x.q")
    assert modes.shapes.tolist() == [[-1, 1e-3], [-2, -1e-3]]


def with_f(x: list[float]) -> dict[str, object]:
    return {**cartesian(), "f [Hz]": x}


# What is wrong with the entry, with the columns; what the message says, its file, place and way out.
WRONG_ENTRIES: list[tuple[str, str]] = [
    ("at = { motr_x = 1 }", "tests.toml: test 1 (m.csv), at, motr_x: no joint 'motr_x'; did you mean 'motor_x'?"),
    ("at = { motor_x = 9 }", "test 1 (m.csv), at, motor_x: 9 m is outside its limits, "),
    ('at = { motor_x = "30 deg" }', "at, motor_x: '30 deg' is in rad, where m is needed"),
    ("at = { motor_x = 0, q5 = 0 }", "at, q5: motor_x is given twice"),
    ('hold = ["tool"]', "hold: no motor 'tool'"),
    ('hold = ["motor_x", "q5"]', "hold: a motor is given twice"),
    ("pd = { motor_x = [1] }", 'pd, motor_x: must be a list of 2 numbers, kp and kd, or "unknown"'),
    ("pd = { motor_x = [-1, 2] }", "pd, motor_x, kp: -1: a negative gain drives the motor away"),
    ('pd = { motor_x = ["3 N m/rad", 2] }', "pd, motor_x, kp: '3 N m/rad' is in N m/rad, where N/m is needed"),
    ('hold = ["all"]\npd = { motor_x = [1, 2] }', "pd, motor_x: motor_x is held, so its controller does nothing"),
    ("band = [30, 10]", "band: from 30 to 10 Hz: give 0 <= LOW < HIGH"),
    ('band = ["1 m", 10]', "band: '1 m' is in m, where Hz is needed"),
    ("band = [200, 300]", "re tool.ax/tool.fx: 0 lines with numbers between 200 and 300 Hz"),
    ("averages = 0", "averages: 0: a response has at least 1 average"),
    ("averages = 1.5", "averages: must be a whole number"),
    ("validate = 1", "validate: must be true or false"),
    ("held = []", "test 1 (m.csv), held: no such key here; did you mean 'hold'?"),
    ('rename = { "a/b" = "tool.ax/tool.fx" }', "rename, a/b: m.csv has no such name; it has 'tool.ax/tool.fx'"),
    ('rename = { "tool.ax/tool.fx" = "tool.ax/tool.fq" }', "rename, tool.ax/tool.fx: 'tool.fq' is not NAME.QUANTITY"),
    ('rename = { "tool.ax/tool.fx" = "tool.ax" }', "rename, tool.ax/tool.fx: 'tool.ax' is not OUT/IN"),
    ('rename = { "tool.ax/tool.fx" = "tool.ax/tool.fx [m/N]" }', "'m/N' cannot be converted to m/s2 / N"),
]
WRONG_COLUMNS: list[tuple[dict[str, object], str]] = [
    (with_f([10, 20, 20, 40]), "m.csv: re tool.ax/tool.fx: line 2, 20 Hz, is there twice: sort the lines"),
    (with_f([10, 30, 20, 40]), "line 2, 30 Hz, is followed by 20 Hz: sort the lines by frequency"),
    (with_f([10, np.nan, 20, 40]), "line 2 is nan, not a frequency"),
    (with_f([-10, 0, 20, 40]), "-10 Hz: frequencies are not negative, give one side of the spectrum"),
    (cartesian("tool.ax/motor_z.tau"), "re tool.ax/motor_z.tau: 'motor_z.tau': no moving joint 'motor_z'"),
    (cartesian("spindle.ax/tool.fx"), "'spindle.ax': no frame 'spindle'"),
    (cartesian("tool.ax"), "'tool.ax' is not OUT/IN with signals"),
    (cartesian(unit=" [m/N]"), "'m/N' cannot be converted to m/s2 / N: write the unit behind the name"),
    (cartesian() | {"coherence tool.ax/tool.fx": [0.5, 2, 1, 1]}, "2 is no coherence, which is 0 to 1: if in percent"),
    (cartesian() | {"mag tool.ax/tool.fx": F}, "give one pair of tool.ax/tool.fx: re and im, or mag and phase"),
    ({"f": F, f"re {PAIR}": F}, "re tool.ax/tool.fx: im tool.ax/tool.fx is missing"),
    ({"f": F, f"re {PAIR} [g/N]": F, f"im {PAIR}": F}, "im tool.ax/tool.fx: is in [SI], re tool.ax/tool.fx [g/N] is"),
    ({"f": F, f"mag {PAIR}": F, f"phase {PAIR}": F}, "say whether the phase is [deg] or [rad]"),
    ({"f": F, f"mag {PAIR}": F, f"phase {PAIR} [rad]": 170 + 0 * F}, "up to 170 rad: if these are degrees, write"),
    ({"f": F, f"mag {PAIR}": F, f"phase {PAIR} [deg]": 3.1 + 0 * F}, "up to 3.1 deg: if these are radians, write"),
    ({"f": F, f"mag {PAIR}": -F, f"phase {PAIR} [deg]": F}, "amplitudes are not negative: if these are decibels"),
    ({"f [1/s]": F, f"re {PAIR}": F, f"im {PAIR}": F}, "'1/s' may be radians or turns: write Hz or rad/s"),
    (cartesian() | {"real tool.ax/tool.fx": F}, "real tool.ax/tool.fx: is not a column of frequency responses"),
    (cartesian() | cartesian("-tool.ax/tool.fx"), "tool.ax / tool.fx is measured twice, by tool.ax/tool.fx too"),
    ({"f": F}, "responses: no response of the machine, there are none"),
    ({"x": F}, "columns: has neither f nor frequency nor t: responses begin with f [Hz]"),
    ({"frequency": [10.0, 5.0]}, "frequency: line 1, 10 Hz, is followed by 5 Hz"),
    ({"frequency": [0.0, 5.0]}, "0 Hz is not a vibration: remove rigid-body motion"),
    ({"frequency": [1.0, 5.0], "damping_ratio": [0.1, 2.0]}, "damping_ratio: mode 2 has 2: if in percent, write [%]"),
    ({"frequency": [1.0, 5.0], "std_frequency": [0.1, 0.0]}, "std_frequency: mode 2 has 0: give one above 0, or nan"),
    ({"frequency": [1.0, 5.0], "tool.ax": [0.1, np.nan]}, "tool.ax: mode 2 has no amplitude"),
    ({"frequency": [1.0, 5.0], "damping": [0.1, 0.1]}, "damping: 'damping' is not NAME.QUANTITY"),
]


@pytest.mark.parametrize(("entry", "said"), WRONG_ENTRIES, ids=[entry for entry, _ in WRONG_ENTRIES])
def test_a_wrong_entry_is_named(entry: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        the_test(tmp_path, cartesian(), entry + "\n")
    assert said in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(("columns", "said"), WRONG_COLUMNS, ids=[said[:30] for _, said in WRONG_COLUMNS])
def test_a_wrong_column_is_named(columns: dict[str, list[float]], said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        the_test(tmp_path, columns)
    assert said in str(error.value) and "\n" not in str(error.value) and str(tmp_path) in str(error.value)


def test_signals_of_motors_that_are_held_are_refused(tmp_path: Path) -> None:
    for pair in ("motor_x.q/tool.fx", "tool.ax/motor_x.tau"):
        with pytest.raises(InputError, match="is a signal of motor_x, which the test holds: correct the name, or hold"):
            the_test(tmp_path, cartesian(pair), 'hold = ["motor_x"]\n')


def test_files_that_are_none_are_named(tmp_path: Path) -> None:
    for text, said in (
        ("", "tests: holds no test"),
        ("[[tests]]\nat = {}\n", "test 1, file: is missing"),
        ('[[tests]]\nfile = ""\n', "test 1, file: is empty"),
        ("[[test]]\n", "test: no such key here; did you mean 'tests'?"),
        (LIST, "m.csv: file: no such file"),
        (LIST.replace("m.csv", "m.xlsx"), "m.xlsx: file name: motions and measurements are .csv or .npz files"),
        ("[scene]\n", "tests.toml: file: is a scene, not a list of vibration tests"),
    ):
        with pytest.raises(InputError) as error:
            listed(tmp_path, text)
        assert said in str(error.value), text


SOURCES = {
    ".toml": LIST + 'at = { motor_x = 0.1 }\nhold = ["motor_y"]\npd = { motor_x = [1e6, 1e3] }\nband = [5, 500]\n'
    'averages = 3\nrename = { "a/b" = "-tool.ax/tool.fx [g/N]" }\n',
    ".csv": "f [Hz],re a/b,im a/b,coherence a/b\n10,1,0.5,0.9\n20,2,-1,0.8\n40,0.1,0.2,1\n50,1,1,1\n",
}


def damaged(seed: int) -> dict[str, str]:
    """A list and its table, one of them damaged; the same for the same number."""
    rng = random.Random(seed)
    files, suffix = dict(SOURCES), rng.choice([*SOURCES])
    damage: list[Callable[[str, random.Random], str]] = [one for one in DAMAGE if one.__name__ != "_splice"]
    for _ in range(rng.choice((1, 1, 2, 5))):
        files[suffix] = rng.choice(damage)(files[suffix], rng)
    return files


def outcome(files: dict[str, str], folder: Path) -> str:
    """Whether damaged files are read or refused; other errors are raised."""
    for suffix, text in files.items():
        name = "tests.toml" if suffix == ".toml" else "m.csv"
        (folder / name).write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        tests = read_tests(folder / "tests.toml", machine())
    except InputError as error:
        assert str(error).startswith(str(folder)) and "\n" not in str(error) and len(str(error)) < 800, error
        return "refused"
    for response in tests.tests[0].responses:
        assert np.isfinite(response.H).all() and (np.diff(response.f) > 0).all() and response.f[0] > 0
    return "read"


@pytest.mark.thorough
def test_damaged_files_raise_the_readers_own_error_only(tmp_path: Path) -> None:
    found = Counter(outcome(damaged(seed), tmp_path) for seed in range(800))
    assert min(found.values()) > 50 and len(found) == 2
