"""`excite` and `identify` with real logs: gains, spans of time, sampling, validation, the machine that is saved."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("scipy")

from symoro_elastic.formats import read_machine, write_machine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Friction, Machine
from symoro_elastic.measured.logs.fourier_motion import Limits, random_motion
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.command_line import EXAMPLES, refused, run

Array = NDArray[np.float64]
LIMITS = Limits.of([-1.5, -1.5], [1.5, 1.5], [3, 4], [15, 25])
HEADER = "t,q_shoulder,q_elbow,tau_shoulder,tau_elbow"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the planar arm with friction, and two records of it: torques with noise, encoders of 16 bits."""
    where = tmp_path_factory.mktemp("arm")
    machine, _ = read_machine(EXAMPLES / "planar_2r.toml")
    friction = Friction(Formula.parse(0.3), Formula.parse(0.2))
    joints = tuple(replace(j, friction=friction) if j.sigma != 2 else j for j in machine.joints)
    write_machine(replace(machine, joints=joints), where / "arm.toml")
    for seed in (1, 2):
        np.savetxt(where / f"{seed}.csv", record(where / "arm.toml", seed), delimiter=",", header=HEADER, comments="")
    return where


def record(path: Path, seed: int, sampling: float = 500.0) -> Array:
    """Return t, q, tau of 15 s."""
    machine, _ = read_machine(path)
    t, rng = np.arange(int(15 * sampling)) / sampling, np.random.default_rng(seed)
    q, qd, qdd = random_motion(LIMITS, 0.25, 4, seed).at(t)
    tau = torques(machine, q, qd, qdd) + 0.02 * rng.standard_normal(q.shape)
    step = 2 * np.pi / 2**16
    return np.column_stack([t, step * np.round(q / step + 0.5 * rng.standard_normal(q.shape)), tau])


def torques(machine: Machine, q: Array, qd: Array, qdd: Array) -> Array:
    found: Array = np.asarray(numpy_model(machine, ("inverse_dynamics",)).inverse_dynamics(q, qd, qdd)[0])
    return found


def identified(folder: Path, *arguments: object) -> Any:
    return json.loads(run("identify", folder / "arm.toml", *arguments, "--json").stdout)


@pytest.mark.thorough
def test_residuals_and_validation(folder: Path) -> None:
    """In per cent of each motor's torque: the noise that is left of 0.02 N m, in both records."""
    found = identified(folder, folder / "1.csv", "--validate", folder / "2.csv")
    assert found["validation"]["source"].endswith("2.csv")
    for percent in (found["residual_percent"], found["validation"]["residual_percent"]):
        assert set(percent) == {"shoulder", "elbow"} and all(0.001 < x < 0.5 for x in percent.values())
    text = run("identify", folder / "arm.toml", folder / "1.csv", "--validate", folder / "2.csv").stdout
    assert "residuals: shoulder: " in text and "2.csv: elbow: " in text and "% of the torque" in text
    wrong = np.loadtxt(folder / "2.csv", delimiter=",", skiprows=1) * [1, 1, 1, 2, 1]
    np.savetxt(folder / "wrong.csv", wrong, delimiter=",", header=HEADER, comments="")
    seen = identified(folder, folder / "1.csv", "--validate", folder / "wrong.csv")["validation"]["residual_percent"]
    assert seen["shoulder"] == pytest.approx(50, rel=0.05) and seen["elbow"] < 0.5


@pytest.mark.thorough
def test_the_values_of_the_file_stand_beside_the_estimates(folder: Path) -> None:
    found = identified(folder, folder / "1.csv")["estimates"]
    assert found["FV1"]["file"] == 0.3
    heads = run("identify", folder / "arm.toml", folder / "1.csv").stdout.splitlines()[0].split()
    assert heads[:3] == ["parameter", "file", "estimated"]


