"""The target linuxcnc: torques and kinematics on a bench, and what is refused."""

from __future__ import annotations

import ctypes
import math
import re
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.hal_function import LARGEST_FRAME, HalFunction
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.linuxcnc import DEGREE, MILLIMETRE, render_linuxcnc, unit_of
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from tests.codegen.test_local_names import arm
from tests.generated_code import compiled
from tests.linuxcnc import Array, Component, by_halcompile, by_own, needs_halcompile

ROOT = Path(__file__).parents[2]
Bench = Callable[[str, str, Path], Component]
BENCHES = [pytest.param(by_own), pytest.param(by_halcompile, marks=needs_halcompile)]
KINEMATIC = ("geometric_model", "inverse_geometric_model")


def example(name: str) -> Machine:
    return read_machine(ROOT / "examples" / name)[0]


def hostile() -> Machine:
    """Names of pins, of templates and of the library of C."""
    names = ("k", "way", "best", "y0", "j1", "T", "P", "branch", "found", "period", "wanted", "tried", "given_q")
    return arm(("b", "joint", "q1", "fperiod", "x"), names)


def valued(machine: Machine) -> Package:
    """The package of both kinematic models of a machine whose parameters all have values."""
    asked = programs(machine, Scene(models=KINEMATIC)).package
    given = (replace(p, value=0.45 if math.isnan(p.value) else p.value) for p in asked.parameters)
    return replace(asked, parameters=tuple(given))


TORQUES: dict[str, Callable[[], Machine]] = {
    "puma560_measured": lambda: example("puma560_measured.toml"),
    "two_axis": lambda: example("two_axis.toml"),
    "palletizer": lambda: example("palletizer.toml"),
    "pendant_arm": lambda: example("pendant_arm.urdf"),
    "arm": hostile,
}
ARMS = ("puma560_measured.toml", "rx90.par", "planar_2r.toml", "palletizer.toml")


@cache
def torques_of(name: str) -> Package:
    return programs(TORQUES[name](), Scene(models=("inverse_dynamics",))).package


@cache
def kinematics_of(name: str) -> Package:
    return valued(example(name))


def kinematics(name: str, bench: Bench, folder: Path) -> tuple[Component, list[bool]]:
    """The component, and which joints turn."""
    package = kinematics_of(name)
    (made,) = render_linuxcnc(package).values()
    turns = [unit_of(axis) == DEGREE for axis in package.axes]
    return bench(made, f"{package.name}_kins", folder), turns


@pytest.mark.parametrize("bench", BENCHES)
@pytest.mark.parametrize("name", ["arm", *(pytest.param(x, marks=pytest.mark.thorough) for x in TORQUES if x != "arm")])
def test_torques_have_the_bits_of_c(name: str, bench: Bench, tmp_path: Path) -> None:
    package = torques_of(name)
    (made,) = render_linuxcnc(package).values()
    component = bench(made, f"{package.name}_ff", tmp_path)
    units = np.array([unit_of(axis) for axis in package.axes])
    of_motors = np.array([unit_of(axis) for axis in package.driven or [package.axes[k] for k in package.motors]])
    rng = np.random.default_rng(3)
    count = 20 if bench is by_own else 10_000
    states = {"q": rng.uniform(-50, 50, (count, len(units))), "qd": rng.uniform(-90, 90, (count, len(units)))}
    states["qdd"] = rng.uniform(-400, 400, (count, len(of_motors)))
    found = component.torques(states, len(of_motors))
    for k in range(count):
        given = [states["q"][k] * units, states["qd"][k] * units, states["qdd"][k] * of_motors]
        assert np.array_equal(found[k], torques_in_c(name)(*given))


@cache
def torques_in_c(name: str) -> Callable[..., Array]:
    """The inverse dynamic model in C, without contraction and with the sines of its library."""
    package = torques_of(name)
    with tempfile.TemporaryDirectory() as name_of_folder:
        folder = Path(name_of_folder)
        for file, text in render_c(package).items():
            (folder / file).write_text(text)
        function = getattr(compiled(folder, folder, "cc", package.name), f"{package.name}_inverse_dynamics")
    function.restype = None
    p = np.array([parameter.value for parameter in package.parameters])
    lengths = [math.prod(result.shape) for result in package.functions[0].results]

    def call(*given: Array) -> Array:
        results = [np.full(n, np.nan) for n in lengths]
        function(*(x.ctypes.data_as(ctypes.c_void_p) for x in (*given, p, *results)))
        return results[[r.name for r in package.functions[0].results].index("tau")]

    return call


