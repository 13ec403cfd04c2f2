"""A simulated shop floor: the vibration tests of examples/, of machines that are not what their files say.

Springs and dampers are those of SPRINGS, known here alone; the machine is that of `references.vibrating_tables`, not
the product's, and has a part that its file does not know. Lines are averaged from noisy records, as an analyzer does.

python -m tests.measured.vibration_tests.shop_floor --write
"""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from tests.references.vibrating_tables import Tables, VibratingTables, with_labels

Array = np.ndarray[Any, Any]

EXAMPLES = Path(__file__).parents[3] / "examples"
AVERAGES = 10
SPRINGS: dict[str, dict[str, tuple[float, float]]] = {
    "lathe": {
        "bed_roll": (4.6e7, 9.2e3),
        "z_nut": (7.3e7, 5.6e3),
        "saddle_yaw": (8.8e6, 770.0),
        "x_nut": (1.42e8, 7.1e3),
        "turret": (2.3e6, 64.0),
    },
    "two_axis": {
        "bed_yaw": (5.2e7, 1.6e4),
        "bed_y": (1.1e8, 3.1e4),
        "bed_x": (1.35e8, 3.4e4),
        "motor_secondary": (4.6e8, 1.4e4),
        "cart_yaw": (1.5e7, 1.3e3),
        "cart_x": (2.7e8, 1.6e4),
        "cart_y": (6.6e8, 2.2e4),
        "y_chain_1": (9.1e7, 2.1e3),
        "ram": (3.1e8, 6.0e3),
        "sensor_head": (2.0e7, 95.0),
    },
}
"""Stiffness and damping of the machines as they are."""
PUMP = {"name": "pump", "b": -0.1, "alpha": "-pi/2", "theta": 0, "r": "p + 0.05"}
"""A pump of 12 kg on the cross slide of the lathe, at its centre of mass: it shakes upright at 1.3 x the band."""
HAMMER = [("tool.ax", "tool.fx"), ("tool.ay", "tool.fx"), ("tool.ax", "tool.fy"), ("tool.ay", "tool.fy"),
          ("tool.az", "tool.fz"), ("x_nut.ax", "tool.fx")]  # fmt: skip
LATHE_AT: dict[str, dict[str, float]] = {
    "hammer_near": {"motor_z": 0.05, "motor_x": 0.02},
    "hammer_far": {"motor_z": 0.45, "motor_x": 0.15},
    "hammer_middle": {"motor_z": 0.25, "motor_x": 0.1},
}
SWEEP = [("motor_x.q", "motor_x.tau"), ("sensor_head.x", "motor_x.tau"), ("tool.ax", "motor_x.tau")]
CROSS_SWEEP = [("motor_y.q", "motor_y.tau"), ("tool.ay", "motor_y.tau")]
TWO_AXIS_AT = {"left": {"motor_x": -0.3, "motor_y": 0.1}, "right": {"motor_x": 0.25, "motor_y": -0.25}, "middle": {}}
UNITS = {"motor_x.q": 1e-6, "motor_y.q": 1e-6, "sensor_head.x": 1e-6, "tool.ax": 9.80665, "tool.ay": 9.80665}
"""um of encoders, g of accelerometers."""
SERVO = {"motor_x": (4.0e6, 4.0e4), "motor_y": (2.5e6, 2.5e4)}
F_LATHE, F_TWO_AXIS = np.arange(12.0, 281.0, 1.5), np.round(np.geomspace(8, 250, 150), 2)


def tables_of(name: str, springs: Mapping[str, tuple[float, float]] | None = None) -> dict[str, Any]:
    """The tables of a machine file, with stiffness and damping of springs in place of its own."""
    found = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"))
    given = (springs or {}).items()
    return with_labels(
        found, {f"{s}.{key}": x for s, kd in given for key, x in zip(("stiffness", "damping"), kd, strict=True)}
    )


def with_part(tables: Tables, on: str, row: Mapping[str, Any], mass: float, f: float, zeta: float) -> dict[str, Any]:
    """The tables with a point mass on a spring, of a frequency (Hz) and damping of its own, taken from a body's mass.

    `row` is the row of the joint in the table; the body keeps its mass where the spring is stiff if the row leads to
    its centre of mass.
    """
    more, w = deepcopy(dict(tables)), 2 * np.pi * f
    more["bodies"][on]["mass"] -= mass
    more["joints"].append({"antecedent": on, "kind": "elastic", "sigma": 1, "variable": "p", **row})
    more["bodies"][row["name"]] = {"mass": mass}
    more["springs"][row["name"]] = {"stiffness": mass * w * w, "damping": 2 * zeta * mass * w}
    return more