@pytest.mark.sampled(2)
@pytest.mark.parametrize("suffix", [".toml", ".par"])
def test_the_saved_machine_has_the_torques_of_the_measured_one(folder: Path, tmp_path: Path, suffix: str) -> None:
    saved = tmp_path / f"identified{suffix}"
    assert identified(folder, folder / "1.csv", "--save", saved)["written"] == str(saved)
    states = np.random.default_rng(5).uniform(-1, 1, (3, 50, 2)) * [[[1.5]], [[3.0]], [[10.0]]]
    true, found = (torques(read_machine(path)[0], *states) for path in (folder / "arm.toml", saved))
    assert abs(found - true).max() < 0.005 * abs(true).max()
    assert "exists" in refused("identify", folder / "arm.toml", folder / "1.csv", "--save", saved)
    assert "suffix" in refused("identify", folder / "arm.toml", folder / "1.csv", "--save", tmp_path / "x.txt")


@pytest.mark.thorough
def test_what_is_saved_instead_of_negative_values_is_said(folder: Path, tmp_path: Path) -> None:
    wrong = np.loadtxt(folder / "1.csv", delimiter=",", skiprows=1)
    wrong[:, 3] -= 1.5 * np.gradient(wrong[:, 1], wrong[1, 0])
    np.savetxt(tmp_path / "wrong.csv", wrong, delimiter=",", header=HEADER, comments="")
    done = run("identify", folder / "arm.toml", tmp_path / "wrong.csv", "--save", tmp_path / "saved.toml", "--json")
    assert json.loads(done.stdout)["estimates"]["FV1"]["value"] < -1
    assert (
        "warning: FV1 = -1." in done.stderr
        and "is saved as 0, because it is physically impossible; the others are" in done.stderr
    )
    assert read_machine(tmp_path / "saved.toml")[0].joints[0].friction.viscous.is_zero


@pytest.mark.thorough
def test_gains_turn_currents_into_torques(folder: Path, tmp_path: Path) -> None:
    currents = np.loadtxt(folder / "1.csv", delimiter=",", skiprows=1) / [1, 1, 1, 2.5, -0.4]
    np.savetxt(tmp_path / "currents.csv", currents, delimiter=",", header=HEADER, comments="")
    wanted = identified(folder, folder / "1.csv")["estimates"]
    found = identified(folder, tmp_path / "currents.csv", "--gain", "shoulder=2.5", "--gain", "elbow=-0.4")
    for label, x in found["estimates"].items():
        assert x["value"] == pytest.approx(wanted[label]["value"], rel=1e-9)
    assert "no motor 'elbo'; did you mean 'elbow'" in refused(
        "identify", folder / "arm.toml", folder / "1.csv", "--gain", "elbo=2"
    )
    assert "torque per unit of the column" in refused(
        "identify", folder / "arm.toml", folder / "1.csv", "--gain", "elbow=0"
    )


def test_columns_of_other_names_and_units_are_named(folder: Path, tmp_path: Path) -> None:
    """Degrees in their heads, counts by a factor, N cm as units of torques; who asks for none hears what there is."""
    wanted = identified(folder, folder / "1.csv")["estimates"]
    foreign = np.loadtxt(folder / "1.csv", delimiter=",", skiprows=1)
    foreign *= [1e3, 180 / np.pi, 4096 / (2 * np.pi), 100, 1]
    head = "Zeit [ms];Position 1 (deg);Counts_2;tau_shoulder [N cm];Drehmoment 2"
    np.savetxt(tmp_path / "foreign.csv", foreign, delimiter=";", header=head, comments="")
    names = ("t=Zeit", "q_shoulder=Position 1", "q_elbow=2*pi/4096*Counts_2", "tau_elbow=Drehmoment 2 [N m]")
    options = [x for name in names for x in ("--column", name)]
    found = identified(folder, tmp_path / "foreign.csv", *options)["estimates"]
    for label, x in found.items():
        assert x["value"] == pytest.approx(wanted[label]["value"], rel=1e-6)
    said = refused("identify", folder / "arm.toml", tmp_path / "foreign.csv", *options[:-2])
    assert "tau_elbow" in said and "Drehmoment 2" in said
    said = refused("identify", folder / "arm.toml", tmp_path / "foreign.csv", "--column", "t=Drehmoment")
    assert "Drehmoment: missing; the file has Zeit [ms]" in said