@pytest.mark.parametrize("bench", BENCHES)
@pytest.mark.parametrize("name", [ARMS[0], *(pytest.param(x, marks=pytest.mark.thorough) for x in ARMS[1:])])
def test_forward_of_inverse_is_the_pose(name: str, bench: Bench, tmp_path: Path) -> None:
    component, turns = kinematics(name, bench, tmp_path)
    rng = np.random.default_rng(4)
    count = 200 if bench is by_own else 10_000
    off = []
    for joint in rng.uniform(-150, 150, (count, len(turns))):
        pose = component.forward(joint)
        start = joint + rng.uniform(-3, 3, len(joint))
        assert component.inverse(pose, start)
        off.append(apart(component.forward(start), pose))
    assert max(off) <= 1e-12


def apart(found: Array, wanted: Array) -> float:
    """How far two poses are from each other: of the length of the position, or of the rotation matrix."""
    across = np.abs(found[:3] - wanted[:3]).max() / np.linalg.norm(wanted[:3])
    return max(float(across), float(np.abs(rotation(found) - rotation(wanted)).max()))


def rotation(pose: Array) -> Array:
    """R = Rz(c) Ry(b) Rx(a)."""
    (sa, ca), (sb, cb), (sc, cc) = ((math.sin(x), math.cos(x)) for x in np.radians(pose[3:6]))
    z = [[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]]
    y = [[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]]
    x = [[1, 0, 0], [0, ca, -sa], [0, sa, ca]]
    return np.array(z) @ np.array(y) @ np.array(x)


def test_poses_are_those_of_the_geometric_model(tmp_path: Path) -> None:
    component, _ = kinematics("puma560_measured.toml", by_own, tmp_path)
    package = kinematics_of("puma560_measured.toml")
    joint = np.array([10.0, -20.0, 30.0, 40.0, 50.0, 60.0])
    for file, text in render_c(package).items():
        (tmp_path / file).write_text(text)
    function = compiled(tmp_path, tmp_path, "cc", package.name).puma560_measured_geometric_model
    T, p = np.full((6, 4, 4), np.nan), np.array([parameter.value for parameter in package.parameters])
    function(*(x.ctypes.data_as(ctypes.c_void_p) for x in (joint * DEGREE, p, T)))
    pose = component.forward(joint)
    assert np.allclose(pose[:3], T[-1, :3, 3] / MILLIMETRE, rtol=1e-15, atol=1e-12)
    assert np.allclose(rotation(pose), T[-1, :3, :3], rtol=0, atol=1e-15)


def test_joints_stay_near_where_they_are_and_branches_are_chosen(tmp_path: Path) -> None:
    component, _ = kinematics("puma560_measured.toml", by_own, tmp_path)
    joint = np.array([170.0, -20.0, 30.0, 40.0, 50.0, 400.0])
    pose = component.forward(joint)
    near = joint + 2.0
    assert component.inverse(pose, near)
    assert np.abs(near - joint).max() < 1e-9
    reached = []
    for branch in range(8):
        component.branch(branch)
        start = np.zeros(6)
        assert component.inverse(pose, start)
        assert np.abs(component.forward(start) - pose).max() < 1e-9
        reached.append(tuple(start.round(6)))
    assert len({*reached}) == 8
    component.branch(8)
    assert not component.inverse(pose, np.zeros(6))


def test_out_of_reach_leaves_the_joints(tmp_path: Path) -> None:
    component, _ = kinematics("puma560_measured.toml", by_own, tmp_path)
    joint = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert not component.inverse(np.array([5000.0, 0, 0, 0, 0, 0]), joint)
    assert joint.tolist() == [1, 2, 3, 4, 5, 6]


def test_prismatic_joints_are_in_millimetres_and_positions_suffice(tmp_path: Path) -> None:
    machine = example("planar_2r.toml")
    package = programs(machine, Scene(models=("geometric_model", "inverse_position_model"))).package
    (made,) = render_linuxcnc(package).values()
    component = by_own(made, "planar_2r_kins", tmp_path)
    joint = np.array([30.0, 40.0])
    pose, start = component.forward(joint), joint + 1.0
    assert component.inverse(pose, start)
    assert np.abs(component.forward(start) - pose)[:3].max() <= 1e-12 * np.abs(pose).max()
    axes = torques_of("two_axis").axes
    assert [unit_of(axis) for axis in axes[:2]] == [DEGREE, MILLIMETRE]
    (feed_forward,) = render_linuxcnc(torques_of("two_axis")).values()
    assert "unit_of_qdd[2] = {0.001, 0.001};" in feed_forward


def test_where_b_is_a_right_angle_only_one_other_angle_is_free(tmp_path: Path) -> None:
    component, _ = kinematics("puma560_measured.toml", by_own, tmp_path)
    pose = np.array([300.0, 200.0, 100.0, 0.0, 90.0, 25.0])
    joint = np.zeros(6)
    assert component.inverse(pose, joint)
    assert np.abs(rotation(component.forward(joint)) - rotation(pose)).max() < 1e-9


