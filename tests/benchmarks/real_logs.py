"""Public logs of robots, identified by halves: `python -m tests.benchmarks.real_logs FOLDER [--only NAME ...]`.

FOLDER holds clones of github.com/marcocognetti/FrankaEmikaPandaDynModel (GPL-3; Gaz, Cognetti, Oliva, Robuffo Giordano,
De Luca 2019), shamilmamedov/dynamic_calibration (no licence; a UR10e, with drive gains of De Luca) and
thanhndv212/figaroh-examples (Apache-2.0; TX40 and TIAGo), in folders that end with these names. Nothing of them is kept
here. A row for each log: errors of unseen torques, mean of the joints in per cent, by least squares, by possible bodies
(`--possible`) and with the file's bodies (`--trust 0.3`), by other options, and whether all bodies of the file that is
saved are possible when it is read again; the same from records of 1.5 s. Errors are of every sample, in the band of the
motion, and of samples at which the joint moves: at rest dry friction is any value between -FS and FS, so that what a
model says there is chance. 59 % of the unseen part of the TX40's log are rest.
"""

from __future__ import annotations

import argparse
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

import symoro_elastic as se
from symoro_elastic.analysis.time_series.measurements import Measurements, measurements_of
from symoro_elastic.analysis.time_series.preparation import Preparation
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Kind, Machine
from symoro_elastic.measured.logs.identified import Identified
from symoro_elastic.measured.logs.pseudo_inertia import pseudo_inertia
from symoro_elastic.measured.logs.validation import Fit, validation_of
from symoro_elastic.mechanics.regressor import INERTIAL
from symoro_elastic.numerics.linear.regressor import nominal_body
from tests.benchmarks.tables import print_table

PANDA, UR10E, FIGAROH = "FrankaEmikaPandaDynModel", "dynamic_calibration", "figaroh-examples"
SHORT, WINDOWS = 1.5, 4
"""Length of short records, s, and how many are taken of a log, from its beginning to its end."""
GAINS = (14.87, 13.26, 11.13, 10.62, 11.03, 11.47)
"""Of the UR10e's currents, N m/A (De Luca)."""
TX40_RATIOS, TX40_RATE = (32.0, 32.0, 45.0, -48.0, 45.0, 32.0), 5000.0
TIAGO_GAINS = (60.0, 13.6, 13.6, -8.7, -8.7)
TIAGO_WRIST = (-20.6, -20.6, -20.6)
"""Of currents of TIAGo's torso, of joints 1 to 4, and of the wrist, N m/A: gear ratio times torque constant, signs,
as in figaroh; of the torso, which figaroh leaves without, a guess."""
TIAGO_MOVES, TIAGO_PARTS = (921, 6791), 21.0
"""Samples at which TIAGo moves (figaroh's); how long the unseen part at the end of them is, s."""
OTHERS: dict[str, dict[str, Any]] = {"offsets never": {"offsets": "never"}, "delay never": {"delay": "never"}}
Columns = dict[str, Array]


@dataclass(frozen=True)
class Log:
    """A machine, columns of what is fitted and of what is not seen, joints that count, options that go with the log."""

    machine: Machine
    seen: Columns
    unseen: Columns
    joints: Sequence[str]
    options: Mapping[str, Any] = field(default_factory=dict)
    others: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def folder_of(root: Path, name: str) -> Path:
    """The clone of a repository; raises `FileNotFoundError` that names it."""
    found = [path for path in sorted(root.iterdir()) if path.name.endswith(name)]
    if not found:
        raise FileNotFoundError(f"{name}: no folder of {root} ends so: clone it")
    return found[0]


def numbers(path: Path, **options: Any) -> Array:
    """The numbers of a text file; raises `FileNotFoundError` where it is missing, or is a pointer to a large file."""
    if not path.is_file() or path.stat().st_size < 1000:
        raise FileNotFoundError(f"{path.parent.name}/{path.name} is missing")
    return np.loadtxt(path, **options)


def part(columns: Columns, after: float, before: float) -> Columns:
    """The columns between two times after the first."""
    t = columns["t"] - columns["t"][0]
    return {name: x[(t >= after) & (t <= before)] for name, x in columns.items()}


