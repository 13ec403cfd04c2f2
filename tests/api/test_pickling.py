"""Results, machines and models can be pickled, so that processes and Dask map them; one of each class goes through."""

from __future__ import annotations

import copy
import gc
import importlib
import pickle
import pkgutil
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import fields, is_dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.ladder.rung import Budget, Expense, MeasuredEnd, PathStep, Rung, Steps
from symoro_elastic.analysis.trade_off.guaranteed import GuaranteedCurve, GuaranteedPoint
from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.api.options import Oscillating
from symoro_elastic.api.vibrations import modes_along
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.results import Result, Shown
from symoro_elastic.generation.pipeline import verify_by_itself
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.within import Evidence
from symoro_elastic.measured.vibration_tests.measured import MeasuredResponse, VibrationTest
from symoro_elastic.models.kinematics.inverse_geometric import InverseRefused
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.numerics.within.budget import Error
from symoro_elastic.symbolic.program import OperationCount
from tests.golden import ROOT

pytest.importorskip("scipy")

PLANAR = str(ROOT / "examples" / "planar_2r.toml")
BALL_SCREW = str(ROOT / "examples" / "ball_screw.toml")
PENDULUM: dict[str, Any] = {
    "name": "pendulum",
    "gravity": (0.0, 0.0, -9.81),
    "joints": [{"name": "swing", "kind": "motor", "sigma": 0, "alpha": "pi/2", "d": 0, "theta": "q1", "r": 0}],
    "bodies": {"swing": {"mass": 2.0, "center_of_mass": [0.5, 0.0, 0.0]}},
}
DRIVE: dict[str, Any] = {
    "name": "drive",
    "joints": [
        {"name": "motor", "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "arm", "antecedent": "motor", "kind": "elastic", "sigma": 0, "theta": "q2"},
        {"name": "tool", "antecedent": "arm", "kind": "fixed", "sigma": 2, "d": 0.5},
    ],
    "bodies": {
        "motor": {"mass": 1.0, "inertia": [0.01, 0.01, 0.02]},
        "arm": {"mass": 2.0, "center_of_mass": [0.25, 0.0, 0.0], "inertia": [0.01, 0.04, 0.04]},
    },
    "motors": {"motor": {"rotor_inertia": 0.1}},
    "springs": {"arm": {"stiffness": 1000.0}},
}
SCENE: dict[str, Any] = {
    "motion": {
        "duration": 0.5,
        "moves": [{"motor": "motor", "by": 0.1, "in": 0.3}],
        "servo": {"motor": {"bandwidth": 5, "damping": 0.8}},
    },
    "wanted": {"tolerance": 1e-4, "outputs": ["tool.y"]},
}


def _excited() -> Any:
    limits = (-1.0, 1.0), 2.0, 5.0
    few: dict[str, Any] = {"fundamental": 1.0, "harmonics": 2, "periods": 2, "sample_rate": 200.0, "evaluations": 5}
    return se.excite(PENDULUM, *limits, **few)


def _identified() -> Any:
    motion = _excited().arrays()
    tau = 0.5 * motion["qdd_swing"] + 9.81 * np.cos(motion["q_swing"])
    return se.identify(PENDULUM, {"t": motion["t"], "q_swing": motion["q_swing"], "tau_swing": tau})


def _budget() -> Budget:
    machine, errors = read_machine(PLANAR)[0], {"tip.x": 1e-5}
    steps = Steps("w2", 10, errors, 120)
    first = PathStep(Expense.WHOLE, (), errors, errors, Rung((), False, {"tip.x": 0.0}, steps))
    return Budget(machine, {"tip.x": 1e-4}, (first,), MeasuredEnd(errors, errors, 1e-6, 1e-6), steps, None)


def _curve() -> GuaranteedCurve:
    part = Error(0.1, Evidence.PROVEN)
    one = GuaranteedPoint("recursion", "single", 0.3, 2, OperationCount(3, 4), part, part, 0.05, 7.0)
    return GuaranteedCurve("direct_dynamics", "1 %", (one,), (0,))


def _generated(folder: Path) -> Any:
    return se.generate(PENDULUM, "inertia_matrix", out=folder, report=True)


MADE: dict[str, Callable[[Path], Any]] = {
    "Budget": lambda _: _budget(),
    "Comparison": lambda _: se.compare(DRIVE),
    "CodeReport": lambda folder: _generated(folder).reports[0],
    "Control": lambda _: se.control(BALL_SCREW, damping=0.01),
    "DescribedMachine": lambda _: se.read(PLANAR),
    "Equations": lambda _: se.equations(PENDULUM, "inertia_matrix"),
    "Evaluation": lambda _: se.evaluate(DRIVE, "inverse_dynamics", at={"motor": 0.1}),
    "ExcitingTrajectory": lambda _: _excited(),
    "FlexibleModes": lambda _: se.flexible(ROOT / "examples" / "bracket.npz"),
    "FlexibleParts": lambda _: se.flexible_parts(ROOT / "examples" / "flexible_two_link.toml"),
    "FrameStiffness": lambda _: se.stiffness(DRIVE, frame="tool"),
    "FeedForward": lambda _: se.feed_forward(DRIVE),
    "Generated": _generated,
    "GuaranteedCurve": lambda _: _curve(),
    "Identification": lambda _: _identified().found,
    "Identified": lambda _: _identified(),
    "InverseGeometry": lambda _: se.ik(PENDULUM, position=(0.0, 0.0, 0.0)),
    "Ladder": lambda _: se.ladder(DRIVE, SCENE),
    "Certificate": lambda _: se.certify(PLANAR, "inertia_matrix").certificates[0],
    "Certificates": lambda _: se.certify(PLANAR, "inertia_matrix"),
    "Linearization": lambda _: se.linearize(DRIVE, hold=["all"]),
    "LoadedModel": lambda _: se.load(PENDULUM, "inertia_matrix"),
    "Machine": lambda _: read_machine(PLANAR)[0],
    "MachinePage": lambda _: se.view(PLANAR),
    "MachinePicture": lambda _: se.picture(PLANAR),
    "Lobes": lambda _: se.lobes(BALL_SCREW, direction="table.x", cutting=2e9, damping=0.02, speeds=(1000, 2000, 2)),
    "Modes": lambda _: se.modes(DRIVE, hold=["all"]),
    "Reduced": lambda _: se.reduce(DRIVE, SCENE, for_="simulation"),
    "ReducedModel": lambda folder: se.generate(PLANAR, "inverse_dynamics", within="20 %", out=folder).reduced[0],
    "Report": lambda _: se.report(PENDULUM),
    "Response": lambda _: se.response(DRIVE, inputs=["motor.tau"], outputs=["motor.q"]),
    "SelfCheck": lambda _: verify_by_itself(read_machine(PLANAR)[0], Scene(models=("inertia_matrix",))),
    "Simulation": lambda _: se.simulate(DRIVE, SCENE, method="w2", step=1e-3)[0],
    "Simulations": lambda _: se.simulate(DRIVE, SCENE, method="w2", step=1e-3),
    "Singularities": lambda _: se.singularities(PLANAR, components=["tip.x", "tip.y"]),
    "StiffnessMap": lambda _: se.stiffness(DRIVE, frame="tool", along={"motor": [0.0, 0.5]}),
    "Sweep": lambda _: se.sweep(DRIVE, over={"arm.stiffness": [900.0, 1000.0]}, hold=["all"]),
    "Tracked": lambda _: modes_along(DRIVE, {"motor": [0.0, 0.1]}, Oscillating(hold=("all",))),
    "Trade": lambda _: se.benchmark(PENDULUM, effort="quick", states=4),
    "Updated": lambda _: _updated(),
    "Verification": lambda _: se.check(PENDULUM, "inertia_matrix"),
}
"""How to make one of each class that is shown, by its name."""
LONG = ("Trade", "Ladder", "Simulation", "Simulations", "Report")


def _updated() -> Result:
    answer = se.response(DRIVE, inputs=["motor.tau"], outputs=["motor.qdd"], band=(0.5, 50, 40), damping=0.02)
    measured = MeasuredResponse("motor.qdd", "motor.tau", answer.frequencies, answer.values[:, 0, 0])
    return se.update(DRIVE, [VibrationTest("sweep", {}, responses=(measured,))])


def classes(kind: type) -> Iterator[type]:
    for each in kind.__subclasses__():
        yield each
        yield from classes(each)


def import_all() -> None:
    """Import every module of the package, so that all classes are known."""
    for module in pkgutil.walk_packages(se.__path__, "symoro_elastic."):
        if not module.name.endswith((".__main__", ".casadi_functions")):
            importlib.import_module(module.name)


@pytest.mark.thorough
def test_every_class_that_is_shown_is_pickled_here() -> None:
    import_all()
    own = {each.__name__ for each in classes(Shown) if each.__module__.startswith("symoro_elastic.")}
    assert own - {Result.__name__} == set(MADE)


def alike(one: Any, other: Any) -> bool:
    """Whether two values hold the same numbers and texts, in results of one class."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.shape == other.shape and bool(np.array_equal(one, other, equal_nan=one.dtype.kind in "fc"))
    if isinstance(one, dict):
        return [*one] == [*other] and all(alike(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    if is_dataclass(one):
        return all(alike(getattr(one, x.name), getattr(other, x.name)) for x in fields(one))
    return True if type(one).__eq__ is object.__eq__ else one == other or repr(one) == repr(other) == "nan"


@pytest.mark.sampled(16)
@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.thorough] if name in LONG else [])
    for name in MADE
])  # fmt: skip
def test_one_of_each_class_is_the_same_after_a_pickle(name: str, tmp_path: Path) -> None:
    made = MADE[name](tmp_path)
    assert name in [each.__name__ for each in type(made).__mro__]
    again = pickle.loads(pickle.dumps(made))
    assert alike(made, again) and repr(again) == repr(made)
    if isinstance(made, Result) and made.as_json.__func__ is Result.as_json:
        assert alike(made.as_json(), again.as_json())


def test_equations_of_motion_go_on_after_a_pickle() -> None:
    """They are traced anew: another linearization of theirs is the one that was pickled."""
    made = se.linearize(DRIVE, values={})
    motion = pickle.loads(pickle.dumps(made)).motion
    again = linearize(motion, equilibrium(motion, {}, {}))
    for name in ("M", "D", "K", "F"):
        np.testing.assert_array_equal(getattr(again, name), getattr(made, name))


def test_errors_cross_processes_whole() -> None:
    error = pickle.loads(pickle.dumps(se.InputError("a.toml", "joint 1", "is wrong: mend it")))
    machine = read_machine(PLANAR)[0]
    refused = pickle.loads(pickle.dumps(InverseRefused(machine, 1, "is one: give another")))
    assert type(refused) is InverseRefused and refused.joint == 1 and str(refused).endswith("is one: give another")
    assert (str(error), error.file, error.what) == ("a.toml: joint 1: is wrong: mend it", "a.toml", "is wrong: mend it")


def _torques(given: tuple[Any, float]) -> list[float]:
    model, x = given
    found: list[float] = np.asarray(model.inverse_dynamics([x, 0.2], [0.1, x], [0.3, 0.4])).tolist()
    return found


@pytest.mark.thorough
@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_processes_map_a_model(backend: str) -> None:
    model = se.load(PLANAR, "inverse_dynamics", backend=backend)
    given = [(model, x) for x in (0.1, 0.5, 0.9)]
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        assert list(pool.map(_torques, given)) == [*map(_torques, given)]


@pytest.mark.thorough
@pytest.mark.parametrize("backend", ["numpy", "c", "casadi", "jax", "sympy"])
@pytest.mark.filterwarnings("ignore:JAX computes in single precision")
def test_models_are_loaded_anew_from_pickles(backend: Any) -> None:
    if isinstance(backend, str) and backend in ("casadi", "jax"):
        pytest.importorskip(backend)
    model = se.load(PLANAR, "inertia_matrix", backend=backend)
    again = pickle.loads(pickle.dumps(model))
    assert again.functions == model.functions and again.JOINTS == model.JOINTS
    found, other = (each.inertia_matrix([0.1, 0.5]) for each in (model, again))
    np.testing.assert_array_equal(np.asarray(found, dtype=object), np.asarray(other, dtype=object))


def test_a_model_on_an_array_library_is_pickled_by_its_module() -> None:
    strict = pytest.importorskip("array_api_strict")
    again = pickle.loads(pickle.dumps(se.load(PENDULUM, "inertia_matrix", backend=strict)))
    assert float(again.inertia_matrix(strict.asarray([0.1]))[0, 0]) == pytest.approx(0.5, rel=1e-15)


@pytest.mark.thorough
def test_a_copy_is_a_model_of_its_own() -> None:
    model = se.load(PENDULUM, "inertia_matrix", backend="c")
    other = copy.copy(model)
    model.close()
    assert other.inertia_matrix([0.1]) == pytest.approx(0.5, rel=1e-15)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("backend", ["numpy", "c", "sympy"])
def test_a_model_is_closed_by_its_block(backend: str) -> None:
    with se.load(PENDULUM, "inertia_matrix", backend=backend) as model:
        held = model.inertia_matrix
        assert model.functions == ("inertia_matrix",)
    model.close()
    with pytest.raises(ValueError, match="the model of pendulum is closed: load it again"):
        model.inertia_matrix([0.1])
    if backend == "c":
        with pytest.raises(ValueError, match="the model of pendulum is closed: load it again"):
            held([0.1])
    assert repr(model).startswith("<Model of pendulum") and model.JOINTS == ("swing",)


@pytest.mark.thorough
@pytest.mark.skipif(not Path("/proc/self/maps").exists(), reason="the memory maps of a process are read there")
def test_libraries_leave_no_maps_behind() -> None:
    """Those that are closed, and those that nothing holds any more."""

    def maps() -> int:
        gc.collect()
        return sum("pendulum" in line for line in Path("/proc/self/maps").read_text().splitlines())

    before = maps()
    models = [se.load(PENDULUM, "inertia_matrix", backend="c") for _ in range(3)]
    assert maps() > before
    models[0].close()
    function = models[1].inertia_matrix
    models.clear()
    assert function([0.1]) == pytest.approx(0.5, rel=1e-15)
    assert maps() > before
    del function
    assert maps() == before