def test_logs_are_cut_and_sampled_evenly(folder: Path, tmp_path: Path) -> None:
    """A log with an uneven clock, lines left out, and nonsense before and after the motion."""
    log = record(folder / "arm.toml", 3, 1000.0)
    rng = np.random.default_rng(0)
    log = log[np.sort(rng.choice(len(log), int(0.97 * len(log)), replace=False))]
    log[[0, 1, -1], 1:] = np.nan
    np.savetxt(tmp_path / "log.csv", log, delimiter=",", header=HEADER, comments="")
    cut = ("--after", 0.1, "--before", 14.9)
    for options in ((), cut, (*cut, "--resample", 250)):
        found = identified(folder, tmp_path / "log.csv", *options)
        for label, x in found["estimates"].items():
            assert abs(x["value"] - (x["file"] or 0.0)) < 5 * x["std"], (options, label)
        assert any("NaN or infinity at 3 of" in note for note in found["notes"]) == (not options)
    faster = identified(folder, folder / "1.csv", "--resample", 2000)["notes"]
    assert any("faster than the 500 Hz" in note for note in faster)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--after", 3, "--before", 2), "--before: 2 s is not later than --after 3 s"),
        (("--after", 100), "leave nothing of it"),
        (("--resample", 0), "give a positive frequency"),
        (("--resample", 1e9), "5e+06 is the limit"),
        (("--after", 14), "measure longer"),
    ],
)
def test_spans_and_frequencies_without_sense(folder: Path, options: tuple[object, ...], message: str) -> None:
    assert message in refused("identify", folder / "arm.toml", folder / "1.csv", *options)


@pytest.mark.thorough
def test_zeros_of_the_table_that_are_sought_are_named(folder: Path, tmp_path: Path) -> None:
    """The generated regressor has no columns for them: used together they would be one column beside."""
    text = (EXAMPLES / "planar_2r.toml").read_text(encoding="utf-8").split("[bodies]")[0]
    bodies = [
        "shoulder = { first_moments = [1, 0, 0] }",
        "elbow = { first_moments = [0.2, 0, 0], inertia_at_origin = [0, 0, 0, 0, 0, 0.05] }",
    ]
    (tmp_path / "zeros.toml").write_text("\n".join([text, "[bodies]", *bodies]), encoding="utf-8")
    notes = json.loads(run("identify", tmp_path / "zeros.toml", folder / "1.csv", "--json").stdout)["notes"]
    note = next(note for note in notes if note.startswith("also estimated: "))
    assert "MY2" in note and "MX2" not in note.split(";")[0] and "generated regressor has no columns" in note


def test_machines_without_motors_are_not_excited(tmp_path: Path) -> None:
    text = (EXAMPLES / "planar_2r.toml").read_text(encoding="utf-8").replace('kind = "motor"', 'kind = "passive"')
    text = text.partition("[limits]")[0]
    (tmp_path / "passive.toml").write_text(text, encoding="utf-8")
    limits = ("--position", "-1:1", "--velocity", 1, "--acceleration", 5)
    line = refused("excite", tmp_path / "passive.toml", "--out", tmp_path / "e.csv", *limits)
    assert "no joint has a motor" in line


def test_an_empty_archive_is_an_error_not_an_interrupt(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "e.npz").write_bytes(b"")
    assert "e.npz: file: is empty" in refused("identify", folder / "arm.toml", tmp_path / "e.npz")


def test_excite_says_why_friction_is_sought(tmp_path: Path) -> None:
    limits = ("--position", "-1:1", "--velocity", 1, "--acceleration", 5, "--evaluations", 5, "--sample-rate", 200)
    said = run("excite", EXAMPLES / "planar_2r.toml", "--out", tmp_path / "e.csv", *limits).stdout
    assert "friction (FV viscous, FS dry) is estimated for every motor" in said
