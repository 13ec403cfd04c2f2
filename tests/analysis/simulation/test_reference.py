"""Reference motions: against derivatives in 40 digits, records in files, servos, equilibria, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.analysis.simulation.reference_motion import Reference, reference_of
from symoro_elastic.analysis.simulation.tolerances import output_signals, refuse_rounding, tolerances
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml.motions import read_motions, read_wanted
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Floating, Kind, KnownOfBase, Machine
from symoro_elastic.machine.prescribed_motion import AppliedForce, Bandwidth, Gains, Move, PrescribedMotion, Wobble
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from tests.analysis.vibration.machines import WEIGHT, drive, machine_of, slide, spring
from tests.closed_chains.machines import machine as closed_chain
from tests.command_line import EXAMPLES

pytestmark = pytest.mark.sampled(5)

SECONDS = np.linspace(0.0, 0.25, 23)


@cache
def two_axis() -> Machine:
    return read_machine(EXAMPLES / "two_axis.toml")[0]


def motion(**given: Any) -> PrescribedMotion:
    return PrescribedMotion(**{"duration": 0.25, **given}, source="scene.toml")


def rise(t: Any, begins: float, lasts: float) -> Any:
    x = min(max((t - mpmath.mpf(begins)) / mpmath.mpf(lasts), 0), 1)
    return 35 * x**4 - 84 * x**5 + 70 * x**6 - 20 * x**7


def assert_motion(found: Reference, wanted: Callable[[Any], Any], motor: int, tolerance: float) -> None:
    """y, y', y'' at times inside the motion are a function and its derivatives, found in 40 digits.

    The coefficients of the rise add up to 208, those of its derivatives to 512 times their largest value, in steps of
    1.1e-16.
    """
    inside = SECONDS[1:-1]
    with mpmath.workdps(40):
        for k, rows in enumerate(found.at(inside)):
            exact = np.array([float(mpmath.diff(wanted, mpmath.mpf(t), k)) for t in inside])
            np.testing.assert_allclose(rows[:, motor], exact, rtol=0, atol=tolerance * np.abs(exact).max())


# Closed forms


def test_moves_and_wobbles_add() -> None:
    given = motion(
        start={"motor_x": 0.02},
        moves=(Move("motor_x", 0.08, 0.013, 0.15), Move("motor_x", -0.03, 0.1, 0.12), Move("motor_y", 0.05, 0.0, 0.2)),
        wobbles=(Wobble("motor_x", 1e-3, 17.0),),
    )

    def along_x(t: Any) -> Any:
        swing = mpmath.mpf(1e-3) * mpmath.sin(2 * mpmath.pi * 17 * t)
        faded = swing * rise(t, 0, 1 / mpmath.mpf(17)) * rise(mpmath.mpf(0.25) - t, 0, 1 / mpmath.mpf(17))
        return mpmath.mpf(0.02) + 0.08 * rise(t, 0.013, 0.15) - mpmath.mpf(0.03) * rise(t, 0.1, 0.12) + faded

    found = reference_of(two_axis(), given)
    assert found.motors == ("motor_x", "motor_y") and found.servo is None and found.duration == 0.25
    assert_motion(found, along_x, 0, 1e-13)
    assert_motion(found, lambda t: 0.05 * rise(t, 0, 0.2), 1, 1e-13)


def test_motions_begin_and_end_at_rest() -> None:
    given = motion(moves=(Move("motor_x", 0.08, 0.1, 0.15),), wobbles=(Wobble("motor_x", 1e-3, 25.0),))
    y, yd, ydd = reference_of(two_axis(), given).at(np.array([0.0, 0.25]))
    np.testing.assert_allclose(y, [[0, 0], [0.08, 0]], rtol=0, atol=1e-17)
    np.testing.assert_allclose([yd, ydd], np.zeros((2, 2, 2)), rtol=0, atol=1e-12)


def test_forces_rise_and_stay() -> None:
    given = motion(
        forces=(
            AppliedForce("tool", (200.0, 0, 0, 0, 0, -3.0), 0.1, 0.05),
            AppliedForce("ram", (1.0, *[0.0] * 5), 0, 0.1),
        )
    )
    found = reference_of(two_axis(), given)
    wrenches, rates = found.wrenches(np.array([0.0, 0.1, 0.125, 0.15, 0.25]))
    assert list(map(str, found.loaded.forces)) == ["tool", "ram"] and wrenches.shape == rates.shape == (5, 12)
    np.testing.assert_allclose(wrenches[:, 0], [0, 0, 100, 200, 200], rtol=1e-14)
    np.testing.assert_allclose(wrenches[:, 5], [0, 0, -1.5, -3, -3], rtol=1e-14)
    before, after = (found.wrenches(np.array([0.125 + shift]))[0][0] for shift in (-1e-6, 1e-6))
    np.testing.assert_allclose(rates[2], (after - before) / 2e-6, rtol=1e-8, atol=1e-8)


def test_forces_on_one_frame_are_summed() -> None:
    force = AppliedForce("tool", (200.0, 0, 0, 0, 0, -3.0), 0.1, 0.05)
    found = reference_of(two_axis(), motion(forces=(force, force)))
    wrenches, _ = found.wrenches(np.array([0.25]))
    np.testing.assert_array_equal(wrenches, [[400, 0, 0, 0, 0, -6]])


def test_jerks_are_derivatives_of_accelerations() -> None:
    """Of moves and wobbles, by central differences."""
    found = reference_of(two_axis(), motion(wobbles=(Wobble("motor_y", 1e-3, 25.0),)))
    t = np.linspace(0.01, 0.24, 40)
    before, after = (found.at(t + shift)[2] for shift in (-1e-6, 1e-6))
    differences = (after - before) / 2e-6
    np.testing.assert_allclose(found.jerks(t), differences, rtol=0, atol=1e-6 * np.abs(differences).max())


# Start and servos


def test_springs_sag_at_the_start() -> None:
    """A weight of 5 kg on 2e4 N/m hangs 5 g / k lower, wherever the motor is."""
    weighty = machine_of(
        "lift", slide("motor", 0, Kind.MOTOR, 3.0), slide("load", 1, Kind.ELASTIC, 5.0, spring=spring(2e4)), base=WEIGHT
    )
    found = reference_of(weighty, motion(start={"motor": 0.7}))
    np.testing.assert_allclose(found.start.q, [0.7, -5 * 9.81 / 2e4], rtol=1e-12)
    np.testing.assert_array_equal(found.start.qd, 0)
    np.testing.assert_allclose(found.start.tau, [8 * 9.81, 0], rtol=1e-12)


def test_servos_have_the_inertia_that_the_motor_moves_with_springs_locked() -> None:
    given = motion(servo={"motor_y": Bandwidth(20.0, 0.7), "motor_x": Gains(2e6, 3e4)})
    kp, kd = reference_of(two_axis(), given).servo or ((), ())
    omega, carried = 2 * np.pi * 20, 180 + 8 + 95
    np.testing.assert_allclose(kp, [2e6, carried * omega**2], rtol=1e-12)
    np.testing.assert_allclose(kd, [3e4, 2 * 0.7 * carried * omega], rtol=1e-12)


def test_values_of_parameters_count() -> None:
    machine = machine_of("lift", slide("motor", 0, Kind.MOTOR, "m"), parameters={"m": 3.0})
    given = motion(servo={"motor": Bandwidth(1 / (2 * np.pi), 1.0)})
    for values, m in (({}, 3.0), ({"m": 7.0}, 7.0)):
        kp, kd = reference_of(machine, given, values).servo or ((), ())
        np.testing.assert_allclose([kp[0], kd[0]], [m, 2 * m], rtol=1e-14)


@pytest.mark.parametrize("name", ["ball_screw", "parallelogram_loop", "coupled_wrist"])
def test_machines_with_couplings_and_loops(name: str) -> None:
    """The start is a position where loops close and springs and gravity are in balance, torques of motors apart."""
    machine = closed_chain(name)
    motor = machine.motor_joints[0].name
    found = reference_of(machine, motion(moves=(Move(motor, 0.01, 0.0, 0.1),)))
    equations = EquationsOfMotion(machine)
    zero = np.zeros_like(found.start.q)
    forces = equations.forces(found.start.q, zero, zero)
    others = [k for k in range(len(zero)) if k not in machine.motor_entries]
    assert np.abs(forces[others]).max(initial=0.0) <= 1e-9 * max(1.0, np.abs(forces).max())
    y, _, _ = found.at(np.array([0.0, 0.25]))
    np.testing.assert_allclose(y[0], found.start.q[list(machine.motor_entries)], rtol=0, atol=0)
    np.testing.assert_allclose(y[1] - y[0], [0.01, *[0.0] * (y.shape[1] - 1)], rtol=0, atol=1e-15)


def test_the_example_is_read_and_ends_where_it_says() -> None:
    scene = EXAMPLES / "scenes" / "two_axis_move.toml"
    (given,), wanted = read_motions(scene, two_axis()), read_wanted(scene)
    assert wanted is not None
    found = reference_of(two_axis(), given)
    y, yd, _ = found.at(np.array([0.0, 0.15, 0.25]))
    np.testing.assert_allclose(y, [[0, 0.1], [0.08, 0.15], [0.08, 0.15]], rtol=1e-15)
    np.testing.assert_array_equal(yd, 0)
    assert tolerances(wanted, two_axis()) == {"tool.x": 1e-5, "tool.y": 1e-5}
    refuse_rounding(tolerances(wanted, two_axis()), found)


# Records


def columns(t: Array, orders: int, letter: str = "y") -> dict[str, Array]:
    """A motion 0.05 cos(3 t) of the motor of `drive`, and its derivatives."""
    waves = (np.cos(3 * t), -3 * np.sin(3 * t), -9 * np.cos(3 * t), 27 * np.sin(3 * t))
    return {"t": t} | {f"{letter}{'d' * k}_motor": 0.05 * waves[k] for k in range(orders + 1)}


def saved(path: Path, columns: dict[str, Array]) -> PrescribedMotion:
    if path.suffix == ".npz":
        np.savez(path, **columns)
    else:
        rows = "\n".join(",".join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True))
        path.write_text(",".join(columns) + "\n" + rows + "\n")
    return replace(motion(file=path.name, duration=1.0), source=str(path.parent / "scene.toml"))


HERMITE = (1 / 46080, 5**0.5 / 30000, 1 / 1920)
"""Errors over h^(6 - k) y^(6) between samples with y, y', y'': Birkhoff and Priver (1967)."""
SPLINE = (16.91 / 720, 120 / 720, 548 / 720)
"""... of the polynomial through six samples, at its end: derivatives of x (x - 1) ... (x - 5) over 6!."""


