"""Frames at a point of their body, against rows added to the table, Pinocchio and differences in 50 digits."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Joint, Kind, Machine, Parameter
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.scene import ALL, Parts, Point, RequestedPart, Scene
from symoro_elastic.models.bound.model import Frame
from symoro_elastic.models.programs.catalogue import MODELS, trace, trace_scene
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.pages.equations.page import html_page, latex_document
from tests.compiled_models import cell, vector
from tests.generated_code import ALL_MODELS
from tests.models.test_kinematics import MANY, MOTIONS, WELDED, Wanted, error, made, of_model, values, whole_state
from tests.references.random_machines import chain, planar_2r, random_machine, random_state

pytestmark = pytest.mark.sampled(5)

TOLERANCE = 1e-12
POINTS = (vector("0.1", "-pi/20", "3/8"), vector(0, 0, "0.25"), vector("sqrt(2)/5", 0, 0))


def with_point(machine: Machine, j: int, at: Point) -> tuple[Machine, int]:
    """The machine with the point as rows of its table, two quarter turns apart, and the number of the last one."""
    n, (x, y, z) = len(machine.joints), at
    rows = (
        Joint(f"corner{n + 1}", j, Kind.FIXED, 2, d=x, theta=cell("pi/2"), r=z),
        Joint(f"corner{n + 2}", n + 1, Kind.FIXED, 2, d=y, theta=cell("-pi/2")),
    )
    return replace(machine, joints=(*machine.joints, *rows)), n + 2


def with_lengths(machine: Machine) -> Machine:
    """Two more parameters, which no row of the table holds."""
    lengths = (Parameter("reach", cell("0.7"), "m"), Parameter("height", cell("1/3"), "m"))
    return replace(machine, parameters=(*machine.parameters, *lengths))


def asked_points(machine: Machine, seed: int) -> list[tuple[int, Point, int | None]]:
    """(frame, point, seen from): nothing said, the base, itself, any other; twice the same point."""
    rng, n = np.random.default_rng(seed), len(machine.joints)
    of_lengths = vector("2*reach", "-height", "reach - height")
    chosen: list[tuple[int, Point, int | None]] = [(n, of_lengths, place) for place in (None, 0, n, 1)]
    drawn = rng.integers([1, 0], n + 1, (4, 2)).tolist()
    return [*chosen, *((j, POINTS[k % 3], place) for k, (j, place) in enumerate(drawn)), (0, POINTS[0], n)]


def texts(machine: Machine, asked: list[tuple[int, Point, int | None]]) -> tuple[str, ...]:
    names = ["base", *(joint.name for joint in machine.joints)]
    return tuple(str(RequestedPart(names[j], at, None if place is None else names[place])) for j, at, place in asked)


AT_POINTS = tuple(name for name in ALL_MODELS if MODELS[name].parts is Parts.POINTS)
VARIOUS = [
    pytest.param(random_machine(800, joints=5, symbolic=True), Scene(), id="symbolic tree"),
    pytest.param(random_machine(801, joints=7, moving_base=True), Scene(), id="tree on a moving base"),
    pytest.param(random_machine(802, joints=6, symbolic=True, prismatic=0.6), Scene(fold=ALL), id="folded tree"),
    pytest.param(chain(4, elastic=(2,), prismatic=(3,)), Scene(), id="chain"),
    pytest.param(WELDED, Scene(), id="fixed frames"),
]


@pytest.mark.thorough
@pytest.mark.parametrize(("machine", "scene"), VARIOUS)
def test_a_point_is_a_fixed_row_there(machine: Machine, scene: Scene, tmp_path: Path) -> None:
    """C and numpy against 50 digits of the machine with rows at the points; its own frame is there too."""
    machine = with_lengths(machine)
    asked = asked_points(machine, 3)
    outputs = (*texts(machine, asked), machine.joints[-1].name)
    code = made(
        machine,
        tmp_path,
        AT_POINTS,
        resolve(replace(scene, outputs=dict.fromkeys(AT_POINTS, outputs)), machine, MODELS),
    )
    state, with_rows, rows = whole_state(machine, 5), machine, []
    for j, at, place in asked:
        with_rows, row = with_point(with_rows, j, at)
        rows.append((row, place))
    wanted = Wanted(with_rows, state)
    for model in AT_POINTS:
        exact = [wanted(model, row, place) for row, place in (*rows, (len(machine.joints), None))]
        assert code.module.OUTPUTS[model] == {code.results[model][0]: outputs}
        for run in code.both():
            assert error(run(model, **of_model(model, state))[0], exact) < TOLERANCE, model


@pytest.mark.parametrize("seed", range(4))
def test_a_point_costs_what_a_row_costs(seed: int) -> None:
    """Never more operations than a row at the point."""
    machine = random_machine(810 + seed, joints=6, symbolic=True, prismatic=0.4)
    for at in POINTS:
        with_rows, row = with_point(machine, 6, at)
        for model in AT_POINTS:
            point = trace(machine, model, (Frame(6, 0, at),)).program.count
            fixed = trace(with_rows, model, (Frame(row, 0),)).program.count
            assert point.products <= fixed.products and point.add <= fixed.add, model


@pytest.mark.parametrize("seed", range(4))
def test_points_against_pinocchio(seed: int, tmp_path: Path) -> None:
    """Operational frames of Pinocchio, moved along their own axes."""
    pin = pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    machine = random_machine(820 + seed, joints=4 + seed, symbolic=seed % 2 == 0)
    state, numbers, there = whole_state(machine, seed), len(machine.joints), pinocchio_model._build(machine, None)
    model, order, asked = there.model, there.order, [(j, POINTS[j % 3]) for j in range(1, numbers + 1)]
    frames = []
    for j, at in asked:
        place = there.places[j - 1] * pin.SE3(np.eye(3), np.array([x.value() for x in at]))
        frames.append(model.addFrame(pin.Frame(f"point {j}", there.carriers[j - 1], 0, place, pin.FrameType.OP_FRAME)))
    data = model.createData()
    q = pinocchio_model._put(there, state["q"], position=True)
    qd, qdd = pinocchio_model._put(there, state["qd"]), pinocchio_model._put(there, state["qdd"])
    pin.forwardKinematics(model, data, q, qd, qdd)
    pin.computeJointJacobians(model, data, q)
    pin.computeJointJacobiansTimeVariation(model, data, q, qd)
    pin.updateFramePlacements(model, data)
    aligned, local = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED, pin.ReferenceFrame.LOCAL
    outputs = texts(machine, [(j, at, None) for j, at in asked])
    code = made(machine, tmp_path, MOTIONS, Scene(outputs=dict.fromkeys(MOTIONS, outputs)))
    found = {name: code.c(name, **of_model(name, state))[0] for name in MOTIONS}
    dJ = [pin.getFrameJacobianTimeVariation(model, data, f, aligned)[:, order] for f in frames]
    wanted = {
        "velocities": [pin.getFrameVelocity(model, data, f, local).vector for f in frames],
        "accelerations": [pin.getFrameClassicalAcceleration(model, data, f, local).vector for f in frames],
        "jacobian": [pin.getFrameJacobian(model, data, f, aligned)[:, order] for f in frames],
        "jacobian_dot_qd": dJ @ state["qd"],
    }
    for name, exact in wanted.items():
        assert error(found[name], exact) < 1e-13, name


@pytest.mark.parametrize("seed", range(3))
def test_points_by_differences(seed: int) -> None:
    """J is the slope of the placement, jacobian_dot_qd that of J qd, to 20 digits."""
    machine = random_machine(830 + seed, joints=5, symbolic=seed == 1)
    q, qd, _ = (np.array([MANY.number(Fraction(x)) for x in part]) for part in random_state(machine, seed))
    point, h = (Frame(5, 0, POINTS[seed]),), MANY.number(1) / 10**14

    def slope(model: str, direction: Any) -> Any:
        traced = trace(machine, model, point)
        after, before = (values(machine, traced, {"q": q + t * direction}, MANY)[0] for t in (h, -h))
        return (after - before) / (2 * h)

    J = values(machine, trace(machine, "jacobian", point), {"q": q}, MANY)[0]
    assert abs(slope("geometric_model", qd)[:3, 3] - (J @ qd)[:3]).max() < 1e-20
    rest = values(machine, trace(machine, "jacobian_dot_qd", point), {"q": q, "qd": qd}, MANY)[0]
    assert abs(slope("jacobian", qd) @ qd - rest).max() < 1e-20


def test_only_the_parameters_of_the_point_enter() -> None:
    machine = with_lengths(chain(3))
    (traced,) = trace_scene(machine, Scene(("velocities",), {"velocities": ("joint3 at (reach, 0, 0)",)}))
    assert "reach" in traced.program.used and "height" not in traced.program.used


@pytest.mark.thorough
def test_check_knows_points() -> None:
    """The 50-digit reference of `check` places points by products of 4 x 4 matrices."""
    outputs = ("joint3 at (reach, -height, 0.1) in joint2", "joint2 at (0, height^2, 0)", "base at (1, 2, 3) in joint3")
    found = verify(with_lengths(chain(3)), Scene(("geometric_model",), {"geometric_model": outputs}))
    assert found.ok and found.models[0].numpy.error < 1e-14


def test_a_point_in_the_equations() -> None:
    """It is listed after the rows of the table, and results carry its number."""
    scene = Scene(("jacobian",), {"jacobian": ("joint2 at (L1, 0, 0)", "joint2 at (L1, 0, 0) in joint2")})
    package = programs(planar_2r(), scene).package
    text = latex_document(package, package.functions[0])
    assert r"\makebox[10mm][r]{3}\quad\makebox[45mm][l]{joint2 at (L1, 0, 0)}fixed" in text
    assert r"\eqline{J_{3}}" in text and r"\eqline{{}^{2}J_{3}}" in text
    assert "joint2 at (L1, 0, 0)" in html_page(package, package.functions[0])


def test_points_are_read_and_written_as_text() -> None:
    assert RequestedPart.parse("tool") == RequestedPart("tool")
    text = "tool at (0.1, atan2(1, L2), -(L1 + 2)*pi) in base"
    asked = RequestedPart.parse(text)
    assert asked.at and len(asked.at) == 3 and str(asked) == text
    assert str(RequestedPart.parse("tool  at ( 0 ,L1\n + 2 , 3 )  in base ")) == "tool at (0, L1 + 2, 3) in base"


@pytest.mark.parametrize("form", [toml, par])
def test_points_in_a_machine_file(form: Any) -> None:
    """Also where a parameter stands in no cell of the table; joints by number."""
    outputs = {"jacobian": ("2 at (L1, -2*(reach), 0) in base",), "velocities": ("joint2",)}
    machine = DescribedMachine.of(with_lengths(planar_2r())).asking(scene=Scene(("jacobian", "velocities"), outputs))
    again = form.read(form.write(machine), "arm")
    assert again.asked.scene.outputs["jacobian"] == ("joint2 at (L1, -2*(reach), 0) in base",)
    assert {"L1", "reach"} <= {p.name for p in again.parameters}
    assert trace_scene(again, again.asked.scene)[0].program.used >= {"reach", "L1"}


@pytest.mark.parametrize(
    ("model", "output", "reason"),
    [
        ("jacobian", "joint2 at (1, 2)", "a point has three coordinates in brackets, as in 'tool at (0.1, 0, L2)'"),
        ("jacobian", "joint2 at (1, 2, 3, 4)", "a point has three coordinates"),
        ("jacobian", "joint2 at 1 2 3", "a point has three coordinates in brackets"),
        ("jacobian", "joint2 at (1, , 3)", "an empty expression"),
        ("jacobian", "joint2 at (1, 2, L77) in base", "'L77' is not declared in [parameters]"),
        ("jacobian", "joint2 at (1, 2, q1)", "'q1' is not declared in [parameters]"),
        ("jacobian", "joint2 at (1, 2*, 3)", "the expression ends too early"),
        ("jacobian", "joint2 at (1, open('x'), 3)", "is not arithmetic"),
        ("jacobian", "joint2 at (1, 2, 3) at (1, 2, 3)", "write a single point of a frame"),
        ("jacobian", "joint9 at (1, 2, 3)", "no frame 'joint9'"),
        ("inverse_position_model", "joint2 at (1, 2, 3)", "only geometric_model, velocities, accelerations"),
        ("direct_dynamics", "joint2 at (1, 2, 3)", "only geometric_model, velocities, accelerations"),
    ],
)
def test_points_that_cannot_be_had(model: str, output: str, reason: str) -> None:
    with pytest.raises(InputError) as caught:
        resolve(Scene((model,), {model: (output,)}), chain(3), MODELS)
    said = str(caught.value)
    assert said.startswith(f"chain3: scene, outputs, {model}: ") and reason in said and "\n" not in said


def test_a_point_without_value() -> None:
    scene = Scene(("jacobian",), {"jacobian": ("joint2 at (1/(D3 - D3), 0, 0)",)})
    with pytest.raises(InputError, match=r"^chain3: scene, outputs: .* has no value: it divides by zero"):
        trace_scene(chain(3), resolve(scene, chain(3)))
