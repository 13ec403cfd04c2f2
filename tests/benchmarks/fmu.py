"""FMUs in FMPy: `python -m tests.benchmarks.fmu`, needs `pip install fmpy cmake pin example-robot-data` and a compiler.

Findings of FMPy on ten FMUs, binaries from their sources alone, directional derivatives against central differences of
the FMU itself; a UR5 from URDF against Pinocchio; what parameters and tolerances cost.
"""

from __future__ import annotations

import argparse
import shutil
import time
import zipfile
from collections.abc import Iterator
from importlib.metadata import files
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from fmpy import simulate_fmu
from fmpy.build import build_platform_binary
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp

from symoro_elastic.formats.reading import read
from symoro_elastic.generation.fmu import Options
from symoro_elastic.generation.fmu.mock_up_unit import unit_of
from symoro_elastic.generation.fmu.programs import Programs, programs_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.packaging import reserved_words
from tests.benchmarks.match import require_pinocchio
from tests.benchmarks.tables import print_table, progress
from tests.generation.fmu.machines import EXAMPLES
from tests.generation.fmu.running import CO_SIMULATION, MODEL_EXCHANGE, Running, running

CASES = {
    "planar_2r": ("planar_2r.toml", Scene()),
    "two_axis": ("two_axis.toml", Scene(forces=("tool",))),
    "ball_screw": ("ball_screw.toml", Scene()),
    "sr400": ("sr400.par", Scene()),
    "two_axis, without parameters": ("two_axis.toml", Scene(fold=ALL)),
}
DURATION, TORQUES = 0.5, (3.0, -62.0, -14.0, 0.3, 0.05, 0.01)
"""Of the UR5: N m, constant, near those that hold it."""
TOLERANCES, RUNS = (1e-13, 1e-10, 1e-8, 1e-6, 1e-4), 7
SIZES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
"""Of central differences, of nominal and start values."""


def main() -> None:
    argparse.ArgumentParser(prog="python -m tests.benchmarks.fmu", description=__doc__).parse_args()
    require_pinocchio()
    with TemporaryDirectory() as folder:
        units(Path(folder))
        ur5(Path(folder))
        tolerances(Path(folder))
    parameters()


def units(folder: Path) -> None:
    """Ten FMUs: size, findings, binaries from sources, derivatives."""
    rows = []
    for name, version in progress([(name, v) for name in CASES for v in (2, 3)], "ten FMUs"):
        file, scene = CASES[name]
        began = time.process_time()
        made = unit_of(machine_in(EXAMPLES / file), scene, Options(version))
        seconds = time.process_time() - began
        path = folder / f"{name}_{version}.fmu"
        path.write_bytes(made.archive)
        found = validate_fmu(str(path))
        with running(path) as one:
            counts = [str(len(one.named(causality))) for causality in ("input", "output", "parameter")]
            error = worst_derivative(one)
        rows.append(
            [
                f"{name}, FMI {version}",
                str(len(one.states)),
                *counts,
                f"{len(made.archive) / 1000:.0f} kB",
                f"{seconds:.1f} s",
                "; ".join(found) or "none",
                "the same" if from_sources(path, folder) else "differs",
                f"{error:.1e}",
            ]
        )
    columns = ["FMU", "states", "inputs", "outputs", "parameters", "size", "processor time of Python", "findings"]
    print_table("Ten FMUs", [*columns, "steps from sources", "derivatives"], rows)


def machine_in(path: Path) -> Machine:
    return read(path, reserved_words())


def from_sources(path: Path, folder: Path) -> bool:
    """Whether an FMU without its binary, built as `fmpy compile` does, takes the same step."""
    bare = folder / "bare"
    shutil.rmtree(bare, ignore_errors=True)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(bare)
    shutil.rmtree(bare / "binaries")
    build_platform_binary(bare, cmake_options={"CMAKE_C_FLAGS:STRING": "-ffp-contract=off"})
    built = folder / "built.fmu"
    with zipfile.ZipFile(built, "w") as archive:
        for file in sorted(bare.rglob("*")):
            archive.write(file, file.relative_to(bare))
    ends = []
    for one in (path, built):
        with running(one, CO_SIMULATION) as found:
            found.set(dict.fromkeys(found.named("input"), 1.0))
            found.begin()
            found.step(0.0, 1e-3)
            ends.append(found.get(found.states) / found.nominals())
    return bool(np.abs(ends[0] - ends[1]).max() < 1e-12)


def worst_derivative(one: Running) -> float:
    """Largest difference of a column of derivatives from central differences at the best step, of its largest entry.

    A column below a millionth of the values over the size of the variable counts as zero.
    """
    one.begin()
    source = np.random.default_rng(0)
    start = one.get(one.states)
    one.set(dict(zip(one.states, start + 0.2 * one.nominals() * source.uniform(-1, 1, len(start)), strict=True)))
    sizes = dict(zip(one.states, one.nominals(), strict=True))
    unknowns = [*one.rates, *one.named("output")]
    worst = 0.0
    for name in [*one.states, *one.named("input"), *one.named("parameter")]:
        exact = one.along(unknowns, {name: 1.0})
        (x,) = one.get([name])
        size = sizes.get(name, max(abs(x), 1e-3))
        scale = max(np.abs(exact).max(), 1e-6 * np.abs(one.get(unknowns)).max() / size)
        tried = [_differences(one, unknowns, name, x, h * size) for h in SIZES]
        worst = max(worst, min(float(np.abs(found - exact).max()) / scale for found in tried))
    return worst