@pytest.mark.parametrize(
    ("name", "orders", "letter", "bounds"),
    [("w.csv", 0, "y", SPLINE), ("w.csv", 1, "y", SPLINE), ("w.npz", 2, "y", HERMITE), ("w.csv", 3, "q", HERMITE)],
    ids=["a spline", "velocities without accelerations", "accelerations", "more, as excite writes them"],
)
def test_records(name: str, orders: int, letter: str, bounds: tuple[float, ...], tmp_path: Path) -> None:
    """Between 21 samples they are the motion."""
    samples = columns(np.linspace(0, 1, 21), orders, letter)
    found = reference_of(drive(), saved(tmp_path / name, samples))
    t = np.linspace(0, 1, 97)
    exact = list(columns(t, 2).values())[1:]
    for k, (rows, row, bound) in enumerate(zip(found.at(t), exact, bounds, strict=True)):
        within = bound * 0.05 ** (6 - k) * 0.05 * 3**6
        np.testing.assert_allclose(rows[:, 0], row, rtol=1e-14, atol=within, err_msg=str(k))
    assert found.start.q[0] == 0.05


def test_fast_records_keep_their_samples(tmp_path: Path) -> None:
    """20 kHz, with a wobble of 2 kHz."""
    t = np.arange(2001) / 20e3
    wave = 1e-4 * np.sin(2 * np.pi * 2e3 * t)
    found = reference_of(drive(), replace(saved(tmp_path / "fast.npz", {"t": t, "y_motor": wave}), duration=0.1))
    np.testing.assert_allclose(found.at(t)[0][:, 0], wave, rtol=0, atol=1e-16)


