"""Models within a tolerance: errors are never above what is said, and what is lost is said."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.trade_off.guaranteed import curves_of, grids_of
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.generation.reduced_models.search import reduced_models
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.joints import Wrench
from symoro_elastic.machine.machine import Base, Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.machine.within import GUARANTEES, Evidence, Keep, Within, tolerance
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import box_of
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.numerics.within.structure import STATES, _Inverse, lost_structure
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import Operand
from tests.closed_chains.machines import machine as closed_machine
from tests.command_line import refused, run
from tests.numerics.guarantees.boxes import limits_of_test
from tests.references.random_machines import chain, random_machine

EXAMPLES = Path(__file__).parents[2] / "examples"
PLANAR = EXAMPLES / "planar_2r.toml"
FLOATS = arithmetic(np.float64)


def limited(machine: Machine) -> DescribedMachine:
    return replace(DescribedMachine.of(machine), limits=limits_of_test(machine, 0.4))


def within(text: str, **more: object) -> Within:
    return replace(Within({"": tolerance(text)}), **more)


def reduced(machine: DescribedMachine, model: str, asked: Within) -> ReducedModel:
    scene = Scene(models=(model,), within=asked)
    return reduced_models(machine, scene, programs, [ROUNDINGS["double"]])[1][0]


def worst_errors(one: ReducedModel, seed: int, states: int = 60_000) -> np.ndarray:
    """The largest error of each entry at states that no search has seen, and where climbing leads from the worst."""
    box, rng = one.certificates[0].box, np.random.default_rng(seed)
    pairs = [[x for o in p.outputs for x in o.entries] for p in (one.reduction.program, one.reduction.reduced)]

    def errors(at: Mapping[str, np.ndarray]) -> np.ndarray:
        count = len(next(iter(at.values())))
        whole, left = (evaluate(roots, at, FLOATS) for roots in pairs)
        found = [whole(x) - left(y) for x, y in zip(*pairs, strict=True)]
        return np.array([np.broadcast_to(np.abs(x), count) for x in found])

    at = box.states(states, rng)
    found = errors(at)
    worst = found.max(axis=1)
    here = {name: x[found.argmax(axis=1)] for name, x in at.items()}
    for step in np.geomspace(0.3, 1e-3, 30):
        moved = {}
        for name, x in here.items():
            low, high = box.ranges[name].low, box.ranges[name].high
            change = rng.normal(size=len(x)) * step * (high - low) * (rng.random(len(x)) < 0.4)
            moved[name] = np.clip(x + change, low, high)
        now = np.diagonal(errors(moved))
        better = now > worst
        worst = np.maximum(worst, errors(moved).max(axis=1))
        here = {name: np.where(better, moved[name], x) for name, x in here.items()}
    return worst


CASES = {
    "inverse of a planar arm": ("planar", "inverse_dynamics", "20 %"),
    "direct of a planar arm": ("planar", "direct_dynamics", "2 %"),
    "inverse of an elastic chain": ("chain", "inverse_dynamics", "0.5 %"),
    "inertia matrix of a tree": ("tree", "inertia_matrix", "1 %"),
}
MACHINES = {
    "planar": lambda: se.read(PLANAR),
    "chain": lambda: limited(chain(2, elastic=(2,), symbolic=False)),
    "tree": lambda: limited(random_machine(11, joints=5, kinds=("motor",))),
}


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("guaranteed", list(GUARANTEES))
def test_errors_are_never_above_what_is_said(case: str, guaranteed: Evidence) -> None:
    machine, model, text = CASES[case]
    one = reduced(MACHINES[machine](), model, within(text, guaranteed=guaranteed))
    worst = worst_errors(one, 5)
    allowed = {(error.output, error.index): error.tolerance for error in one.reduction.errors}
    places = [(o.name, k) for o in one.reduction.program.outputs for k in range(len(o.entries))]
    for entry, place, found in zip(one.certificates[0].entries, places, worst, strict=True):
        said = entry.error if guaranteed is Evidence.PROVEN else entry.likely
        assert found <= said, entry
        assert said <= allowed.get(place, 0) * 1.001 + 1e-12 or place not in allowed, entry
    whole, left = one.operations
    assert left < whole


@pytest.mark.thorough
def test_the_box_is_that_of_the_whole_model() -> None:
    """A variable that only left-out terms depend on is still limited: the guarantee is for its range."""
    one = reduced(se.read(PLANAR), "inverse_dynamics", within("60 %"))
    assert one.reduction.reduced.used < one.reduction.program.used
    assert one.reduction.program.used <= one.certificates[0].box.ranges.keys()


@pytest.mark.thorough
def test_tolerances_by_joint_and_result() -> None:
    asked = Within({"shoulder": tolerance("20 %"), "qdd": tolerance(1e-9)})
    one = reduced(se.read(PLANAR), "inverse_dynamics", asked)
    entries = {entry.entry: entry for entry in one.certificates[0].entries if entry.name == "tau"}
    assert entries["elbow"].likely < 1e-12
    assert 1e-6 < entries["shoulder"].likely <= 0.2 * entries["shoulder"].magnitude


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--within", "0"), "--within: 0 is not above zero"),
        (
            ("--within", "100%"),
            "--within: 100% would let a result be zero: give less than 100 %, or leave the result out",
        ),
        (("--within", "a%"), "--within: 'a' is a name"),
        (("--within", "taus=1%"), "--within: no result or joint is called 'taus'; did you mean 'tau'?"),
        (("--keep", "terms"), "--keep: belongs to a tolerance: add --within, or leave it out"),
        (("--within", "1%", "--keep", "all"), "--keep"),
        (("--within", "1%", "--within", "2%"), "--within: a tolerance for all is given twice: keep one"),
        (("--within", "1%", "--target", "fmu"), "an FMU has models of its own, which are whole"),
        (("--within", "1%", "--keep", "parameters"), "one model at a time"),
        (("--within", "1e-9", "--precision", "single"), "in single precision"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, arguments: tuple[str, ...], said: str) -> None:
    assert said in refused("generate", PLANAR, *arguments, "--out", tmp_path)
    assert not list(tmp_path.iterdir())


def test_steps_and_missing_values_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="time steps are those of the whole model"):
        se.generate(PLANAR, out=tmp_path, within="1 %", steps=["w3"])
    with pytest.raises(InputError, match="XX1 has no value"):
        se.generate(EXAMPLES / "rx90.par", out=tmp_path, within="1 %")


@pytest.mark.thorough
def test_the_scene_asks_for_it_and_the_code_says_it(tmp_path: Path) -> None:
    scene = {"models": ["inverse_dynamics"], "within": {"tau": "5 %"}}
    made = se.generate(PLANAR, out=tmp_path, scene=scene)
    text = (tmp_path / "planar_2r" / "planar_2r.h").read_text(encoding="utf-8")
    whole, left = made.reduced[0].operations
    assert left < whole
    for said in (f"{left} of {whole} operations", "the full model", "with 95% confidence", "in_box"):
        assert said in " ".join(text.replace("*", " ").split()), said
    data = json.loads(json.dumps(made.as_json()))
    assert data["reduced"]["inverse_dynamics"]["operations"] == {"whole": whole, "left": left}


@pytest.mark.thorough
def test_results_of_which_nothing_is_left_are_named(tmp_path: Path) -> None:
    """17 N m are the largest torque of the shoulder, 3.3 N m those of the elbow."""
    se.generate(PLANAR, "inverse_dynamics", out=tmp_path, within=18)
    text = (tmp_path / "planar_2r" / "planar_2r.h").read_text(encoding="utf-8")
    assert "Reduced to a constant: tau[shoulder], tau[elbow]." in " ".join(text.replace("*", " ").split())


@pytest.mark.thorough
def test_the_same_bytes_each_time(tmp_path: Path) -> None:
    for folder in "ab":
        run("generate", PLANAR, "--model", "inverse_dynamics", "--within", "5%", "--out", tmp_path / folder)
    first, second = ((tmp_path / folder / "planar_2r" / "planar_2r.c").read_bytes() for folder in "ab")
    assert first == second


def test_models_that_are_exact_stay_as_they_are(tmp_path: Path) -> None:
    se.generate(PLANAR, "inverse_dynamics", out=tmp_path / "whole", fold=[ALL])
    se.generate(PLANAR, "inverse_dynamics", out=tmp_path / "within", within=1e-13)
    name = "_inverse_dynamics.py"
    first, second = ((tmp_path / folder / "planar_2r" / name).read_text() for folder in ("whole", "within"))
    assert re.sub(r"_DIGEST = \d+", "", first) == re.sub(r"_DIGEST = \d+", "", second) != first


@pytest.mark.thorough
def test_lost_structure_is_measured() -> None:
    """Of the whole model nothing is lost; a term of the upper triangle alone is asymmetric, a dropped c has power."""
    one = reduced(se.read(PLANAR), "inverse_dynamics", within("30 %"))
    whole, box = one.reduction.program, one.certificates[0].box
    nothing = lost_structure(whole, whole, box)
    assert nothing and nothing.asymmetry < 1e-14 and nothing.power == 0
    assert one.lost
    assert one.lost.asymmetry > 1e-5 or one.lost.power > 1e-3


@pytest.mark.thorough
def test_nothing_is_said_of_structure_where_positions_are_not_those_of_motors() -> None:
    """The gantry moves with the yaw of its beam, four motors drive it: torques times velocities are no power."""
    gantry = closed_machine("gantry")
    assert not gantry.moves_by_motors and closed_machine("sr400").moves_by_motors
    machine = replace(DescribedMachine.of(gantry), limits=limits_of_test(gantry))
    one = reduced(machine, "inverse_dynamics", within("1 %"))
    assert one.reduction.left_out and one.lost is None


@pytest.mark.thorough
def test_the_balance_of_power_holds_for_whole_models() -> None:
    """qd' c = 1/2 qd' Ad qd where there is no friction."""
    machine = se.read(EXAMPLES / "puma560_measured.toml")
    program = programs(machine, Scene(models=("inverse_dynamics",))).package.functions[0].program
    inputs = {argument.name: argument.symbols for argument in program.inputs}
    box = box_of(machine, machine.limits, program.inputs, program.used)
    states = {name: np.zeros(STATES) for symbols in inputs.values() for name in symbols}
    states |= box.states(STATES, np.random.default_rng(3))
    model = _Inverse(program, inputs)
    assert np.abs(model.power_balance(states)).max() < 1e-7 * np.abs(model.power(states)).max()


@pytest.mark.thorough
def test_inertia_keeps_the_balance_of_power() -> None:
    """Terms of A and V are left out, all else follows: between whole parameters and single terms."""
    kept = {keep: reduced(se.read(PLANAR), "inverse_dynamics", within("20 %", keep=keep)) for keep in Keep}
    one = kept[Keep.INERTIA]
    assert one.reduction.left_out and one.lost and one.operations[1] < one.operations[0]
    assert one.lost.asymmetry < 1e-12 and one.lost.power < 1e-8 * one.lost.largest_power
    lost = kept[Keep.TERMS].lost
    assert lost and max(lost.asymmetry, lost.power / lost.largest_power) > 1e-4
    errors = worst_errors(one, 9, 20_000)
    for entry, found in zip(one.certificates[0].entries, errors, strict=True):
        assert found <= entry.likely
    assert "are derivatives of the reduced energies" in one.parts()[0]


@pytest.mark.thorough
def test_energies_may_depend_on_velocities_that_the_whole_model_does_not_need() -> None:
    """The inverse model does not have qd1, which cancels in it; the derivatives of its energies do."""
    machine = random_machine(101, joints=6)
    alone = tuple(replace(joint, wrench=Wrench()) for joint in machine.joints)
    machine = replace(machine, joints=alone, base=Base(machine.base.gravity))
    one = reduced(limited(machine), "inverse_dynamics", within("1 %", keep=Keep.INERTIA))
    more = one.reduction.reduced.used - one.reduction.program.used
    assert more and more <= one.certificates[0].box.ranges.keys()
    for entry, found in zip(one.certificates[0].entries, worst_errors(one, 3, 20_000), strict=True):
        assert found <= entry.likely


def test_derivatives_that_take_more_than_is_left_out_are_said() -> None:
    one = reduced(se.read(PLANAR), "inverse_dynamics", within("1 %", keep=Keep.INERTIA))
    assert one.operations[0] == one.operations[1] and not one.reduction.left_out
    assert one.reduction.reduced is one.reduction.program


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("file", "model", "said"),
    [
        ("planar_2r.toml", "inertia_matrix", "is kept of direct_dynamics and inverse_dynamics with all joints"),
        ("ball_screw.toml", "direct_dynamics", "is kept of trees on a fixed base"),
    ],
)
def test_inertia_is_kept_of_trees(file: str, model: str, said: str, tmp_path: Path) -> None:
    arguments = ("--model", model, "--within", "1%", "--keep", "inertia", "--out", tmp_path)
    assert said in refused("generate", EXAMPLES / file, *arguments)
    assert not list(tmp_path.iterdir())


@pytest.mark.thorough
def test_parameters_make_nothing_from_nothing() -> None:
    """qd' C = 1/2 qd' Ad qd of the machine with zeros, exactly: Ad by derivatives, to rounding of the largest power."""
    machine = se.read(EXAMPLES / "puma560_measured.toml", base=True)
    scene = Scene(models=("inverse_dynamics",), within=within("2 %", keep=Keep.PARAMETERS))
    traced, (one,) = reduced_models(machine, scene, programs, [ROUNDINGS["double"]])
    assert one.reduction.left_out and one.lost and one.lost.asymmetry <= 1e-14
    zero = traced.whole
    A, c = (
        programs(zero, Scene(models=(name,), fold=ALL)).package.functions[0].program
        for name in ("inertia_matrix", "coriolis_forces")
    )
    box = box_of(machine, machine.limits, one.reduction.program.inputs)
    states = box.states(2000, np.random.default_rng(4))
    q, qd = (next(x.symbols for x in c.inputs if x.name == name) for name in ("q", "qd"))
    entries = A.outputs[0].entries
    graph = A.nodes[0].graph
    rate = Differentiation(entries).along({graph.symbol(x): graph.symbol(y) for x, y in zip(q, qd, strict=True)})
    rates = [rate.of(x) for x in entries]

    def values(roots: Sequence[Operand]) -> np.ndarray:
        value = evaluate(roots, states, FLOATS)
        return np.array([np.broadcast_to(value(x), 2000) for x in roots], dtype=float)

    v, n = np.array([states[name] for name in qd]), len(qd)
    power = (v * values(c.outputs[0].entries)).sum(axis=0)
    balance = power - np.einsum("is,iks,ks->s", v, values(rates).reshape(n, n, -1), v) / 2
    motors = (v * values(one.reduction.program.outputs[0].entries)).sum(axis=0)
    assert np.abs(balance).max() <= 1e-12 * np.abs(motors).max()
    assert np.linalg.eigvalsh(values(entries).reshape(n, n, -1).transpose(2, 0, 1)).min() > 0


class Ended:
    """A user who ends the work when a stage begins for some time."""

    def __init__(self, stage: str, times: int) -> None:
        self.stage, self.left = stage, times

    def __call__(self, stage: str) -> None:
        if stage.startswith(self.stage):
            self.left -= 1
            if not self.left:
                raise KeyboardInterrupt


def ended_after(times: int, folder: Path) -> se.Generated | None:
    scene = {"models": ["inverse_dynamics"], "within": "60 %", "guaranteed": "proven"}
    return se.generate(PLANAR, out=folder, scene=scene, announce=Ended("leave out, search", times))


@pytest.mark.thorough
def test_a_search_that_is_ended_keeps_what_is_proven_or_writes_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="was ended before a model within the tolerance was reached"):
        ended_after(1, tmp_path)
    assert not list(tmp_path.iterdir())
    counted = Ended("leave out, search", -1)
    whole = se.generate(
        PLANAR, "inverse_dynamics", out=tmp_path / "a", within="60 %", guaranteed="proven", announce=counted
    )
    searches = -1 - counted.left
    made = ended_after(searches, tmp_path / "b")
    assert searches > 1 and made.reduced[0].reduction.ended and not whole.reduced[0].reduction.ended
    text = (tmp_path / "b" / "planar_2r" / "planar_2r.h").read_text(encoding="utf-8")
    assert "search was ended by hand" in " ".join(text.replace("*", " ").split())
    errors = made.reduced[0].reduction.errors
    assert made.reduced[0].reduction.left_out and all((x.bounded or 0) <= x.tolerance for x in errors)


# Results that are zero but for rounding


def resting(bend: float) -> dict[str, object]:
    """A slide on a spring, and a carriage held against gravity, whose spring bends by a few last digits."""
    mass, k = 40.0, 8e7
    sag = -mass * 9.81 / k
    return {
        "name": "resting",
        "gravity": [0, 0, -9.81],
        "joints": [
            {"name": "x", "kind": "motor", "sigma": 1, "gamma": "pi/2", "alpha": "pi/2", "theta": "pi/2", "r": "qx"},
            {"name": "sx", "kind": "elastic", "sigma": 1, "r": "dx"},
            {"name": "z", "kind": "motor", "sigma": 1, "gamma": "pi/2", "alpha": "pi/2", "theta": 0, "r": "qz"},
            {"name": "sz", "kind": "elastic", "sigma": 1, "r": "dz"},
        ],
        "bodies": {"sx": {"mass": 100}, "sz": {"mass": mass}},
        "springs": {"sx": {"stiffness": 1e8, "damping": 10}, "sz": {"stiffness": k}},
        "motors": {"x": {"rotor_inertia": 200}, "z": {"rotor_inertia": 100}},
        "limits": {
            "x": {"position": [-0.2, 0.2], "velocity": 1, "acceleration": 10},
            "sx": {"position": [-1e-5, 1e-5], "velocity": 0.01},
            "z": {"position": [0, 0], "velocity": [0, 0], "acceleration": [0, 0]},
            "sz": {"position": [sag - bend, sag + bend], "velocity": [0, 0]},
        },
    }


@pytest.mark.sampled(2)
@pytest.mark.parametrize("guaranteed", ["confident", "proven"])
def test_a_result_that_is_zero_but_for_rounding_has_no_relative_tolerance(guaranteed: str, tmp_path: Path) -> None:
    """It is said; what is left out elsewhere changes it by no more than its rounding; others keep their tolerance."""
    machine = se.read(resting(2e-21))
    options = {"guaranteed": guaranteed, "out": tmp_path}
    (one,) = se.generate(machine, "inverse_dynamics", within="1 %", **options).reduced
    assert one.reduction.left_out
    (error,) = (x for x in one.reduction.errors if x.is_rounding)
    label = {(e.name, e.entry) for e in one.certificates[0].entries}
    assert (error.output, error.index) == ("qdd", 3) and ("qdd", "sz") in label
    (bound,) = (x for x in se.certify(machine, "inverse_dynamics").certificates[0].entries if x.entry == "sz")
    assert error.largest <= 100 * bound.likely and error.unseen <= bound.error
    header = " ".join((tmp_path / "resting" / "resting.h").read_text().replace("*", " ").split())
    assert "Zero but for rounding, so without a relative tolerance: qdd[sz]." in header
    for entry, x in zip(one.certificates[0].entries, one.reduction.errors, strict=False):
        assert x.is_rounding or not x.tolerance or min(entry.error, entry.likely) <= 1.001 * x.tolerance
    assert worst_errors(one, seed=5, states=2000)[-1] <= max(error.unseen, bound.error)


@pytest.mark.thorough
def test_a_result_with_some_digits_is_refused_with_the_way_out(tmp_path: Path) -> None:
    """A higher precision than double is none: the joint needs a tolerance of its own, which is accepted."""
    machine, options = se.read(resting(1e-18)), {"out": tmp_path}
    with pytest.raises(InputError, match=r"qdd\[sz\] .* off in double precision, .*: give sz a tolerance above it"):
        se.generate(machine, "inverse_dynamics", within="0.001 %", **options)
    assert se.generate(machine, "inverse_dynamics", within={"": "0.001 %", "sz": 1e-12}, **options).reduced


@pytest.mark.thorough
def test_trade_offs_leave_results_of_rounding_out() -> None:
    machine = DescribedMachine.of(se.read(resting(2e-21)))
    (grid,) = grids_of(machine, Scene(models=("inverse_dynamics",), within=within("1 %")))
    (curve,) = curves_of([grid], {})
    assert curve.points[0].rounding.value < 1e-9 and len(curve.path) > 1
