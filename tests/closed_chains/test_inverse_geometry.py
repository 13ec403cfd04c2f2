"""Inverse geometry through gears, coupled wrists and parallelograms: put back into products of 4x4 matrices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind, Machine, Parameter
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.model import Frame, TracedModel
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.closed_chains.machines import machine
from tests.generated_code import imported
from tests.references.closed_chains import Array, Chain, in_many_digits

pytestmark = pytest.mark.sampled(5)

POSE, POSITION = "inverse_geometric_model", "inverse_position_model"
EXACT = 1e-12
RX90 = Path(__file__).parents[2] / "examples" / "rx90.par"
WRIST = Path(__file__).parent / "mixing_wrist.toml"


def locked(described: Machine, **values: str) -> Machine:
    return restrict(described, Scene(locked={name: Formula.parse(x) for name, x in values.items()}))


def rx90_with_a_coupled_wrist() -> Machine:
    """Motors on the base turn the joints through gears; those of the wrist turn the joints that follow, too."""
    arm = read_machine(RX90)[0]
    followed = ["m1/N1", "m2/N2", "m3/N3", "m4/N4", "(m5 - c54*m4)/N5", "(m6 - c65*m5 - c64*m4)/N6"]
    motors = [Joint(f"motor_{k}", 0, Kind.MOTOR, 0, f"m{k}") for k in range(1, 7)]
    links = [
        replace(joint, antecedent=k and k + 6, kind=Kind.COUPLED, variable=None, theta=Formula.parse(cell))
        for k, (joint, cell) in enumerate(zip(arm.joints, followed, strict=True))
    ]
    ratios = {"N1": 12, "N2": -15, "N3": 11, "N4": 8, "N5": 6, "N6": 5, "c54": 0.3, "c65": -0.2, "c64": 0.5}
    lengths = {"D3": 0.45, "RL4": 0.4}
    parameters = [replace(p, value=Formula.parse(lengths.get(p.name, 0))) for p in arm.parameters]
    declared = [Parameter(name, Formula.parse(x)) for name, x in ratios.items()]
    return replace(arm, name="rx90_geared", joints=(*motors, *links), parameters=(*parameters, *declared))


def jacks_that_follow() -> Machine:
    """The arm with two jacks, whose boom and stick are independent: the jacks follow from them."""
    described = locked(machine("two_jack_arm"), bucket="0.2")
    rest = {"boom_jack": ("cylinder_1", "rod_1"), "stick_jack": ("cylinder_2", "rod_2")}
    return replace(described, loops=tuple(replace(loop, dependent=rest[loop.name]) for loop in described.loops))


@dataclass(frozen=True)
class Case:
    """A machine, the frame that is placed, number of solutions and of columns; positions of the variables.

    Each variable is drawn `around` zero, or the number given, by as much as `width`.
    """

    described: Machine
    frame: str
    solutions: int
    columns: int
    model: str = POSE
    width: float = 1.4
    around: Mapping[str, float] = field(default_factory=dict)


CASES = {
    "sr400": Case(machine("sr400"), "b6", 8, 6),
    "sr400, to the rod": Case(machine("sr400"), "pin_end", 2, 3),
    "geared_6r": Case(machine("geared_6r"), "tool", 8, 6),
    "coupled_wrist": Case(locked(machine("coupled_wrist"), link_2="0.001"), "link_6", 8, 6),
    "rx90": Case(rx90_with_a_coupled_wrist(), "j6", 8, 6, width=4),
    "palletizer": Case(machine("palletizer"), "flange", 4, 4, around={"q2": -1.0, "q4": 0.3}, width=0.4),
    "palletizer, plate": Case(machine("palletizer"), "plate", 4, 3, POSITION, 0.4, {"q2": -1.0, "q4": 0.3}),
    "parallelogram": Case(locked(machine("parallelogram_loop"), wrist="0.1"), "wrist", 4, 3, POSITION),
    "differential": Case(locked(machine("differential"), roll="0.1", hand="0.02"), "hand", 1, 2),
    "screw": Case(locked(machine("screw"), screw="0.01", nut="1e-4", tool="0.02"), "tool", 1, 2),
    "mixing_wrist": Case(locked(read_machine(WRIST)[0], pitch="0.01", roll="-0.02", hand="0.3"), "hand", 1, 2, width=9),
    "delta": Case(machine("delta"), "platform", 1, 3, POSITION, 0.1, {"pz": -0.75}),
    "two jacks": Case(jacks_that_follow(), "bucket", 4, 3, POSITION, 0.1, {"q_boom": -0.41, "q_stick": 1.25}),
}


@cache
def traced(name: str) -> TracedModel:
    case = CASES[name]
    return trace(case.described, case.model, (Frame(row(case.described, case.frame)),))


def row(described: Machine, name: str) -> int:
    return [joint.name for joint in described.joints].index(name) + 1


def solver(described: Machine, found: TracedModel, folder: Path) -> Any:
    for file, text in render_numpy(package(described, [found], ())).items():
        (folder / file).write_text(text)
    module = imported(folder)
    p = [x.value.value() for name in module.PARAMETERS for x in described.parameters if x.name == name and x.value]
    return lambda place: getattr(module, found.model.name)(place, p)


def positions(case: Case, count: int) -> list[dict[str, float]]:
    source = np.random.default_rng(5)
    names = [str(joint.variable) for joint in case.described.independent_joints]
    return [{name: case.around.get(name, 0) + source.uniform(-1, 1) * case.width for name in names}
            for _ in range(count)]  # fmt: skip


@in_many_digits
def placement(case: Case, u: Mapping[str, float]) -> Array:
    """0T of the frame by products of 4x4 matrices; loops that have closed forms are closed there."""
    described, at = case.described, dict(u)
    closed = bool(described.loops) and trace(described, "inertia_matrix").model.arguments == ("q",)
    if closed:
        program = trace(described, "dependent_coordinates").program
        parameters = {p.name: float(p.value.value()) for p in described.parameters if p.value}
        at |= zip(Chain(described).own, values(program, parameters | at), strict=True)
    chain = Chain(described)
    frames = chain.placements(dict.fromkeys([*chain.dependent, *chain.cuts], mpf(0)) | at)
    for loop in described.loops if closed else ():
        assert max(abs(frames[loop.cut - 1] - frames[loop.meets - 1])[:3, 3]) < EXACT
    return frames[row(described, case.frame) - 1].astype(float)


def values(program: Any, symbols: Mapping[str, float]) -> list[float]:
    entries = [x for output in program.outputs for x in output.entries]
    value = evaluate(entries, symbols, FLOATS)
    return [value(x) for x in entries]


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", CASES)
def test_every_solution_places_the_frame_and_one_is_the_position_it_was_placed_from(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    found = traced(name)
    assert found.results["q"].shape == (case.solutions, case.columns)
    solve = solver(case.described, found, tmp_path)
    moving = [joint.name for joint in case.described.independent_joints]
    columns = [moving.index(joint) for joint in found.results["q"].column_labels or moving]
    for u in positions(case, 3):
        T = placement(case, u)
        q, singularity = solve(T.ravel() if case.model == POSE else T[:3, 3])
        assert (np.isfinite(q).all(-1) == np.isfinite(singularity)).all()
        gaps = [np.abs(one - np.array(list(u.values()))[columns]).max() for one in q]
        assert np.nanmin(gaps) < EXACT * max(1, case.width)
        for one in q[np.isfinite(singularity)]:
            other = placement(case, u | dict(zip([list(u)[k] for k in columns], one.tolist(), strict=True)))
            assert np.abs((other - T)[:3, slice(0, 4) if case.model == POSE else 3]).max() < EXACT


def refusal(described: Machine, frame: str, model: str = POSE, folded: Sequence[str] = ()) -> str:
    with pytest.raises(InputError) as caught:
        trace(described, model, (Frame(row(described, frame)),), folded)
    return str(caught.value)


def test_the_frame_of_a_cut_row_is_that_of_the_row_it_meets() -> None:
    described = machine("sr400")
    cut, met = (
        render_numpy(package(described, [trace(described, POSE, (Frame(row(described, name)),))], ()))
        for name in ("pin", "pin_end")
    )
    assert cut[f"_{POSE}.py"] == met[f"_{POSE}.py"]


def test_a_place_that_parallelograms_do_not_allow_has_no_solution(tmp_path: Path) -> None:
    """The flange of a palletizer stays level: it is placed where it is turned about its axis, not where it tilts."""
    case = CASES["palletizer"]
    solve = solver(case.described, traced("palletizer"), tmp_path)
    T = placement(case, {"q1": 0.3, "q2": -1.1, "q4": 0.4, "q10": 0.2})
    c, s = np.cos(0.1), np.sin(0.1)
    about_z, about_x = np.eye(4), np.eye(4)
    about_z[:2, :2] = about_x[1:3, 1:3] = [[c, -s], [s, c]]
    q, _ = solve((T @ about_z).ravel())
    assert np.isfinite(q).all(-1).sum() == 2
    np.testing.assert_allclose(q[np.isfinite(q).all(-1)][:, -1], 0.3, atol=EXACT)
    assert np.isnan(solve((T @ about_x).ravel())[0]).all()


ELBOW = """
name = "elbow"
joints = [
  {{ name = "upper", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" }},
  {{ name = "lower", antecedent = "upper", kind = "coupled", sigma = 0, d = 0.5, theta = "{cell}" }},
  {{ name = "hand", antecedent = "lower", kind = "fixed", sigma = 2, d = 0.4 }},
]
[parameters]
N = {{ value = 2 }}
"""


def elbow(folder: Path, cell: str) -> Machine:
    path = folder / "elbow.toml"
    path.write_text(ELBOW.format(cell=cell))
    return read_machine(path)[0]


@pytest.mark.parametrize("cell", ["-2*q1", "q1/2", "3 - N*q1"])
def test_one_motor_that_turns_two_joints(cell: str, tmp_path: Path) -> None:
    """The joint that turns whole times less tells the variable, wherever the other one is."""
    described = elbow(tmp_path, cell)
    found = trace(described, POSE, (), ("N",))
    case = Case(described, "hand", 1, 1)
    solve = solver(described, found, tmp_path)
    for q1 in (3.0, -2.5, 0.1):
        q, _ = solve(placement(case, {"q1": q1}).ravel())
        assert q.shape == (1, 1) and abs(q[0, 0] - q1) < EXACT


def test_what_is_refused(tmp_path: Path) -> None:
    assert "joint 3 (rod_1): it follows from loop diamond, and not by sums" in refusal(machine("five_bar"), "tool")
    assert "is not a linear formula of e1, e2, qc" in refusal(machine("cam"), "follower")
    assert "joint 4 (link_2): the joint is elastic: forces" in refusal(machine("coupled_wrist"), "link_6")
    assert "joints 1 and 2 can move against each other" in refusal(machine("differential"), "carrier")
    assert "joint 7 (b7): it can move at every position" in refusal(machine("sr400"), "b3", POSITION)
    doubt = refusal(elbow(tmp_path, "N*q1"), "hand")
    assert (
        "joint 1 (upper): joints 1 and 2: their angles are known only up to whole turns" in doubt
        and "fold their ratios" in doubt
    )
    assert "ambiguous" in refusal(elbow(tmp_path, "1.5*q1"), "hand")
    tool = refusal(machine("palletizer"), "plate_side", POSITION)
    assert "joints 2, 3 and 15 follow" in tool and "ask for a frame before them" in tool
