"""All loops closed: poles and responses against python-control, slopes against differences, gains by the figures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.control.cascade import Biquad, Cascade, DeadTime, FirstOrder, laplace
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.plant import Axis, Plant, response_slopes
from symoro_elastic.analysis.control.tuning import ABOVE
from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.analysis.vibration.responses import with_modal_damping
from symoro_elastic.formats.toml.starting import starting_text
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import TUNED, Drive, Drives, LowPass
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Machine
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from tests.analysis.control.test_largest_gain import drive
from tests.references.random_machines import led_by_the_first, random_machine

EXAMPLES = Path(__file__).parents[3] / "examples"
PATH = (DeadTime("dead time", 1.5e-4), FirstOrder("lag", 2e-4), Biquad("notch", 300.0, 0.1, 0.5))
RATIO = 0.02


def plant_of(machine: Machine | str, held: tuple[str, ...] = (), ratio: float = RATIO) -> Plant:
    source = se.read(EXAMPLES / machine) if isinstance(machine, str) else machine
    motion = motion_of(source)
    linear = with_modal_damping(linearize(motion, equilibrium(motion, {})), ratio)
    rows = zip(motion.motor_names, linear.motors, strict=True)
    return Plant(linear, {name: Axis(name, row, row) for name, row in rows}, ratio, held)


def weightless(machine: Machine) -> Machine:
    """The machine without gravity, which is at rest anywhere."""
    return replace(machine, base=Base())


def drives_of(plant: Plant) -> list[Cascade]:
    """Drives whose gains are some of the inertia that a motor feels, with all parts."""
    found = []
    for k, (name, axis) in enumerate(plant.axes.items()):
        if name not in plant.held:
            felt = 1 / (axis.velocity @ np.linalg.solve(plant.linear.M, axis.velocity))
            found.append(Cascade(name, 15.0 + k, 60 * felt, (0.05, np.inf)[k % 2], PATH, 0.9, 0.5 * felt))
    return found


MACHINES = {
    "two_axis": lambda: plant_of("two_axis.toml"),
    "one held": lambda: plant_of("two_axis.toml", ("motor_y",)),
    "ball_screw": lambda: plant_of("ball_screw.toml"),
    "sr400": lambda: plant_of("sr400.par"),
    "coupled": lambda: plant_of(weightless(led_by_the_first(random_machine(3, joints=5, friction=False)))),
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", [*MACHINES])
def test_states_and_frequencies_are_one_system(name: str) -> None:
    """Set points to positions, by states and by Z: at low frequencies, where an approximated dead time is exact."""
    plant = MACHINES[name]()
    cascades = drives_of(plant)
    loop = closed_loop(plant, cascades)
    for s in (0.3 + 2j, 20j):
        for k, one in enumerate(cascades):
            B = sum(s**order * columns[:, k] for order, columns in enumerate(loop.by_set_point))
            moved = np.linalg.solve(s * np.eye(len(loop.A)) - loop.A, B)[: plant.free.shape[1]]
            for axis in plant.axes.values():
                by_states = axis.position @ plant.free @ moved
                at = np.array([s])
                by_Z = (
                    plant.displacements(at, cascades, plant.axes[one.motor].velocity[:, None])[0, :, 0] @ axis.position
                )
                assert by_states == pytest.approx(by_Z * one.forward(at)[0], rel=1e-9, abs=1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["two_axis", "ball_screw"])
def test_poles_and_compliance_are_those_of_python_control(name: str) -> None:
    """The same loops by its `interconnect`, from transfer functions and signals."""
    control = pytest.importorskip("control")
    plant = MACHINES[name]()
    cascades, linear, n = drives_of(plant), plant.linear, len(plant.linear.M)
    inverse = np.linalg.inv(linear.M)
    push = np.hstack([inverse @ plant.axes[one.motor].velocity[:, None] for one in cascades] + [inverse[:, :1]])
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ linear.K, -inverse @ linear.D]])
    B = np.vstack([np.zeros_like(push), push])
    names = [f"tau{k}" for k in range(len(cascades))]
    rows = [[*plant.axes[one.motor].velocity, *np.zeros(n)] for one in cascades]
    rows += [[*np.zeros(n), *plant.axes[one.motor].velocity] for one in cascades] + [[1.0] + [0.0] * (2 * n - 1)]
    seen = [f"p{k}" for k in range(len(cascades))] + [f"v{k}" for k in range(len(cascades))] + ["x"]
    systems = [control.ss(A, B, rows, 0, inputs=[*names, "f"], outputs=seen, name="machine")]
    s = control.tf("s")
    for k, one in enumerate(cascades):
        pi = one.Kp * (1 + 1 / (one.Tn * s)) if np.isfinite(one.Tn) else control.tf([one.Kp], [1])
        delay = control.tf(*control.pade(1.5e-4, 2))
        w = 2 * np.pi * 300.0
        notch = (s**2 + 0.2 * w * s + w**2) / (s**2 + w * s + w**2)
        torque = control.ss(pi * delay * notch / (1 + 2e-4 * s), inputs="e", outputs=f"tau{k}", name=f"torque{k}")
        error = control.ss([], [], [], [[-one.Kv, -1.0]], inputs=[f"p{k}", f"v{k}"], outputs="e", name=f"error{k}")
        systems.append(control.interconnect([error, torque], inputs=[f"p{k}", f"v{k}"], outputs=[f"tau{k}"],
                                            name=f"drive{k}"))  # fmt: skip
    whole = control.interconnect(systems, inputs=["f"], outputs=["x"])
    loop = closed_loop(plant, cascades)
    theirs, ours = (np.sort_complex(x) for x in (whole.poles(), loop.poles))
    assert len(theirs) == len(ours)
    nearest = np.abs(ours[:, None] - theirs).min(axis=1)
    assert nearest.max() <= 1e-10 * np.abs(ours).max() and (nearest <= 1e-8 * (np.abs(ours) + 1)).all()
    for f in (0.5, 7.0):
        first = np.eye(n)[0]
        mine = plant.displacements(laplace(np.array([f])), cascades, first[:, None])[0, 0, 0]
        assert complex(whole(2j * np.pi * f)) == pytest.approx(mine, rel=1e-10)


@pytest.mark.thorough
@pytest.mark.parametrize("name", [*MACHINES])
def test_slopes_of_responses_are_those_of_differences(name: str) -> None:
    """Springs, masses and rotors, with damping in every mode, and positions of springs that follow their loads."""
    plant = MACHINES[name]()
    cascades = drives_of(plant)
    axis, s = next(axis for name, axis in plant.axes.items() if name not in plant.held), 2j * np.pi * 40.0
    own = axis.velocity
    row, _ = plant.rows(axis.motor)
    slopes = response_slopes(plant, s, cascades, row, row)
    motion = plant.linear.motion
    kinds = (".stiffness", ".mass", ".ZZ", ".rotor_inertia")
    names = [next((x for x in motion.parameters if x.endswith(kind)), "") for kind in kinds]
    for parameter in filter(None, names):
        value, step = motion.parameters[parameter], 1e-3

        def response(factor: float, parameter: str = parameter, value: float = value) -> complex:
            there = motion.at_values({parameter: value * (1 + factor)})
            linear = with_modal_damping(linearize(there, equilibrium(there, {})), RATIO)
            changed = replace(plant, linear=linear)
            found: complex = changed.displacements(np.array([s]), cascades, own[:, None])[0, :, 0] @ own
            return found

        near, far = response(step) - response(-step), response(2 * step) - response(-2 * step)
        expected = (8 * near - far) / (12 * step)
        scale = abs(response(0.0)) * 1e-9
        assert slopes[parameter] == pytest.approx(expected, rel=1e-5, abs=scale), parameter


def described(**drives: Drive) -> DescribedMachine:
    machine = se.read(EXAMPLES / "two_axis.toml")
    return replace(machine, drives=Drives(drives))


def test_a_steady_velocity_is_followed_as_its_forward_share_says() -> None:
    """v/Kv (1 - kfv) behind with an integral part, without friction."""
    f = Formula.parse
    one = Drive(f(20), f(3e4), f(0.03), velocity_forward=f(0.75), dead_time=f(1e-4))
    (axis,) = se.control(described(motor_x=one), damping=0.02).places[0].axes
    assert axis.velocity_error == pytest.approx(0.25 / 20, rel=1e-4)


def test_the_filter_of_a_set_point_is_behind_and_limits_are_said_to_be_left_out() -> None:
    f = Formula.parse
    one = Drive(f(20), f(3e4), f(0.03), set_point=LowPass(f(50)), torque_limit=f(900))
    found = se.control(described(motor_x=one), damping=0.02)
    assert found.places[0].axes[0].velocity_error == pytest.approx(1 / (100 * np.pi), rel=1e-4)
    assert "limits of torque (motor_x) are omitted: these results are linear" in found.notes


def test_motors_without_a_drive_are_held_and_said() -> None:
    found = se.control(described(motor_x=Drive(Formula.parse(20), Formula.parse(3e4))), damping=0.02)
    assert "motor_y has no drive and is held" in found.notes and found.plants[0].held == ("motor_y",)


@pytest.mark.thorough
def test_gains_of_the_specification() -> None:
    """Published by a trial with dense matrices: `ball_screw` with 1 and 2 % damping, both axes of `two_axis`."""
    f = Formula.parse
    free = Drive(TUNED, TUNED, lag=f(2e-4), dead_time=f(1.5e-4))
    screw = replace(se.read(EXAMPLES / "ball_screw.toml"), drives=Drives({"motor": free}))
    for damping, gain, frequency in ((0.01, 4.68, 1277), (0.02, 8.37, 1284)):
        limit = se.control(screw, damping=damping).places[0].axes[0].limits[0]
        assert (round(limit.largest.gain, 2), round(limit.largest.frequency)) == (gain, frequency)
    x = se.control(described(motor_x=free), damping=0.02, along={"motor_y": [0.0, 0.2, 0.4]})
    gains = [place.axes[0].limits[0] for place in x.places]
    assert [round(one.largest.gain, -2) for one in gains] == [37500, 36800, 36000]
    effects = [round(gains[0].influences[name], 1) for name in ("dead time", "lag of the current loop")]
    assert effects == [-1.8, -1.2]
    (y,) = se.control(described(motor_y=free), damping=0.02).places[0].axes
    assert round(y.limits[0].largest.gain, -3) == 476_000 and round(y.limits[0].influences["dead time"], 1) == -0.8


@pytest.mark.thorough
def test_a_tuned_machine_is_at_its_distances() -> None:
    """At the worst of the positions; at the others it is further away."""
    found = se.control(EXAMPLES / "two_axis.toml", damping=0.02, along={"motor_y": [-0.2, 0.2]}, modulus=0.55)
    for k in range(2):
        velocity = min(place.axes[k].velocity.modulus for place in found.places)
        position = min(place.axes[k].position.modulus for place in found.places)
        assert velocity == pytest.approx(0.55, abs=2e-3) and position == pytest.approx(0.7, abs=2e-3)
    assert all(place.growth < 0 for place in found.places)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["planar_2r.toml", "linkage.toml", "puma560_measured.toml", "sr400.par"])
def test_axes_that_load_each_other_are_tuned_together(name: str) -> None:
    """With its neighbour free an axis moves less inertia: the shoulder of the 2R a third of what it moves else."""
    machine, f = se.read(EXAMPLES / name), Formula.parse
    one = Drive(TUNED, TUNED, TUNED, lag=f(2e-4), dead_time=f(1.5e-4))
    driven = replace(machine, drives=Drives({joint.name: one for joint in machine.motor_joints}))
    (place,) = se.control(driven, damping=0.02).places
    assert place.growth < 0
    for axis in place.axes:
        assert axis.velocity.modulus > 0.49 and axis.position.modulus > 0.68


def test_loads_may_be_measured() -> None:
    """The position of the arm in place of the motor's: the same at rest, and closer to instability."""
    motor, arm = (
        se.control(drive(Kp=2.0, Kv=20.0, Tn=0.05, measured=name)).places[0].axes[0] for name in ("motor", "arm.rz")
    )
    assert arm.position.gain < motor.position.gain and arm.velocity == motor.velocity
    assert arm.velocity_error == pytest.approx(motor.velocity_error, abs=1e-9)


