"""Every reader of units refuses one that nobody knows by the same message, and takes one of catalogues."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.time_series.measurements import from_columns, read_measurements
from symoro_elastic.formats import read_scene
from symoro_elastic.machine.checks import formulas, parameter_values
from tests.command_line import refused
from tests.measured.vibration_tests.files import LIST, PAIR, listed, write_csv

UNKNOWN, MESSAGE = "N m/arcmn", "'arcmn' in 'N m/arcmn' is not a known unit; did you mean 'arcmin'?"
MACHINE = """
name = "all_doors"
gravity = [0, "-9.81 m/s2", 0]
joints = [
  { name = "m", kind = "motor", sigma = 0, theta = "q1" }, { name = "e", kind = "elastic", sigma = 0, theta = "q2" },
  { name = "tool", kind = "fixed", sigma = 2, d = "100 mm" },
]
[parameters]
k = { value = 10, unit = "N m/arcmin" }
c = "0.2 N m/min-1"
[bodies]
m = { mass = "2 lb", center_of_mass = ["1 in", 0, 0], inertia = ["1 kgcm2", "1 kgcm2", "2 lb in2"] }
e = { mass = 1, inertia = [0.01, 0.01, 0.01] }
[springs]
e = { stiffness = "k", damping = "c", backlash = "3 arcmin" }
[motors]
m = { rotor_inertia = "50 gcm²", ratio = 100, resistance = "0.8 ohm" }
[friction]
m = { viscous = "2 oz-in/krpm", coulomb = "5 oz in" }
[limits]
m = { velocity = "3000 min-1", acceleration = "10 Hz/s", torque = "5 lb ft" }
[drives]
m = { Kv = "30 1/s", Kp = "1 Nm/(rev/s)", Tn = "10 ms", filters = [{ lowpass = "2500 rad/s" }] }
[base]
angular_velocity = [0, 0, "1 rpm"]
[motion]
duration = "1000 ms"
moves = [{ motor = "m", by = "45'", in = "0.1 s" }]
[wanted]
outputs = ["tool.x"]
tolerance = "10 µm"
"""
IN_SI = {
    '{ value = 10, unit = "N m/arcmin" }': '{ value = "10*10800/pi", unit = "N m/rad" }',
    '"0.2 N m/min-1"': '{ value = "6/pi", unit = "N m s/rad" }', '"-9.81 m/s2"': "-9.81", '"100 mm"': "0.1",
    '"2 lb"': "0.90718474", '"1 in"': "0.0254", '"1 kgcm2"': "1e-4", '"2 lb in2"': '"2*0.45359237*0.0254^2"',
    '"3 arcmin"': '"3*pi/10800"', '"50 gcm²"': "5e-6", '"0.8 ohm"': "0.8",
    '"5 oz in"': '"5*0.45359237*9.80665/16*0.0254"', '"5 lb ft"': '"5*0.45359237*9.80665*12*0.0254"',
    '"2 oz-in/krpm"': '"2*0.45359237*9.80665/16*0.0254*60/(2000*pi)"', '"3000 min-1"': '"100*pi"',
    '"10 Hz/s"': '"20*pi"', '"30 1/s"': "30", '"1 Nm/(rev/s)"': '"1/(2*pi)"', '"10 ms"': "0.01",
    '"2500 rad/s"': '"1250/pi"', '"1 rpm"': '"pi/30"', '"1000 ms"': "1", '"45\'"': '"pi/240"', '"0.1 s"': "0.1",
    '"10 µm"': "1e-5",
}  # fmt: skip


def read(folder: Path, text: str) -> Any:
    (folder / "m.toml").write_text(text, encoding="utf-8")
    return se.read(folder / "m.toml", warn=lambda _: None)


def numbers(machine: Any) -> list[float]:
    """All numbers that a file gave, in order."""
    values = parameter_values(machine)
    of_limits = [x for one in machine.limits.joints.values() for r in vars(one).values() if r for x in (r.low, r.high)]
    of_drives = [formula.value(values) for one in machine.drives.by_motor.values() for _, formula in one.formulas]
    asked = machine.asked
    of_scene = [asked.motions[0].duration, *vars(asked.motions[0].moves[0]).values(), asked.wanted.tolerance]
    cells = [formula.value(values) for _, formula in formulas(machine) if formula.names <= values.keys()]
    every = [*values.values(), *cells, *of_limits, *of_drives, *of_scene]
    return [float(x) for x in every if isinstance(x, float | int)]


def test_catalogue_units_stand_in_every_table(tmp_path: Path) -> None:
    """To the rounding of the formulas in which the values are written here."""
    plain = MACHINE
    for text, si in IN_SI.items():
        assert text in plain, text
        plain = plain.replace(text, si)
    found, expected = numbers(read(tmp_path, MACHINE)), numbers(read(tmp_path, plain))
    assert len(found) == len(expected) > 30 and np.allclose(found, expected, rtol=1e-14, atol=0)


TABLES = [text for text in IN_SI if "value" not in text]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("text", TABLES)
def test_every_table_refuses_a_unit_that_is_not_known(text: str, tmp_path: Path) -> None:
    with pytest.raises(se.InputError) as error:
        read(tmp_path, MACHINE.replace(text, f'"3 {UNKNOWN}"', 1))
    assert MESSAGE in str(error.value)


def as_table(folder: Path) -> None:
    read(folder, MACHINE.replace('"2 lb"', f'{{ value = 2, unit = "{UNKNOWN}" }}'))


def as_parameter(folder: Path) -> None:
    read(folder, MACHINE.replace("N m/arcmin", UNKNOWN))


def as_formula_of_a_parameter(folder: Path) -> None:
    read(folder, MACHINE.replace('value = 10, unit = "N m/arcmin"', f'value = "2*5", unit = "{UNKNOWN}"'))


def as_tolerance(folder: Path) -> None:
    read(folder, MACHINE.replace('value = 10, unit = "N m/arcmin"', f'value = 10, tolerance = "1 {UNKNOWN}"'))


def in_python(_: Path) -> None:
    se.read({"name": "u", "joints": [{"name": "a", "kind": "motor", "sigma": 0, "theta": "q1", "d": f"3 {UNKNOWN}"}]})


def in_par(folder: Path) -> None:
    text = (Path(__file__).parents[2] / "examples" / "four_bar.par").read_text(encoding="utf-8")
    (folder / "m.par").write_text(text.replace('unit = "m"', f'unit = "{UNKNOWN}"', 1), encoding="utf-8")
    se.read(folder / "m.par", warn=lambda _: None)


def in_old_par(folder: Path) -> None:
    text = (Path(__file__).parents[2] / "examples" / "rx90.par").read_text(encoding="utf-8")
    (folder / "m.par").write_text(f"{text}\n(*! units = {{D3 = {UNKNOWN}}} *)\n", encoding="utf-8")
    se.read(folder / "m.par", warn=lambda _: None)


def in_scene(folder: Path) -> None:
    machine = read(folder, MACHINE)
    (folder / "s.toml").write_text(f'locked = {{ m = "3 {UNKNOWN}" }}\n')
    read_scene(folder / "s.toml", machine)


def _log(heads: str, folder: Path, second: str = "") -> None:
    rows = "\n".join(f"{k},0,{k},{k}" for k in range(60))
    (folder / "log.csv").write_text(f"{heads}\n{second}{rows}\n")
    read_measurements(folder / "log.csv", read(folder, MACHINE))


def in_brackets_of_a_log(folder: Path) -> None:
    _log(f"t,q_m [{UNKNOWN}],q_e,tau_m", folder)


def in_round_brackets_of_a_log(folder: Path) -> None:
    _log(f"t,q_m,q_e ({UNKNOWN}),tau_m", folder)


def in_a_line_of_a_log(folder: Path) -> None:
    _log("t,q_m,q_e,tau_m", folder, f"s,rad,rad,{UNKNOWN}\n")


def in_columns_of_python(folder: Path) -> None:
    from_columns({f"t [{UNKNOWN}]": np.arange(9.0)}, read(folder, MACHINE), "data")


def in_a_response(folder: Path) -> None:
    parts = {f"{part} {PAIR} [{UNKNOWN}]": [1] * 3 for part in ("re", "im")}
    write_csv(folder / "m.csv", {"f": [1, 2, 3], **parts})
    listed(folder)


def in_frequencies(folder: Path) -> None:
    write_csv(folder / "m.csv", {f"f [{UNKNOWN}]": [1, 2, 3], f"re {PAIR}": [1] * 3, f"im {PAIR}": [1] * 3})
    listed(folder)


def in_modes(folder: Path) -> None:
    write_csv(folder / "m.csv", {"frequency": [1, 2], f"damping_ratio [{UNKNOWN}]": [0.1] * 2})
    listed(folder)


def in_a_ring_down(folder: Path) -> None:
    write_csv(folder / "m.csv", {f"t [{UNKNOWN}]": [1, 2], "tool.ax": [0.1] * 2})
    listed(folder)


def in_rename(folder: Path) -> None:
    write_csv(folder / "m.csv", {"f": [1, 2, 3], f"re {PAIR}": [1, 2, 3], f"im {PAIR}": [1] * 3})
    listed(folder, f'{LIST}rename = {{ "{PAIR}" = "{PAIR} [{UNKNOWN}]" }}\n')


def in_a_list_of_tests(folder: Path) -> None:
    listed(folder, f'{LIST}at = {{ motor_x = "3 {UNKNOWN}" }}\n')


def in_a_band(folder: Path) -> None:
    listed(folder, f'{LIST}band = ["3 {UNKNOWN}", "5 kHz"]\n')


def in_a_universal_file(folder: Path) -> None:
    pyuff = pytest.importorskip("pyuff")
    more = {
        "ordinate_axis_units_lab": UNKNOWN.split("/", maxsplit=1)[0],
        "orddenom_axis_units_lab": UNKNOWN.split("/")[1],
    }
    function = {
        "type": 58, "func_type": 4, "rsp_node": 1, "rsp_dir": 3, "ref_node": 1, "ref_dir": 3, "abscissa_spacing": 1,
        "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 13,
        "data": np.ones(9) + 1j * np.arange(9), "x": np.arange(9.0), **more,
    }  # fmt: skip
    pyuff.UFF(str(folder / "m.uff")).write_sets([function], mode="add")
    listed(folder, LIST.replace(".csv", ".uff") + 'rename = { "1:Z/1:Z" = "tool.az/tool.fz" }\n')


def on_the_command_line(folder: Path) -> None:
    read(folder, MACHINE)
    raise se.InputError("", "", refused("modes", folder / "m.toml", "--value", f"k=3 {UNKNOWN}"))


def in_a_sweep(folder: Path) -> None:
    read(folder, MACHINE)
    raise se.InputError("", "", refused("sweep", folder / "m.toml", "--over", f"k=3 {UNKNOWN},5"))


DOORS: tuple[Callable[[Path], None], ...] = (
    as_table, as_parameter, as_formula_of_a_parameter, as_tolerance, in_python, in_par, in_old_par, in_scene,
    in_brackets_of_a_log, in_round_brackets_of_a_log, in_a_line_of_a_log, in_columns_of_python, in_a_response,
    in_frequencies, in_modes, in_a_ring_down, in_rename, in_a_list_of_tests, in_a_band, in_a_universal_file,
    on_the_command_line, in_a_sweep,
)  # fmt: skip


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.__name__)
def test_every_door_refuses_a_unit_that_is_not_known_by_the_same_message(
    door: Callable[[Path], None], tmp_path: Path
) -> None:
    with pytest.raises(se.InputError) as error:
        door(tmp_path)
    said = str(error.value).replace("'N m / arcmn'", "'N m/arcmn'")
    assert MESSAGE in said and "\n" not in said