def test_the_start_moves_as_the_record_does(tmp_path: Path) -> None:
    t = np.linspace(0, 1, 51)
    record = saved(tmp_path / "w.npz", {"t": t, "y_motor": 0.1 + 0.2 * t, "yd_motor": 0.2 + 0 * t, "ydd_motor": 0 * t})
    found = reference_of(drive(), replace(record, moves=(Move("motor", 0.5, 0.2, 0.3),), start={"motor": 0.1}))
    np.testing.assert_allclose(found.start.qd, [0.2, 0], rtol=1e-14)
    np.testing.assert_array_equal(found.start.qdd, 0)
    np.testing.assert_allclose(found.at(np.array([0.0, 0.35, 1.0]))[0][:, 0], [0.1, 0.17 + 0.25, 0.8], rtol=1e-14)


def without(columns: dict[str, Array], name: str) -> dict[str, Array]:
    return {key: x for key, x in columns.items() if key != name}


T = np.linspace(0, 1, 41)
RECORDS = {
    "w.csv: t: it has 0 to 0.5 s, the motion 0 to 1 s: record all of it, or change duration": columns(T / 2, 2),
    "w.csv: t: gap of 0.325 s after 0.225 s, sample 10, line 11: give samples": columns(np.delete(T, slice(10, 22)), 2),
    "w.csv: t: gap of 0.05 s after 0.225 s, sample 10, line 11: give samples there": columns(np.delete(T, 10), 2),
    "w.csv: t: 5 samples are too few for a motion: give 6 or more": columns(np.linspace(0, 1, 5), 2),
    "w.csv: y_motor: missing": without(columns(T, 2), "y_motor"),
    "w.csv: y_motor: derivative 0 changes by": columns(T, 1) | {"yd_motor": 1e3 * T},
    "w.csv: y_motor: derivative 1 changes by": columns(T, 2) | {"ydd_motor": 1e3 * T},
    "w.csv: t: does not increase at sample 2, line 3": columns(T[::-1], 0),
    "scene.toml: motion, start, motor: 0.3 is not where w.csv begins, 0.05: leave it out": columns(T, 2),
}