def columns_of(t: Array, q: Array, tau: Array, names: Sequence[str], qd: Array | None = None) -> Columns:
    """Columns of a log by their headers."""
    found = {"t": t}
    for block, x in (("q", q), ("tau", tau), ("qd", qd)):
        found |= {f"{block}_{name}": x[:, k] for k, name in enumerate(names)} if x is not None else {}
    return found


def panda_table() -> dict[str, Any]:
    """The Panda by its published geometry, with bodies that are a rough guess: its file has none."""
    rows = ((0, 0, 0.333), ("-pi/2", 0, 0), ("pi/2", 0, 0.316), ("pi/2", 0.0825, 0), ("-pi/2", -0.0825, 0.384),
            ("pi/2", 0, 0), ("pi/2", 0.088, 0))  # fmt: skip
    joints = [
        {
            "name": f"j{k}",
            "antecedent": f"j{k - 1}" if k > 1 else 0,
            "kind": "motor",
            "sigma": 0,
            "theta": f"q{k}",
            "alpha": a,
            "d": d,
            "r": r,
        }
        for k, (a, d, r) in enumerate(rows, start=1)
    ]
    guess = {f"j{k}": {"mass": m, "inertia": [0.01 * m] * 3} for k, m in enumerate((4, 4, 3, 3, 2, 2, 1), start=1)}
    return {"name": "panda", "gravity": [0, 0, -9.81], "joints": joints, "bodies": guess}


def panda(root: Path) -> Log:
    """15 s of a motion, and the 5 s after; torques show no rotors. The clock of the log is too rough for a spectrum."""
    logs = folder_of(root, PANDA) / "matlab/data/Exciting_Traj/Trajectory_1/rbt_log"
    t = numbers(logs / "exciting_traj_time.txt")
    q, tau = (numbers(logs / f"exciting_traj_{name}.txt").reshape(-1, 7) for name in ("positions", "torques"))
    new = np.concatenate([[True], np.diff(t) > 0])
    names = [f"j{k}" for k in range(1, 8)]
    even = np.arange(t[0], t[-1], 1e-3)
    both = [np.stack([np.interp(even, t[new], x) for x in block[new].T], axis=1) for block in (q, tau)]
    whole = columns_of(even, both[0], both[1], names)
    options = {"known": {f"IA{k}": 0.0 for k in range(1, 8)}, "bandwidth": 2.0}
    others = OTHERS | {"with rotors": {"known": {}}, "stribeck": {"stribeck": dict.fromkeys(names, 0.1)}}
    return Log(se.read(panda_table()), part(whole, 0, 15), part(whole, 15, 20), names, options, others)


def ur10e(root: Path, seen: tuple[str, int, int], unseen: tuple[str, int, int]) -> Log:
    """A UR10e: rows of two of its logs; t, q, qd, currents."""
    folder = folder_of(root, UR10E)
    machine = quietly(folder / "URe/urdf/ur10e.urdf")
    names = [joint.name for joint in machine.motor_joints]
    parts = []
    for path, first, last in (seen, unseen):
        x = numbers(folder / "dataset_ur10e" / path, delimiter=",")[first:last]
        parts.append(columns_of(x[:, 0], x[:, 1:7], x[:, 13:19], names))
    gains = dict(zip(names, GAINS, strict=True))
    others = OTHERS | {"load friction": {"load_friction": names}, "stribeck": {"stribeck": dict.fromkeys(names, 0.1)}}
    return Log(machine, parts[0], parts[1], names, {"gains": gains}, others)


def tx40(root: Path) -> Log:
    """6 s of a TX40 and the rest; motor 6 turns by joints 5 and 6: q_m = q5 + q6, and acts on both."""
    folder = folder_of(root, FIGAROH) / "examples/staubli_TX40"
    q, tau = (
        numbers(folder / f"data/{name}.csv", delimiter=",", skiprows=1) for name in ("pos_read_data", "curr_data")
    )
    machine = quietly(folder / "urdf/tx40_mdh_modified.urdf")
    rows = list(machine.joints)
    zero, place = Formula.parse(0), [joint.name for joint in rows].index("joint_6")
    drive = replace(rows[place - 1], name="drive_6", variable="qm", theta=zero, body=Body(), kind=Kind.MOTOR)
    rows[place] = replace(
        rows[place], kind=Kind.COUPLED, variable=None, theta=Formula.parse(f"qm - {rows[place - 1].variable}")
    )
    machine = replace(machine, joints=(*rows, drive))
    names = [*(f"joint_{k}" for k in range(1, 6)), "drive_6"]
    q = q / TX40_RATIOS
    q[:, 1] -= np.pi / 2
    q[:, 2] += np.pi / 2
    whole = columns_of(np.arange(len(q)) / TX40_RATE, q, tau * TX40_RATIOS, names)
    others = OTHERS | {"load friction": {"load_friction": names}}
    return Log(machine, part(whole, 0.5, 6.5), part(whole, 6.5, 8.8), names, {}, others)


