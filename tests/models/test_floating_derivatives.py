"""Derivatives on a floating base: Pinocchio's free-flyer, differences in 50 digits, counts, growth, texts, names."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.codegen.latex import solution
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Kind, KnownOfBase, Machine, Orientation
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.base_body import rotation_of
from symoro_elastic.mechanics.derivatives import accelerations as acceleration_derivatives
from symoro_elastic.models.derivatives.derivatives import DERIVATIVES
from symoro_elastic.models.programs.catalogue import TracedModel, trace, trace_scene
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.pages.equations.page import html_page
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from tests.benchmarks.machines import chain as long_chain
from tests.benchmarks.machines import rigid
from tests.models.test_derivatives import assert_close, nodes
from tests.models.test_floating_base import BOTH, base_state, damped, exact_state, joint_state, on, quaternion_product
from tests.references.random_machines import chain, planar_2r, random_machine, two_children

pytestmark = pytest.mark.sampled(5)

INVERSE, DIRECT, INVERSE_BY_P, DIRECT_BY_P, _ = (model.name for model in DERIVATIVES)
STEP, CLOSE = mpmath.mpf("1e-16"), 1e-24
State = dict[str, list[Any]]


def moved(state: State, argument: str, k: int, h: Any) -> State:
    """The state with one entry of an argument, or the base, moved by h."""
    if argument != "pose":
        return state | {argument: [x + h * (i == k) for i, x in enumerate(state[argument])]}
    if k < 3:
        R = np.array(rotation_of(state["Q0"]))
        return state | {"P0": list(np.array(state["P0"]) + h * R[:, k])}
    turn = [mpmath.cos(h / 2), *(mpmath.sin(h / 2) * (i == k - 3) for i in range(3))]
    turned = list(quaternion_product(state["Q0"], turn))
    return state | {"Q0": turned, "R0": [x for row in rotation_of(turned) for x in row]}


def entries_of(traced: TracedModel, state: State, values: State | None = None) -> dict[str, Any]:
    """Every result at a state, in 50 digits."""
    symbols = dict(values or {})
    for argument in traced.program.inputs:
        symbols |= zip(argument.symbols, state[argument.name], strict=True)
    outputs = traced.program.outputs
    value = evaluate((x for output in outputs for x in output.entries), symbols, multiprecision(50))
    return {
        output.name: np.array([value(x) for x in output.entries], dtype=object).reshape(output.shape)
        for output in outputs
    }


def differences(traced: TracedModel, state: State, argument: str, count: int) -> dict[str, Any]:
    """Columns of each result of a model, by central differences."""
    columns: dict[str, list[Any]] = {name: [] for name in traced.results}
    for k in range(count):
        ahead, behind = (entries_of(traced, moved(state, argument, k, sign * STEP)) for sign in (1, -1))
        for name, column in columns.items():
            column.append((ahead[name] - behind[name]) / (2 * STEP))
    return {name: np.array(column, dtype=object).T for name, column in columns.items()}


MACHINES = [
    random_machine(2, joints=3, kinds=("motor", "fixed")),
    random_machine(4, joints=4),
    chain(3, prismatic=(2,), symbolic=False),
]


@pytest.mark.sampled(12)
@pytest.mark.parametrize("known", BOTH)
@pytest.mark.parametrize("name", [INVERSE, DIRECT])
@pytest.mark.parametrize("k", range(len(MACHINES)))
def test_derivatives_are_differences(k: int, name: str, known: KnownOfBase) -> None:
    """By pose, velocity and acceleration of the base or the wrench on it, and by all that joints have."""
    machine = on(MACHINES[k], known, turned=tuple(Orientation)[(k + (known is KnownOfBase.WRENCH)) % 2])
    machine = damped(machine) if k < 2 else machine
    model = name.removesuffix("_derivatives")
    with mpmath.workdps(50):
        state = exact_state(machine, k)
        state["R0"] = [x for row in rotation_of(state["Q0"]) for x in row]
        traced, undifferentiated = trace(machine, name), trace(machine, model)
        found = entries_of(traced, state)
        for argument in dict.fromkeys(of.split("_d", 1)[1] for of in found):
            of_argument = {of: x for of, x in found.items() if of.split("_d", 1)[1] == argument}
            count = next(iter(of_argument.values())).shape[1]
            wanted = differences(undifferentiated, state, argument, count)
            for of, entries in of_argument.items():
                result = of.split("_d", 1)[0][1:]
                if entries.size:
                    rows = [undifferentiated.rows[result].index(j) for j in traced.rows[of]] or slice(None)
                    assert_close(entries, wanted[result][rows], CLOSE)


def of_origin(base: dict[str, Any], count: int) -> tuple[Any, Any]:
    """Derivatives by V0 of w x v, rows of the base first: Pinocchio's acceleration lacks it."""
    v, w = base["V0"][:3], base["V0"][3:]
    more = np.zeros((6 + count, 6))
    more[:3] = np.cross(np.eye(6)[:, 3:], v).T + np.cross(w, np.eye(6)[:, :3]).T
    return more, np.cross(w, v)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("seed", range(6))