@pytest.mark.parametrize("said", RECORDS)
def test_records_refused(said: str, tmp_path: Path) -> None:
    record = saved(tmp_path / "w.csv", RECORDS[said])
    with pytest.raises(InputError) as caught:
        reference_of(drive(), replace(record, start={"motor": 0.3}))
    assert str(caught.value).startswith(f"{tmp_path}/{said}") and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ("nan", "y_motor: NaN or infinity in the motion or its derivatives, sample 3, line 6"),
        ("-inf", "y_motor: NaN or infinity in the motion or its derivatives, sample 3, line 6"),
        ("", "y_motor: line 6: is empty: a gap in the data"),
        ("x", "y_motor: line 6: 'x' is not a number"),
    ],
)
def test_the_line_of_a_bad_sample_is_named(cell: str, said: str, tmp_path: Path) -> None:
    """Empty lines count."""
    record = saved(tmp_path / "w.csv", columns(T, 0))
    head, first, second, third, *rest = (tmp_path / "w.csv").read_text().splitlines()
    lines = [head, "", first, "", second, f"{third.split(',')[0]},{cell}", *rest]
    (tmp_path / "w.csv").write_text("\n".join(lines))
    with pytest.raises(InputError) as caught:
        reference_of(drive(), record)
    assert str(caught.value).startswith(f"{tmp_path}/w.csv: {said}")


def test_a_record_that_is_not_there(tmp_path: Path) -> None:
    missing = replace(motion(file="none.csv"), source=str(tmp_path / "scene.toml"))
    with pytest.raises(InputError, match=r"none\.csv: file: no such file"):
        reference_of(drive(), missing)


# Refusals


def locked(name: str) -> Machine:
    return restrict(two_axis(), Scene(locked={name: ZERO}))


REFUSED: dict[str, tuple[Machine, PrescribedMotion]] = {
    "scene.toml: motion, servo: motor_x without a servo: give one to all motors, or to none": (
        two_axis(), motion(servo={"motor_y": Gains(1.0, 1.0)}),
    ),
    "scene.toml: motion, moves 1: motor_x is locked by the scene: remove one of the two": (
        locked("motor_x"), motion(moves=(Move("motor_x", 1.0, 0.0, 0.1),)),
    ),
    "scene.toml: motion, wobbles 1: motor_x is locked": (
        locked("motor_x"), motion(wobbles=(Wobble("motor_x", 1.0, 20.0),)),
    ),
    "scene.toml: motion, servo: motor_x is locked": (
        locked("motor_x"), motion(servo={"motor_x": Gains(1.0, 1.0), "motor_y": Gains(1.0, 1.0)}),
    ),
    "scene.toml: motion, start: ram is locked": (locked("ram"), motion(start={"ram": 0.0})),
    "base, known: the acceleration of the base is given, so it is not a state": (
        replace(two_axis(), floating=Floating(known=KnownOfBase.ACCELERATION)), motion(),
    ),
}  # fmt: skip