def _differences(one: Running, unknowns: list[str], name: str, x: float, h: float) -> np.ndarray:
    """Central differences of fourth order."""

    def at(change: float) -> np.ndarray:
        one.set({name: x + change})
        return one.get(unknowns)

    found: np.ndarray = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)
    one.set({name: x})
    return found


def ur5(folder: Path) -> None:
    """The robot of example-robot-data against Pinocchio's ABA, integrated by DOP853 at 1e-13."""
    path = urdf("ur5_robot.urdf")
    expected, moved = by_pinocchio(path)
    rows = []
    for version in (2, 3):
        made = unit_of(machine_in(path), Scene(), Options(version))
        file = folder / f"ur5_{version}.fmu"
        file.write_bytes(made.archive)
        for kind, tolerance in ((kind, t) for kind in (MODEL_EXCHANGE, CO_SIMULATION) for t in (1e-6, 1e-10, 1e-12)):
            rows.append([f"FMI {version}", kind, *_ended(file, kind, tolerance, expected)])
    title = f"UR5, {DURATION} s under constant torques, joints move by up to {moved:.2f} rad: error of q, Pinocchio"
    print_table(title, ["", "", "tolerance", "error, rad", "wall time"], rows)


def _ended(file: Path, kind: str, tolerance: float, expected: dict[str, float]) -> list[str]:
    torques = dict(zip((f"{name}.tau" for name in expected), TORQUES, strict=True))
    outputs = [f"{name}.q" for name in expected]
    began = time.perf_counter()
    made = simulate_fmu(
        str(file),
        fmi_type=kind,
        stop_time=DURATION,
        start_values=torques,
        output=outputs,
        output_interval=0.05,
        relative_tolerance=tolerance,
    )
    seconds = time.perf_counter() - began
    errors = [abs(made[f"{name}.q"][-1] - q) for name, q in expected.items()]
    return [f"{tolerance:g}", f"{max(errors):.1e}", f"{seconds:.2f} s"]


def by_pinocchio(path: Path) -> tuple[dict[str, float], float]:
    """Positions by joint at the end, and the largest motion."""
    import pinocchio

    model = pinocchio.buildModelFromUrdf(str(path))
    data, n = model.createData(), model.nq

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[n:], pinocchio.aba(model, data, y[:n], y[n:], np.array(TORQUES))])

    end = solve_ivp(rate, (0, DURATION), np.zeros(2 * n), method="DOP853", rtol=1e-13, atol=1e-14).y[:n, -1]
    return dict(zip(list(model.names)[1:], end.tolist(), strict=True)), float(np.abs(end).max())


def urdf(name: str) -> Path:
    found = (Path(str(file.locate())) for file in files("example-robot-data") or () if file.name == name)
    return next(found)


def tolerances(folder: Path) -> None:
    """50 ms of the two-axis machine under 200 N and 1000 N: errors by tolerance, least time of interleaved runs."""
    file = folder / "two_axis_2.fmu"
    ends: dict[float, np.ndarray] = {}
    seconds = dict.fromkeys(TOLERANCES, np.inf)
    for _ in range(RUNS):
        for tolerance in TOLERANCES:
            ends[tolerance], took = _step_of_two_axis(file, tolerance)
            seconds[tolerance] = min(seconds[tolerance], took)
    exact, usual = ends[TOLERANCES[0]], seconds[1e-10]
    rows = [
        [f"{tolerance:g}", f"{np.abs(ends[tolerance] - exact).max():.1e}", f"{seconds[tolerance] / usual:.3f}"]
        for tolerance in TOLERANCES
    ]
    columns = ["tolerance", "largest error of a state, of its nominal", "time, of that at 1e-10"]
    print_table("Co-Simulation of the two-axis machine, 50 ms in one step", columns, rows)


def _step_of_two_axis(file: Path, tolerance: float) -> tuple[np.ndarray, float]:
    """States over their nominal values at the end, and seconds."""
    with running(file, CO_SIMULATION, tolerance) as one:
        one.set({"motor_x.tau": 200.0, "motor_y.tau": 1000.0})
        one.begin()
        began = time.perf_counter()
        one.step(0.0, 0.05)
        return one.get(one.states) / one.nominals(), time.perf_counter() - began


def parameters() -> None:
    """Operations of the accelerations and of their derivative along a direction."""
    rows = []
    for file in ("planar_2r.toml", "two_axis.toml", "sr400.par"):
        machine = machine_in(EXAMPLES / file)
        for what, scene in (("bodies and springs", Scene()), ("none", Scene(fold=ALL))):
            rows.append([machine.name, what, *_operations(programs_of(machine, scene))])
    print_table("Operations", ["", "parameters", "accelerations", "along a direction", "ratio"], rows)


def _operations(made: Programs) -> Iterator[str]:
    counts = {one.model.name: one.program.count for one in made.models}
    direct, along = counts["direct_dynamics"], counts["direct_dynamics_directional"]
    yield from (f"{count.products}x {count.add}+" for count in (direct, along))
    yield f"{(along.products + along.add) / (direct.products + direct.add):.1f}"


if __name__ == "__main__":
    main()