def test_points_of_bodies_and_joints_by_their_names_may_be_measured_and_pushed() -> None:
    """The origin of a frame as a point is the frame; a joint alone is its position, in its own unit."""
    found = [
        se.control(drive(Kp=2.0, Kv=20.0, Tn=0.05, measured=measured), compliances=[pushed]).places[0]
        for measured, pushed in (("arm.rz", "arm.q"), ("arm at (0, 0, 0).rz", "arm"))
    ]
    for place in found:
        (one,) = place.compliances
        assert one.unit == "rad/(N m)" and one.static == pytest.approx(found[0].compliances[0].static, rel=1e-12)
        assert place.axes[0].position == found[0].axes[0].position


def test_a_position_that_the_motor_does_not_move_is_refused() -> None:
    with pytest.raises(InputError, match=r"motor, measured: arm\.q does not move with motor here"):
        se.control(drive(Kp=2.0, Kv=20.0, measured="arm.q"))


@pytest.mark.parametrize(
    ("changes", "options", "place", "what"),
    [
        ({}, {}, "damping", "modes without damping: 1, the lowest at 42.11 Hz"),
        ({"current": {"lag": 0}, "dead_time": 0}, {"damping": 0.01}, "drives, motor, Kp", "nothing limits it"),
        ({"measured": "motor.qd"}, {"damping": 0.01}, "measured", "is no position"),
        ({"measured": "arm.zz"}, {"damping": 0.01}, "drives, motor, measured", "arm.zz"),
        ({"measured": "arm"}, {"damping": 0.01}, "drives, motor, measured", "arm does not move with motor"),
        ({"measured": "</script>"}, {"damping": 0.01}, "drives, motor, measured", "</script>"),
        ({}, {"damping": 0.01, "compliances": ["arm.wz"]}, "compliances", "is no position"),
        ({"period": 1e-4, "set_point": {"average": 10}}, {"damping": 0.01}, "set_point, average", "more than 4096"),
    ],
)
def test_what_has_no_meaning_is_refused(changes: Any, options: Any, place: str, what: str) -> None:
    machine = drive(**changes)
    machine["springs"]["arm"].pop("damping")
    with pytest.raises(InputError) as error:
        se.control(machine, tune=True, **options)
    assert place in error.value.place and what in str(error.value)