def test_pinocchio_has_the_same(seed: int) -> None:
    """Its analytic derivatives with a free-flyer; springs and friction, which it does not know, added."""
    pin = pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model as peer

    machine = random_machine(seed, joints=3 + seed)
    base, joints = base_state(seed), joint_state(machine, seed)
    free, driven = (on(machine, known, turned=Orientation.QUATERNION) for known in BOTH)
    built = peer._build(free, None)
    order, n = [*range(6), *built.order], len(built.order)
    square, model, data, outside = np.ix_(order, order), built.model, built.data, peer._external_forces(built)
    at, rate = peer._put(built, joints["q"], position=True), peer._put(built, joints["qd"])
    at[:7], rate[:6] = [0, 0, 0, *np.roll(base["Q0"], -1)], base["V0"]
    more, shift = of_origin(base, n)
    laws = [built.numbers.joints[j] for j in built.numbers.moving]
    viscous = np.diag([0.0] * 6 + [law.viscous for law in laws])
    state = joints | base

    acceleration = peer._put(built, np.random.default_rng(seed).uniform(-2, 2, n))
    acceleration[:6] = base["V0d"] - [*shift, 0, 0, 0]
    by_q, by_v, M = (x[square] for x in pin.computeRNEADerivatives(model, data, at, rate, acceleration, outside))
    M = np.triu(M) + np.triu(M, 1).T
    given = state | {"qdd_motor": acceleration[built.order]}
    assert_blocks(rigid(driven), INVERSE, given, by_q, by_v - M[:, :6] @ more[:6, :6] @ np.eye(6, 6 + n) + viscous, M)

    forces = peer._put(built, peer._joint_forces(built, joints["q"], joints["qd"]))
    forces[[built.order[k] for k in built.numbers.motors]] += joints["tau"]
    forces[:6] = base["f0"]
    by_q, by_v, inverse = (x[square] for x in pin.computeABADerivatives(model, data, at, rate, forces, outside))
    inverse = np.triu(inverse) + np.triu(inverse, 1).T
    soft = [law.kind is Kind.ELASTIC for law in laws]
    stiffness = np.diag([0.0] * 6 + [law.stiffness * on_ for law, on_ in zip(laws, soft, strict=True)])
    damping = np.diag([0.0] * 6 + [law.damping * on_ for law, on_ in zip(laws, soft, strict=True)])
    by_v = by_v - inverse @ (viscous + damping) + more @ np.eye(6, 6 + n)
    motors = [*range(6), *(6 + k for k in built.numbers.motors)]
    assert_blocks(free, DIRECT, state, by_q - inverse @ stiffness, by_v, inverse[:, motors], 1e-10)


def assert_blocks(machine: Machine, name: str, state: Any, *wanted: Any) -> None:
    """Columns by position, velocity and what is known; base first in rows and columns."""
    *tables, bound = wanted if isinstance(wanted[-1], float) else (*wanted, 1e-11)
    with mpmath.workdps(50):
        traced = trace(machine, name)
        numbers = {of: [mpmath.mpf(float(x)) for x in state[of]] for of in traced.model.arguments}
        found = entries_of(traced, numbers)
    last = "qdd_motor" if name == INVERSE else "tau"
    rows, base = (("f0", "tau"), "V0d") if name == INVERSE else (("V0d", "qdd"), "f0")
    for table, columns in zip(tables, (("pose", "q"), ("V0", "qd"), (base, last)), strict=True):
        blocks = [[found[f"d{row}_d{column}"] for column in columns] for row in rows]
        assert_close(np.block(blocks), table.astype(object), bound)