def tiago(root: Path) -> Log:
    """38 s of TIAGo's torso and arm, and 21 s after; wheels and head stand still.

    Errors are of the torso and joints 1 to 4. The wrist's currents are exactly zero at 85 % of the samples while it
    moves, and at the others a few steps of 1 mA: no model tells them.
    """
    folder = folder_of(root, FIGAROH) / "examples/tiago"
    machine = quietly(folder / "urdf/tiago_no_hand.urdf")
    data = folder / "data/identification/dynamic"
    q, tau = (
        numbers(data / f"tiago_{name}.csv", delimiter=",", skiprows=1)[slice(*TIAGO_MOVES)]
        for name in ("position", "effort")
    )
    names = ["torso_lift_joint", *(f"arm_{k}_joint" for k in range(1, 8))]
    t = q[:, 0]
    whole = columns_of(t, q[:, 1:9], tau[:, 1:9], names)
    still = [joint.name for joint in machine.motor_joints if joint.name not in names]
    whole |= {f"{block}_{name}": np.zeros(len(t)) for block in ("q", "tau") for name in still}
    end, told = float(t[-1] - t[0]), names[: len(TIAGO_GAINS)]
    gains = dict(zip(names, (*TIAGO_GAINS, *TIAGO_WRIST), strict=True))
    parts = part(whole, 0, end - TIAGO_PARTS), part(whole, end - TIAGO_PARTS, end)
    return Log(machine, *parts, told, {"resample": 100.0, "gains": gains}, {"load friction": {"load_friction": told}})


def quietly(path: Path) -> Machine:
    """A machine of a robot's file, whose warnings are not of interest here; raises `FileNotFoundError`."""
    if not path.is_file():
        raise FileNotFoundError(f"{path.parent.name}/{path.name} is missing")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return se.read(path)


POINTS = ("validation_data/ur-20_01_17-ptp_10_points.csv", 700, 4200)
LOGS: dict[str, Callable[[Path], Log]] = {
    "Panda, 15 s to 5 s": panda,
    "UR10e, 47 s to 40 s of another": lambda root: ur10e(
        root, ("identification_data/ur-20_02_12-50sec_12harm.csv", 355, 5090),
        ("identification_data/ur-20_02_12-40sec_12harm.csv", 500, 4460),
    ),
    "UR10e, 30 s to points": lambda root: ur10e(
        root, ("identification_data/ur-20_02_10-30sec_12harm.csv", 635, 3510), POINTS
    ),
    "TX40, 6 s to 2.3 s": tx40,
    "TIAGo, to 21 s": tiago,
}  # fmt: skip


def identified(log: Log, columns: Columns, **options: Any) -> Identified:
    """What is found of a record, beside errors of the unseen one."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return se.identify(log.machine, columns, **{"validate": log.unseen, **log.options, **options})


def errors_of(found: Fit | None, log: Log) -> Array:
    """Errors of unseen torques, mean of the joints, per cent: of every sample in the band of the motion, and of samples
    at which the joint moves."""
    if found is None:
        return np.full(2, np.nan)
    return np.array([np.mean([x[name] for name in log.joints]) for x in (found.band_percent, found.percent)])


def plain_errors(found: Identified, log: Log) -> Array:
    """The errors by least squares of least norm of the same rows, which `identify` refuses of short records."""
    result, tau = found.found, found.found.tau
    rows = [result.equations.rows(result.equations.sample(record, result.filter)) for record in found.records]
    Y = np.concatenate([np.concatenate([x.Y, x.offsets[:, :, list(result.sensors.offsets)]], axis=2) for x in rows])
    size = np.sqrt((tau**2).mean(axis=0))
    scale, kept = np.where(size > 0, size, 1.0), result.estimation.grouping.kept
    own = [k for k, c in enumerate(kept) if c < Y.shape[2]]
    A = (Y[:, :, [kept[k] for k in own]] / scale[:, None]).reshape(-1, len(own))
    X = np.zeros(len(kept))
    X[own] = np.linalg.lstsq(A, (tau / scale).ravel(), rcond=1e-10)[0]
    solution = replace(result.estimation.solution, X=X)
    other = replace(result, estimation=replace(result.estimation, solution=solution))
    (unseen,) = identified_record(found, log)
    return errors_of(validation_of(other, unseen), log)


def identified_record(found: Identified, log: Log) -> list[Measurements]:
    """The unseen record, prepared as those that are fitted."""
    prepare = Preparation(None, None, log.options.get("resample"), dict(log.options.get("gains", {})))
    return [measurements_of(log.unseen, found.found.machine, "unseen", prepare)]


def impossible(found: Identified) -> int:
    """How many bodies of the saved file are impossible when it is read again."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder) / "fitted.toml"
        se.write(found.saved()[0], path)
        machine = se.read(path)
    values = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
    count = 0
    for joint in machine.joints:
        x = nominal_body(joint.body, values)
        body = np.array([x[name] for name in INERTIAL])
        count += bool(body.any()) and bool(np.linalg.eigvalsh(pseudo_inertia(body)).min() <= 0)
    return count