def test_a_machine_without_drives_says_how_to_write_them() -> None:
    with pytest.raises(InputError, match=r"drives: no motor has one: write motor = \{ Kv = \"tuned\""):
        se.control({**drive(), "drives": {}})


def test_an_integral_part_leaves_no_compliance_at_rest_and_a_plane_none_across() -> None:
    """One that is computed as rounding is zero; a peak of zero is at no frequency."""
    gravity = {"gravity": [0, -9.81, 0]}
    arm = {
        "joints": [
            {"name": "arm", "kind": "motor", "sigma": 0, "theta": "q1"},
            {"name": "tip", "kind": "fixed", "d": 1},
        ]
    }
    body = {"bodies": {"arm": {"mass": 1, "center_of_mass": [0.5, 0, 0], "inertia": [0.1, 0.1, 0.1]}}}
    drives = {"drives": {"arm": {"Kv": 10, "Kp": 2, "Tn": 0.05, "dead_time": 1e-4}}}
    of = ["tip.y", "tip.z"]
    y, z = se.control(gravity | arm | body | drives, compliances=of).places[0].compliances
    assert y.static == 0 < y.peak and z.static == z.peak == 0 and np.isnan(z.frequency)
    swept = se.sweep(gravity | arm | body | drives, over={"arm.mass": [1, 2]}, of="control", outputs=["tip.y"])
    assert swept.units["tip.y: peak"] == "m/N"