@pytest.mark.parametrize("turned", Orientation)
@pytest.mark.parametrize("known", BOTH)
def test_parameters_are_differences(known: KnownOfBase, turned: Orientation) -> None:
    """Lengths, masses, springs, gravity: every parameter of a small machine, the body of the base included."""
    machine = on(planar_2r(elastic=(2,)), known, turned=turned)
    values = {p.name: mpmath.mpf(k) / 7 + 1 for k, p in enumerate(machine.parameters)}
    for name in (INVERSE_BY_P, DIRECT_BY_P):
        with mpmath.workdps(50):
            traced, plain = trace(machine, name), trace(machine, name.removesuffix("_parameter_derivatives"))
            state = exact_state(machine, 1)
            state["R0"] = [x for row in rotation_of(state["Q0"]) for x in row]
            found = entries_of(traced, state, values)
            labels = next(iter(traced.results.values())).column_labels
            for of, entries in found.items():
                result = of.removesuffix("_dp")[1:]
                for k, label in enumerate(labels):
                    columns = []
                    for sign in (1, -1):
                        there = values | {label: values[label] + sign * STEP}
                        columns.append(entries_of(plain, state, there)[result])
                    rows = [plain.rows[result].index(j) for j in traced.rows[of]] or slice(None)
                    assert_close(entries[:, k], ((columns[0] - columns[1]) / (2 * STEP))[rows], CLOSE)


def test_long_chains_are_solved_by_recursion(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = on(chain(5, symbolic=False))
    with mpmath.workdps(50):
        state = exact_state(machine, 1) | {"R0": [mpmath.mpf(i in (0, 4, 8)) for i in range(9)]}
        short = entries_of(trace(machine, DIRECT), state)
        monkeypatch.setattr(acceleration_derivatives, "LONG", -1)
        for of, entries in entries_of(trace(machine, DIRECT), state).items():
            assert_close(entries, short[of], 1e-30)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "known", "most"),
    [
        (INVERSE, KnownOfBase.ACCELERATION, 1.15),
        (INVERSE, KnownOfBase.WRENCH, 1.95),
        (DIRECT, KnownOfBase.WRENCH, 1.8),
        (DIRECT, KnownOfBase.ACCELERATION, 1.45),
    ],
)
def test_a_base_adds_less_the_more_joints_there_are(name: str, known: KnownOfBase, most: float) -> None:
    """Operations over those on a fixed base: six degrees of freedom more, no other growth."""
    ratios = [nodes(on(long_chain(n), known), name) / nodes(long_chain(n), name) for n in (5, 10, 20)]
    assert ratios == sorted(ratios, reverse=True) and ratios[-1] < most


def test_only_what_is_asked() -> None:
    """The turn of a base under a known wrench costs the turn of gravity, no more."""
    machine = on(random_machine(1, joints=6))
    (traced,) = trace_scene(machine, Scene((DIRECT,), {DIRECT: ("by pose_4, pose_5",)}))
    assert {of: result.column_labels for of, result in traced.results.items()} == {
        "dqdd_dpose": ("pose_4", "pose_5"),
        "dV0d_dpose": ("pose_4", "pose_5"),
    }
    assert set(traced.results["dqdd_dpose"].entries) == {0}
    assert traced.program.count.products + traced.program.count.add < 30


def test_columns_of_a_base_that_is_driven() -> None:
    """Those of the pose are made of those of the acceleration, which nobody asks for."""
    machine = on(two_children(symbolic=False), KnownOfBase.ACCELERATION)
    (traced,) = trace_scene(machine, Scene((INVERSE,), {INVERSE: ("by pose",)}))
    whole = trace(machine, INVERSE)
    assert list(traced.results) == ["dtau_dpose", "dqdd_dpose", "df0_dpose"]
    with mpmath.workdps(50):
        state = exact_state(machine, 2) | {"R0": [mpmath.mpf(i + 1) / 9 for i in range(9)]}
        full = entries_of(whole, state)
        for of, entries in entries_of(traced, state).items():
            assert_close(entries, full[of], 1e-30)


@pytest.mark.parametrize("known", BOTH)
@pytest.mark.parametrize("name", [INVERSE, DIRECT])
def test_equations_in_latex(name: str, known: KnownOfBase) -> None:
    """Every quantity and every result has a symbol."""
    package = programs(on(chain(3), known), Scene(models=(name,))).package
    solved = solution(package, package.functions[0])
    written = [*solved.results, *(x for stretch in (*solved.once, *solved.steps) for x in stretch.equations)]
    assert [x.left for x in written if r"\_" in x.left] == []
    assert "&part;" in html_page(package, package.functions[0])


@pytest.mark.thorough
@pytest.mark.parametrize("known", BOTH)
def test_generated_code_gives_what_the_equations_give(known: KnownOfBase) -> None:
    """C and numpy against 50 digits, springs and named parameters included."""
    machine = on(planar_2r(elastic=(2,)), known, turned=tuple(Orientation)[known is KnownOfBase.WRENCH])
    outputs = dict.fromkeys((INVERSE_BY_P, DIRECT_BY_P), ("by L1, K2, M2",))
    found = verify(machine, Scene((INVERSE, DIRECT, *outputs), outputs), states=(2, 4))
    assert found.ok and len(found.models) == 4
