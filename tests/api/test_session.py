"""A session in Python: machines, models and analyses by public names, against what the rooms compute."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats import read_machine
from tests.golden import ROOT

PLANAR = str(ROOT / "examples" / "planar_2r.toml")
TWO_AXIS = str(ROOT / "examples" / "two_axis.toml")
SCENE = str(ROOT / "examples" / "scenes" / "two_axis_move.toml")

PENDULUM: dict[str, Any] = {
    "name": "pendulum",
    "gravity": (0.0, 0.0, -9.81),
    "joints": [{"name": "swing", "kind": "motor", "sigma": 0, "alpha": "pi/2", "d": 0, "theta": "q1", "r": 0}],
    "bodies": {"swing": {"mass": 2.0, "center_of_mass": np.array([0.5, 0.0, 0.0])}},
}


@pytest.fixture(scope="module")
def two_axis() -> Any:
    return se.read(TWO_AXIS)


def test_machines_are_files_tables_or_machines(tmp_path: Path) -> None:
    """m l^2 of a pendulum, and its weight."""
    for machine in (PENDULUM, se.read(PENDULUM), se.write(PENDULUM, tmp_path / "pendulum.toml")):
        model = se.load(machine, "inertia_matrix", "bias_forces")
        assert model.inertia_matrix([0.3]) == pytest.approx(2.0 * 0.25, rel=1e-15)
        assert model.bias_forces([0.0], [0.0]) == pytest.approx(2.0 * 9.81 * 0.5, rel=1e-15)


def test_tables_of_python_are_refused_as_files_are() -> None:
    wrong = {**PENDULUM, "bodies": {"swing": {"mass": "two"}}}
    with pytest.raises(se.InputError, match=r"^machine: joint 1 \(swing\), mass: "):
        se.read(wrong)
    with pytest.raises(se.InputError, match="set is not a value of a table"):
        se.read({**PENDULUM, "notes": {"a", "b"}})


def test_what_is_rarely_meant_is_a_warning() -> None:
    bent = {**PENDULUM, "joints": [{**PENDULUM["joints"][0], "alpha": 90.0}]}
    with pytest.warns(se.MachineWarning, match="degrees") as issued:
        se.read(bent)
    assert issued[0].filename == __file__


def test_files_are_kept_without_force(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    machine = se.new(path, "elastic")
    assert machine.name == "mine"
    with pytest.raises(se.InputError, match="exists"):
        se.new(path, "elastic")
    with pytest.raises(se.InputError, match="exists"):
        se.write(machine, path)
    assert se.write(machine, path, force=True) == path


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_loaded_models_are_the_generated_ones(backend: str) -> None:
    """By position and by name, stacked, with parameters; the constants of the package."""
    from generated import planar_2r

    model = se.load(PLANAR, "direct_dynamics", backend=backend)
    rng = np.random.default_rng(1)
    q, qd, tau = rng.normal(size=(3, 5, 2))
    p = planar_2r.parameters(m1=3.0)
    assert model.JOINTS == planar_2r.JOINTS
    np.testing.assert_array_equal(model.parameters(m1=3.0), p)
    expected = planar_2r.direct_dynamics(q, qd, tau, p)
    np.testing.assert_allclose(model.direct_dynamics(q, qd, tau, p), expected, rtol=1e-14)
    np.testing.assert_allclose(model.direct_dynamics(q=q, qd=qd, tau=tau, p=p), expected, rtol=1e-14)
    assert "Direct dynamic model" in (model.direct_dynamics.__doc__ or "")
    assert repr(model) == "<Model of planar_2r: direct_dynamics; 2 coordinates>"
    with pytest.raises(AttributeError, match="planar_2r has no 'inertia_matrix': it was loaded with direct_dynamics"):
        _ = model.inertia_matrix
    with pytest.raises((ValueError, TypeError)):
        model.direct_dynamics(q[..., :1], qd, tau)


def test_time_steps_are_loaded() -> None:
    """A step of RK4 as in the textbook, of the loaded direct model."""
    model = se.load(PLANAR, "direct_dynamics", steps=["rk4"])
    q, qd, tau, h = np.array([0.3, -0.2]), np.array([1.0, 2.0]), np.array([0.5, 0.1]), 1e-2

    def f(x: Any) -> Any:
        return np.concatenate([x[2:], model.direct_dynamics(x[:2], x[2:], tau)])

    x = np.concatenate([q, qd])
    k1 = f(x)
    k2 = f(x + h / 2 * k1)
    k3 = f(x + h / 2 * k2)
    expected = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(x + h * k3))
    found = model.step_rk4(tau=np.tile(tau, (3, 1)), h=h, q=q, qd=qd)
    np.testing.assert_allclose(np.concatenate(found), expected, rtol=1e-14)


@pytest.mark.thorough
def test_generate_writes_what_the_command_writes(tmp_path: Path) -> None:
    made = se.generate(PLANAR, "inertia_matrix", out=tmp_path, targets="numpy")
    assert made.written[0].name == "__init__.py"
    assert made.to_frame().to_dict("records") == [{"model": "inertia_matrix", "products": 3, "sums": 5, "sincos": 1}]


def test_analyses_take_the_operating_point_by_name(two_axis: Any) -> None:
    pytest.importorskip("scipy")
    found = se.modes(two_axis, hold="all")  # type: ignore[typeddict-item]
    from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
    from symoro_elastic.analysis.vibration.modes import modes
    from symoro_elastic.numerics.motion.equations_of_motion import motion_of
    from symoro_elastic.numerics.motion.equilibrium import equilibrium

    motion = motion_of(read_machine(TWO_AXIS)[0], {})
    linear = linearize(motion, equilibrium(motion, {}, {}))
    expected = modes(with_motors(linear, ["motor_x", "motor_y"], {}))
    np.testing.assert_array_equal(found.frequencies, expected.frequencies)
    frame = found.to_frame()
    np.testing.assert_array_equal(frame["frequency"], expected.frequencies)
    shares = frame[[name for name in frame if name.startswith("strain in ")]]
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, rtol=1e-9)
    assert repr(found).startswith("<Modes of two_axis: 10, first 26.24 Hz")
    assert json.loads(json.dumps(found.as_json()))["frequencies"] == expected.frequencies.tolist()


def test_responses_have_poles_and_zeros(two_axis: Any) -> None:
    pytest.importorskip("scipy")
    found = se.response(two_axis, inputs=["motor_x.tau"], outputs=["motor_x.q"], frequencies=[1.0, 10.0])
    assert found.values.shape == (2, 1, 1)
    assert len(found.transfers) == 1
    linear = se.linearize(two_axis, inputs=["motor_x.tau"], outputs=["motor_x.q"])
    s = 2j * np.pi * 10.0
    space = linear.space
    G = space.C @ np.linalg.solve(s * np.eye(len(space.A)) - space.A, space.B) + space.D
    assert found.values[1, 0, 0] == pytest.approx(G[0, 0], rel=1e-6)


def test_wrong_arguments_are_named_as_arguments(two_axis: Any) -> None:
    pytest.importorskip("scipy")
    with pytest.raises(se.InputError, match=r"^symoro_elastic: rates: an equilibrium is at rest: add as_given"):
        se.linearize(two_axis, rates={"motor_x": 1.0})
    with pytest.raises(
        se.InputError, match=r"^symoro_elastic: backend: unknown backend 'matlab': choose from numpy, c"
    ):
        se.load(two_axis, backend="matlab")
    with pytest.raises(se.InputError, match=r"targets: unknown 'fortran'"):
        se.generate(two_axis, targets="fortran")
    with pytest.raises(se.InputError, match=r"^symoro_elastic: at: \[0, 1\] gives no numbers by name"):
        se.modes(two_axis, at=[0, 1])  # type: ignore[typeddict-item]
    with pytest.raises(se.InputError, match=r"at: 'motor_x': 'a' is not a number"):
        se.modes(two_axis, at={"motor_x": "a"})  # type: ignore[typeddict-item]
    with pytest.raises(se.InputError, match=r"machine: int is not a machine"):
        se.read(3)
    with pytest.raises(se.InputError, match=r"elastic: \['elbow'\] gives no stiffness"):
        se.read(ROOT / "examples" / "pendant_arm.urdf", elastic=["elbow"])  # type: ignore[arg-type]
    with pytest.raises(se.InputError, match=r"position: 1.0 is not a range"):
        se.excite(two_axis, 1.0, 1.0, 1.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="att"):
        se.modes(two_axis, att={})  # type: ignore[call-arg]


@pytest.mark.thorough
def test_scenes_are_files_or_tables(two_axis: Any) -> None:
    """The same motion, whether its scene is a file or dictionaries of Python."""
    pytest.importorskip("scipy")
    import tomllib

    tables = tomllib.loads(Path(SCENE).read_text(encoding="utf-8"))
    (from_file,) = se.simulate(two_axis, SCENE, method="w2", step=1e-3)
    (from_tables,) = se.simulate(two_axis, tables, method="w2", step=1e-3)
    np.testing.assert_array_equal(from_file.motion.q, from_tables.motion.q)
    assert from_file.to_frame().shape[0] == from_file.trajectory.steps + 1


def test_equations_are_shown_and_written(tmp_path: Path) -> None:
    found = se.equations(PLANAR, "inertia_matrix")
    assert found._repr_html_().startswith("<iframe srcdoc=") and "<style>" not in found._repr_html_()
    assert found._repr_latex_().count(r"A_{2,2} &=") == 1
    assert found.write(tmp_path / "a.tex").read_text(encoding="utf-8") == found.latex
    with pytest.raises(se.InputError, match=r"with \.tex, \.html, \.htm or \.pdf"):
        found.write(tmp_path / "a.doc")


def test_notebooks_show_no_markup_of_files() -> None:
    machine = se.read({**PENDULUM, "notes": ["<script>alert(1)</script>"]})
    page = machine._repr_html_()
    assert "<script" not in page
    assert "<table" in page
    assert len(repr(machine)) < 100


@pytest.mark.thorough
def test_without_pandas_the_message_says_what_to_install(two_axis: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(se.InputError, match=r"pip install 'symoro-elastic\[notebook\]'"):
        se.check(PLANAR, "inertia_matrix").to_frame()


@pytest.mark.thorough
def test_motors_on_joints_that_follow_from_loops_have_names_only() -> None:
    delta = se.load(Path(__file__).parents[1] / "closed_chains" / "machines" / "delta.toml", "inertia_matrix")
    assert delta.MOTOR_NAMES == ("arm_1", "arm_2", "arm_3")
    with pytest.raises(AttributeError, match=r"delta has no 'MOTORS': tau follows MOTOR_NAMES \(arm_1, arm_2, arm_3\)"):
        _ = delta.MOTORS


def test_array_libraries_are_given_as_modules() -> None:
    with pytest.raises(se.InputError, match=r"unknown backend 'torch': choose from numpy, .*, or give the module"):
        se.load({"name": "m", "joints": []}, backend="torch")