@pytest.mark.parametrize("said", REFUSED)
def test_motions_refused(said: str) -> None:
    with pytest.raises(InputError) as caught:
        reference_of(*REFUSED[said])
    assert said in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.thorough
def test_motors_on_dependent_joints_become_independent_where_they_follow_exactly() -> None:
    machine = closed_chain("gantry")
    servo = {joint.name: Gains(1e5, 1e3) for joint in machine.motor_joints}
    assert reference_of(machine, motion(servo=servo)).machine is machine
    names = [joint.name for joint in reference_of(machine, motion()).machine.independent_joints]
    assert names == ["carriage_1", "cross_slide", "ram", "carriage_2"]


# What is wanted


TOOL = ("tool.x", "tool.rz", "motor_x")


def wanted(**given: Any) -> Wanted:
    return Wanted(**given, source="scene.toml")


def test_one_tolerance_for_all_outputs_or_by_signal() -> None:
    assert tolerances(wanted(tolerance=1e-6, outputs=TOOL), two_axis()) == dict.fromkeys(
        ("tool.x", "tool.rz", "motor_x.q"), 1e-6
    )
    by_signal = wanted(tolerance={"motor_x.tau": 5.0, "ram": 1e-7, "tool at (0, 0, L12).vx": 1e-3})
    assert tolerances(by_signal, two_axis()) == {"motor_x.tau": 5.0, "ram.q": 1e-7, "tool at (0, 0, L12).vx": 1e-3}
    assert output_signals(by_signal, two_axis()) == ("motor_x.tau", "ram.q", "tool at (0, 0, L12).vx")
    assert tolerances(wanted(period=1e-3), two_axis()) == {} and output_signals(wanted(outputs=TOOL), two_axis()) == (
        "tool.x", "tool.rz", "motor_x.q",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"tolerance": {"tol.x": 1.0}}, "wanted, tolerance: 'tol.x': no frame 'tol'; did you mean 'tool'?"),
        ({"tolerance": {"ram.tau": 1.0}}, "wanted, tolerance: 'ram.tau': ram has no motor"),
        ({"tolerance": {"tool.fx": 1.0}}, "wanted, tolerance: 'tool.fx' is not NAME.QUANTITY with a quantity of"),
        ({"tolerance": {"tool": 1.0}}, "wanted, tolerance: 'tool' is not NAME.QUANTITY"),
        ({"tolerance": 1.0, "outputs": ("motor_z",)}, "wanted, outputs: 'motor_z' is not NAME.QUANTITY"),
        ({"tolerance": 1.0}, "wanted, tolerance: one number applies to all outputs: add outputs, or give it by signal"),
        ({"tolerance": 1.0, "outputs": ("tool.x", "motor_x.tau")},
         'wanted, tolerance: one number is in m or rad, motor_x.tau in N: give it by signal, { "motor_x.tau" = X }'),
        ({"tolerance": 1.0, "outputs": ("tool.vx",)}, "wanted, tolerance: one number is in m or rad, tool.vx in m/s"),
    ],
)  # fmt: skip
def test_signals_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        tolerances(wanted(**given), two_axis())
    assert str(caught.value).startswith(f"scene.toml: {said}") and "\n" not in str(caught.value)


def test_a_tolerance_below_rounding_is_refused() -> None:
    found = reference_of(two_axis(), motion(start={"motor_y": -0.1}, moves=(Move("motor_y", 0.5, 0.0, 0.2),)))
    assert found.extent == pytest.approx(0.5, rel=1e-12)
    refuse_rounding({"tool.x": 5.1e-15, "motor_x.tau": 1e-30}, found)
    with pytest.raises(
        InputError, match=r"tolerance, tool\.x: 4\.9e-15 is below rounding, 5e-15 for positions up to 0\.5"
    ):
        refuse_rounding({"tool.x": 4.9e-15}, found)