def long_row(name: str, log: Log) -> list[tuple[str, ...]]:
    """Errors of the long record by way, with what `identify` says of late columns."""
    plain = identified(log, log.seen)
    at_rest = 100 - float(np.mean([plain.validation.counted[x] for x in log.joints])) if plain.validation else np.nan
    rows = [("least squares", errors_of(plain.validation, log), f"{at_rest:.0f} % at rest or reversals")]
    for title, trust in (("possible", None), ("trust 0.3", 0.3)):
        one = identified(log, log.seen, possible=True, trust=trust)
        rows.append((title, errors_of(one.validation, log), f"{impossible(one)} impossible bodies"))
    rows += [
        (title, errors_of(identified(log, log.seen, **more).validation, log), "") for title, more in log.others.items()
    ]
    said = [note.partition(":")[0] for note in plain.found.notes if "buffered channel" in note]
    found: list[tuple[str, ...]] = [(name, title, *(f"{x:.1f}" for x in both), note) for title, both, note in rows]
    return found + [(name, "says", "", "", note) for note in said]


def short_row(name: str, log: Log) -> list[tuple[str, ...]]:
    """Errors after records of 1.5 s: medians of some windows."""
    errors: dict[str, list[Array]] = {"least squares": [], "possible": [], "trust 0.3": []}
    bad, refused = 0, []
    length = float(np.ptp(log.seen["t"]))
    for first in np.linspace(0.0, length - SHORT, WINDOWS):
        cut = part(log.seen, first, first + SHORT)
        try:
            one, other = (identified(log, cut, possible=True, trust=trust) for trust in (None, 0.3))
        except InputError as failed:
            refused.append(failed.what)
            continue
        errors["least squares"].append(plain_errors(one, log))
        errors["possible"].append(errors_of(one.validation, log))
        errors["trust 0.3"].append(errors_of(other.validation, log))
        bad += impossible(one) + impossible(other)
    if not errors["possible"]:
        return [(name, "1.5 s", "", "", refused[0])]
    size = {way: np.median(x, axis=0) for way, x in errors.items()}
    said = {"least squares": "; ".join(refused), "possible": f"{bad} impossible bodies"}
    share = size["possible"] / size["least squares"]
    said["possible"] += f", {share[0]:.2g} and {share[1]:.2g} of least squares"
    return [(name, f"1.5 s, {way}", *(f"{x:.1f}" for x in both), said.get(way, "")) for way, both in size.items()]


def main() -> None:
    """Print the table; a log whose files are missing is a row that says so."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.real_logs", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="*", default=list(LOGS), help="beginnings of names of logs")
    given = parser.parse_args()
    rows: list[tuple[str, ...]] = []
    for name, read in LOGS.items():
        if not any(name.startswith(one) for one in given.only):
            continue
        try:
            log = read(given.folder)
            rows += [*long_row(name, log), *short_row(name, log)]
        except (FileNotFoundError, InputError, np.linalg.LinAlgError) as missing:
            rows.append((name, "", "", "", str(missing)))
    print_table("unseen torques, %", ("log", "way", "every sample", "in motion", ""), rows)


if __name__ == "__main__":
    main()