def machine(name: str) -> VibratingTables:
    """The machine as it is."""
    tables = tables_of(name, SPRINGS[name])
    return VibratingTables(with_part(tables, "x_nut", PUMP, 12.0, 364.0, 0.01) if name == "lathe" else tables)


def averaged(G: Array, rng: np.random.Generator, level: float = 0.01, n: int = AVERAGES) -> tuple[Array, Array]:
    """H1 = Syx/Sxx and coherence of n records with noise of `level` of |G| and of its median, complex normal.

    The input has the same size in all lines and records; its phase plays no part.
    """
    size = level * (np.abs(G) + np.median(np.abs(G), axis=-1, keepdims=True))
    noise = rng.normal(size=(n, *G.shape)) + 1j * rng.normal(size=(n, *G.shape))
    Y = G + size * np.sqrt(n / 2) * noise
    H = Y.mean(axis=0)
    return H, np.abs(H) ** 2 / np.mean(np.abs(Y) ** 2, axis=0)


def table(f: Array, pairs: Sequence[str], H: Array, coherence: Array, polar: bool = False, unit: str = "") -> str:
    """A .csv file of responses, to six digits."""
    header, columns = ["f [Hz]"], [f]
    for name, h, c in zip(pairs, H, coherence, strict=True):
        parts = (("mag", np.abs(h)), ("phase", np.degrees(np.angle(h)))) if polar else (("re", h.real), ("im", h.imag))
        units = (unit, " [deg]") if polar else (unit, unit)
        header += [*(f"{part} {name}{u}" for (part, _), u in zip(parts, units, strict=True)), f"coherence {name}"]
        columns += [x for _, x in parts] + [c]
    lines = [",".join(f"{x:.6g}" for x in row) for row in np.array(columns).T]
    return "\n".join([",".join(header), *lines]) + "\n"


def lathe_files() -> dict[str, str]:
    """Hammer tests, motors held by their brakes, and natural frequencies from a modal analysis."""
    files, names = {}, [f"{output}/{into}" for output, into in HAMMER]
    for seed, (file, at) in enumerate(LATHE_AT.items()):
        G = machine("lathe").response(at, ("motor_z", "motor_x"), HAMMER, F_LATHE).T
        H, coherence = averaged(G, np.random.default_rng(seed))
        files[f"{file}.csv"] = table(F_LATHE, names, H, coherence)
    f, zeta = machine("lathe").modes(LATHE_AT["hammer_middle"], ("motor_z", "motor_x"))
    f, zeta = f[:5], zeta[:5]  # the pump is above
    rng = np.random.default_rng(7)
    rows = zip(
        f * (1 + 1e-3 * rng.normal(size=5)), zeta * (1 + 0.03 * rng.normal(size=5)), 1e-3 * f, 0.03 * zeta, strict=True
    )
    lines = [",".join(f"{x:.6g}" for x in row) for row in rows]
    head = "frequency [Hz],damping_ratio,std_frequency [Hz],std_damping"
    return files | {"modes_middle.csv": "\n".join([head, *lines]) + "\n"}


def two_axis_files() -> dict[str, str]:
    """Sweeps of one motor, the other one under its servo; channels as the analyzer calls them."""
    files: dict[str, str] = {}
    for seed, (place, at) in enumerate(TWO_AXIS_AT.items()):
        for axis, pairs in (("x", SWEEP), ("y", CROSS_SWEEP)):
            other = "motor_y" if axis == "x" else "motor_x"
            G = machine("two_axis").response(at, (), pairs, F_TWO_AXIS, {other: SERVO[other]}).T
            G /= np.array([UNITS[output] for output, _ in pairs])[:, None]
            H, coherence = averaged(G, np.random.default_rng([seed, axis == "y"]))
            names = [f"ch{k + 2}/ch1" for k in range(len(pairs))]
            files[f"{axis}_{place}.csv"] = table(F_TWO_AXIS, names, H, coherence, polar=True)
    return files


def files() -> dict[str, str]:
    """All files of the shop floor, by their paths under examples/."""
    each = {"lathe_tests": lathe_files(), "two_axis_tests": two_axis_files()}
    return {f"{folder}/{name}": text for folder, some in each.items() for name, text in some.items()}


def main() -> None:
    """Write the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", required=True, help="write the files of examples/")
    parser.parse_args()
    for path, text in files().items():
        (EXAMPLES / path).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
