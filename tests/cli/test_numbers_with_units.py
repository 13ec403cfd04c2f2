"""Numbers of options take units as files do, by the same reader: every option, every form, and Python."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic import cli
from symoro_elastic.api import kinds
from symoro_elastic.api.options import OperatingPoint
from symoro_elastic.cli.options import DeclaredOption
from tests.cli.test_typed_options import NEEDED
from tests.command_line import EXAMPLES, ended, run

MACHINE = EXAMPLES / "planar_2r.toml"
LOBES = ("lobes", "--direction", "s.x", "--cutting", "1e9")
BANDS = (kinds.BAND, kinds.BANDS, kinds.SPEEDS)
DRIVE = """
name = "drive"
joints = [
  { name = "x", kind = "motor", sigma = 1, r = "q1" }, { name = "s", kind = "elastic", sigma = 1, r = "dx" },
  { name = "y", kind = "motor", sigma = 0, theta = "q2" }, { name = "tool", kind = "fixed", sigma = 2, d = 0.1 },
]
gravity = [0, 0, 0]
[parameters]
k = { value = 1e7, unit = "N/m" }
n = 2
[bodies]
x = { mass = 30 }
s = { mass = 100 }
y = { mass = 10, inertia = [1, 1, 1] }
[springs]
s = { stiffness = "k", damping = "n*1000" }
"""


def numeric_options() -> Iterator[tuple[str, str, str]]:
    """Command, option and a value in a unit that nobody knows, of every option that holds numbers."""
    yield "generate", "--within", "2 furlong"
    for name, command in cli.cli.commands.items():
        for one in command.params if any(p.name == "machine" for p in command.params) else ():
            if isinstance(one, DeclaredOption) and (one.row.kind.has_numbers or one.row.kind in BANDS):
                first = "x=" if "=" in one.row.metavar and not one.row.metavar.startswith("[") else ""
                ends = ":".join(["2 furlong"] * (1 + one.row.metavar.count("HIGH") + one.row.metavar.count(":KD")))
                yield name, one.opts[0], first + ends + (":3" if "COUNT" in one.row.metavar else "")


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("command", "option", "value"), list(numeric_options()), ids=str)
def test_every_option_refuses_a_unit_that_is_not_known(
    command: str, option: str, value: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    needed = [*NEEDED.get(command, ()), *(("--radial", "6e8") if option == "--across" else ())]
    if option in needed:
        del needed[needed.index(option) : needed.index(option) + 2]
    found = ended(command, MACHINE, *needed, option, value)
    unknown, alone = "'furlong' is not a known unit", "give the number alone"
    assert found.code == 2 and option in found.err and (unknown in found.err or alone in found.err), found


@pytest.fixture
def drive(tmp_path: Path) -> Path:
    path = tmp_path / "drive.toml"
    path.write_text(DRIVE)
    return path


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    ("command", "written", "plain"),
    [
        (("modes", "--hold", "all"), ("--value", "k=8 N/um"), ("--value", "k=8e6")),
        (("modes", "--hold", "all"), ("--at", "y=30 deg"), ("--at", "y=pi/6")),
        (("modes",), ("--pd", "x=8 N/um:3 N s/mm"), ("--pd", "x=8e6:3e3")),
        (("modes",), ("--pd", "y=1 N m/arcmin:2 Nm/rpm"), ("--pd", "y=10800/pi:60/pi")),
        (("modes", "--hold", "all"), ("--along", "y=-30deg:30 deg:3"), ("--along", "y=-pi/6:pi/6:3")),
        (("response",), ("--frequency", "300 rpm", "--damping", "2 %"), ("--frequency", "5", "--damping", "0.02")),
        (("response",), ("--band", "60 1/min:0.2 kHz:5"), ("--band", "1:200:5")),
        (("lobes", "--direction", "s.x"), ("--cutting", "1319.4 MPa"), ("--cutting", "1319.4e6")),
        (LOBES, ("--speeds", "100 Hz:8000 rpm:3"), ("--speeds", "6000:8000:3")),
        (("sweep", "--hold", "all"), ("--over", "k=8 N/um:12 N/um:3"), ("--over", "k=8e6:12e6:3")),
        (("sweep", "--hold", "all"), ("--over", "q.y=-30deg,30deg"), ("--over", "q.y=-pi/6,pi/6")),
        (("sweep", "--hold", "all"), ("--over", "s.mass=90 kg,0.2 t"), ("--over", "s.mass=90,200")),
    ],
)  # fmt: skip
def test_a_number_with_a_unit_is_that_in_si_units(
    command: tuple[str, ...], written: tuple[str, ...], plain: tuple[str, ...], drive: Path
) -> None:
    name, *options = command
    found, expected = (json.loads(run(name, drive, *options, *given, "--json").output) for given in (written, plain))
    assert found == expected


@pytest.mark.parametrize(
    ("command", "written", "said"),
    [
        ("modes", ("--at", "y=30 mm"), "--at, y: '30 mm' is in m, where rad is needed"),
        ("modes", ("--at", "x=30 deg"), "--at, x: '30 deg' is in rad, where m is needed"),
        ("modes", ("--as-given", "--rate", "y=30 1/s"), "--rate, y: '1/s' may be radians or turns"),
        ("modes", ("--value", "n=3 kg"), "--value, n: '3 kg': give the number alone, in SI units"),
        ("modes", ("--value", "k=8 N"), "--value, k: '8 N' is in N, where N/m is needed"),
        ("response", ("--frequency", "5 1/s"), "'1/s' may be radians or turns: write Hz or rad/s"),
        ("sweep", ("--over", "k=8 N/um:9 um:3"), "--over, k: '9 um' is in m, where N/m is needed"),
        ("control", ("--modulus", "5 mm"), "--modulus: '5 mm': give the number alone"),
    ],
)
def test_a_unit_of_another_dimension_is_refused(command: str, written: tuple[str, ...], said: str, drive: Path) -> None:
    found = ended(command, drive, *written)
    assert found.code == 2 and said in found.err, found


def test_python_takes_texts_with_units(drive: Path) -> None:
    machine: Any = drive
    texts: dict[str, Any] = {"values": {"k": "8 N/um"}, "at": {"y": "30 deg"}}
    numbers: dict[str, Any] = {"values": {"k": 8e6}, "at": {"y": np.pi / 6}}
    found, expected = (se.modes(machine, hold=["all"], **given).frequencies for given in (texts, numbers))
    assert np.array_equal(found, expected)
    point: Any = OperatingPoint(at=texts["at"], hold=["all"])
    assert np.array_equal(se.modes(machine, point, values={"k": 8e6}).frequencies, expected)
    with pytest.raises(se.InputError, match="at, y: 'dge' is not a known unit"):
        se.modes(machine, at={"y": "30 dge"})  # type: ignore[dict-item]


def test_files_of_sweeps_take_units(drive: Path) -> None:
    plain, with_units = drive.with_name("a.toml"), drive.with_name("b.toml")
    plain.write_text('over = { k = [8e6, 9e6] }\nhold = ["all"]\nat = { y = 0.5 }\n')
    with_units.write_text('over = { k = "8 N/um,9 N/um" }\nhold = ["all"]\nat = { y = "500 mrad" }\n')
    found = [ended("sweep", drive, "--sweep", path, "--json") for path in (plain, with_units)]
    assert json.loads(found[0].out) == json.loads(found[1].out)