@pytest.mark.thorough
def test_tuned_axes_keep_their_margins_after_all_others_are_closed(tmp_path: Path) -> None:
    """Limbs of a Delta share their platform: whoever is closed last takes room from the first."""
    path = tmp_path / "delta.toml"
    text = starting_text("delta", "delta")
    path.write_text(text.replace("damping = 20", "damping = 5"))
    (place,) = se.control(path).as_json()["places"]
    for axis in place["axes"]:
        assert axis["position_loop"]["modulus"] >= 0.7 * (1 - ABOVE), axis["motor"]
        assert axis["velocity_loop"]["modulus"] >= 0.5 * (1 - ABOVE), axis["motor"]


def test_only_gains_of_slides_are_in_metres() -> None:
    """1/s is 0.06 m/min/mm; a turn has no metres."""
    rows = [("slide", 1, "x"), ("turn", 0, "z")]
    joints = [{"name": name, "kind": "motor", "sigma": sigma, "axis": axis} for name, sigma, axis in rows]
    bodies = {"slide": {"mass": 20}, "turn": {"mass": 5, "inertia": [1, 1, 1]}}
    drives = {name: {"Kp": 900, "Kv": 50, "current": {"lag": 1e-4}} for name, *_ in rows}
    machine = {"name": "m", "gravity": [0, 0, 0], "joints": joints, "bodies": bodies, "drives": drives}
    gains = next(iter(se.control(machine).parts()))
    assert [row[-3:-1] for row in gains.rows] == [("50", "3"), ("50", "-")]