def test_large_models_are_out_of_the_stack() -> None:
    package = torques_of("arm")
    model = HalFunction(package, package.functions[0])
    (made,) = render_linuxcnc(package).values()
    assert model.is_static and 8 * len(model.variables) > LARGEST_FRAME
    assert "static double" in made
    small = programs(example("planar_2r.toml"), Scene(models=("inverse_dynamics",))).package
    (of_small,) = render_linuxcnc(small).values()
    assert "static double" not in of_small


def test_pins_are_those_of_the_model() -> None:
    (made,) = render_linuxcnc(torques_of("two_axis")).values()
    pins = re.findall(r"^pin (.*?) \"", made, re.MULTILINE)
    assert pins == ["in float q#[12]", "in float qd#[12]", "in float qdd#[2]", "out float tau#[2]"]
    assert made.startswith("component two_axis_ff ")
    assert "function _ fp" in made and "option singleton yes;" in made
    (of_arm,) = render_linuxcnc(kinematics_of("rx90.par")).values()
    assert re.findall(r"^pin (.*?) \"", of_arm, re.MULTILINE) == ["in s32 branch = -1"]
    assert "R = Rz(c) Ry(b) Rx(a)" in of_arm


def test_users_words_stay_words() -> None:
    odd = replace(torques_of("two_axis"), source='a""" \\ */ b.toml', options=('"""; pin in bit x;',))
    (made,) = render_linuxcnc(odd).values()
    assert made.count('"""') == 2
    assert "\\" not in made.partition(";;")[0]


@pytest.mark.parametrize(
    ("machine", "scene", "message"),
    [
        ("two_axis.toml", Scene(models=("direct_dynamics",)), "needs inverse_dynamics, control, or geometric_model"),
        (
            "rx90.par",
            Scene(models=("inverse_dynamics",)),
            r"ZZ1 has no value \(\d+ more as well\): give it one in the file",
        ),
        ("sr400.par", Scene(models=KINEMATIC), "do not move pin_end, have no place in kinematics: lock them"),
    ],
)
def test_what_no_component_can_do_is_refused(machine: str, scene: Scene, message: str) -> None:
    package = programs(example(machine), scene).package
    if message.startswith("do"):
        package = replace(package, parameters=tuple(replace(p, value=1.0) for p in package.parameters))
    with pytest.raises(InputError, match=rf"^{machine}: --target linuxcnc.*{message}"):
        render_linuxcnc(package)


def test_machines_without_a_closed_form_are_refused_with_the_reason() -> None:
    with pytest.raises(InputError, match=r"the joint is elastic: forces, not geometry, set where it stands"):
        programs(example("two_axis.toml"), Scene(models=KINEMATIC))


def test_long_names_are_refused() -> None:
    with pytest.raises(InputError, match=r"too long for names of pins: at most 24 characters"):
        render_linuxcnc(replace(torques_of("two_axis"), name="a" * 25))


@pytest.mark.sampled(5)
@pytest.mark.parametrize("bench", BENCHES)
@pytest.mark.parametrize("states", [True, False])
def test_controllers_have_the_bits_of_c(states: bool, bench: Bench, tmp_path: Path) -> None:
    """They begin when they are enabled, keep their states, begin anew after a stop; pins in degrees."""
    from tests.references.controlled import PLAIN, controlled, drive

    one = drive() if states else PLAIN
    package = programs(controlled(motor=one), Scene(models=("control", "control_start"))).package
    (made,) = render_linuxcnc(package).values()
    component = bench(made, f"{package.name}_control", tmp_path)
    for file, text in render_c(package).items():
        (tmp_path / file).write_text(text)
    library, motors = compiled(tmp_path, tmp_path, "cc", package.name), len(package.motor_names)
    sizes = {a.name: a.size for a in package.functions[0].arguments}
    rng, zc, k = np.random.default_rng(9), np.zeros(max(sizes.get("zc", 0), 1)), 0
    names = ("measured", "speed", "r", "rd", "rdd", "tau")
    units = {name: 1.0 if name == "tau" else DEGREE for name in names}
    p = np.array([parameter.value for parameter in package.parameters])

    def call(model: str, given: list[Array], found: list[Array]) -> None:
        arrays = [*given, p, *found]
        getattr(library, f"{package.name}_{model}")(*(x.ctypes.data_as(ctypes.c_void_p) for x in arrays))

    for k in range(40):
        enable = k not in (0, 17)
        given = {name: rng.uniform(-30, 30, motors) for name in names}
        found = component.controlled(enable, given, motors)
        if not enable:
            assert (found == 0).all()
            continue
        si = {name: x * units[name] for name, x in given.items()}
        if k in (1, 18) and states:
            call("control_start", [si[name] for name in ("r", "rd", "rdd", "tau")], [zc])
        u, later = np.zeros(motors), np.zeros_like(zc)
        call("control", [*si.values(), zc], [u, later])
        zc = later
        assert np.array_equal(found, u)
