"""Derivatives of the dynamic models: Pinocchio's, differences in 50 digits, symmetry, growth, counts, texts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpmath import mp, mpf, workdps

from symoro_elastic.codegen.latex import solution
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import write_files
from symoro_elastic.generation.pipeline import programs, refuse_degenerate
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Kind, Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.mechanics.derivatives import accelerations as acceleration_derivatives
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Result
from symoro_elastic.models.derivatives.derivatives import DERIVATIVES
from symoro_elastic.models.programs.catalogue import MODELS, trace_scene
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.pages.equations.page import html_page
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.differentiation import Differentiation, substitute
from symoro_elastic.symbolic.expression import Graph, reachable
from symoro_elastic.symbolic.functions import cosine_sine
from symoro_elastic.symbolic.operations import ATAN2, SIGN, SQRT, SYMBOL
from tests.benchmarks.machines import arm_6, arm_7, example, humanoid, rigid
from tests.benchmarks.machines import chain as long_chain
from tests.generated_code import COMPILERS, compiled, rendered
from tests.references import multiprecision as reference
from tests.references.random_machines import (
    chain,
    first_joint_elastic,
    planar_2r,
    random_machine,
    random_state,
    with_springs_beside_motors,
)

pytestmark = pytest.mark.sampled(5)

INVERSE, DIRECT, INVERSE_BY_P, DIRECT_BY_P, _ = (model.name for model in DERIVATIVES)
ARGUMENTS = {"dq": 0, "dqd": 1, "dqdd_motor": 2, "dtau": 2}
STEP, EXACT, ROUNDED = "1e-16", 1e-24, 2e-13
Array = np.ndarray[Any, Any]


def results(machine: Machine, name: str, folded: Sequence[str] = ()) -> dict[str, Result]:
    return MODELS[name].run(Bound(machine, folded), machine.independent)


def numbers(machine: Machine, name: str, state: Sequence[Sequence[Any]]) -> dict[str, Array]:
    """Every result at a state, in 50 digits."""
    arithmetic, bound = multiprecision(50), Bound(machine)
    traced = MODELS[name].run(bound, machine.independent)
    symbols = {p.name: p.value.evaluate({}, {}, arithmetic.number) for p in machine.parameters if p.value}
    arguments = [bound.arguments()[argument] for argument in MODELS[name].arguments]
    for entries, given in zip(arguments, state, strict=True):
        symbols |= {symbol: arithmetic.number(x) for symbol, x in zip(entries, given, strict=True)}
    value = evaluate([x for result in traced.values() for x in result.entries], symbols, arithmetic)
    with workdps(50):
        return {
            of: np.array([mpf(value(x)) for x in result.entries], dtype=object).reshape(result.shape)
            for of, result in traced.items()
        }


def exact(formula: Formula) -> Any:
    """The decimals of a file, without rounding."""
    with workdps(50):
        return formula.evaluate({}, {}, lambda x: mpf(Fraction(x).numerator) / Fraction(x).denominator)


def differences(function: Callable[[Any], list[Any]], at: Sequence[Any]) -> Array:
    """Columns of derivatives by central differences."""
    columns = []
    with workdps(50):
        step = mpf(STEP)
        for k in range(len(at)):
            ahead, behind = ([mpf(x) + sign * step * (i == k) for i, x in enumerate(at)] for sign in (1, -1))
            columns.append([(a - b) / (2 * step) for a, b in zip(function(ahead), function(behind), strict=True)])
    return np.array(columns, dtype=object).T


def wanted(machine: Machine, name: str, of: str, state: Sequence[Any], values: Any = None) -> list[Any]:
    """Entries of tau or of the accelerations that a model finds."""
    if name in (DIRECT, DIRECT_BY_P):
        return reference.direct_dynamics(machine, *state, values)
    tau, qdd = reference.inverse_dynamics(machine, *state, values)
    motors = [machine.joints[j - 1].kind is Kind.MOTOR for j in machine.independent]
    return tau if of == "dtau" else [x for x, motor in zip(qdd, motors, strict=True) if not motor]


def assert_close(found: Array, expected: Array, bound: float) -> None:
    assert found.shape == expected.shape
    with workdps(50):
        scale = max([1, *(abs(x) for x in expected.ravel())])
        assert max([0, *(abs(x) for x in (found - expected).ravel())]) / scale < bound


MACHINES = [
    *(random_machine(s, joints=3 + s % 3, symbolic=True, moving_base=s % 3 == 1) for s in range(4)),
    random_machine(7, joints=4, kinds=(Kind.ELASTIC, Kind.MOTOR), prismatic=0, symbolic=True),
    random_machine(8, joints=4, kinds=(Kind.MOTOR, Kind.FIXED), moving_base=True),
    first_joint_elastic(symbolic=True),
    with_springs_beside_motors(random_machine(1, joints=4, symbolic=True)),
]
VARIOUS = [pytest.param(machine, id=f"{machine.name}-{k}") for k, machine in enumerate(MACHINES)]


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", [INVERSE, DIRECT])
@pytest.mark.parametrize("machine", VARIOUS)
def test_derivatives_are_differences(machine: Machine, name: str) -> None:
    """Springs, passive joints, friction, wrenches, a moving base, trees, slides, gamma and b."""
    state = random_state(machine, 3)
    for of, found in numbers(machine, name, state).items():
        result, _, by = of.partition("_")
        k = ARGUMENTS[by]

        def moved(x: Any, k: int = k, result: str = result) -> list[Any]:
            return wanted(machine, name, result, [*state[:k], x, *state[k + 1 :]])

        expected = differences(moved, state[k])
        if found.size:
            assert_close(found, expected, EXACT)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", [INVERSE_BY_P, DIRECT_BY_P])
@pytest.mark.parametrize("machine", [MACHINES[k] for k in (0, 1, 6)], ids=lambda machine: machine.name)
def test_derivatives_by_parameters_are_differences(machine: Machine, name: str) -> None:
    """Lengths, masses, inertias, stiffnesses, frictions: some of each machine."""
    state, default = random_state(machine, 4), {p.name: exact(p.value) for p in machine.parameters if p.value}
    found = numbers(machine, name, state)
    labels = next(iter(results(machine, name).values())).column_labels
    assert {"D", "R", "M", "K"} & {label.rstrip("0123456789") for label in labels}
    chosen = range(0, len(labels), 4)
    for of, entries in found.items():

        def moved(x: Any, of: str = of) -> list[Any]:
            values = dict(zip((labels[c] for c in chosen), x, strict=True))
            return wanted(machine, name, of.removesuffix("_dp"), state, values)

        assert_close(entries[:, list(chosen)], differences(moved, [default[labels[c]] for c in chosen]), EXACT)


@pytest.mark.parametrize("seed", range(10))
def test_pinocchio_has_the_same(seed: int) -> None:
    """Its analytic derivatives; springs and friction, which it does not know, added."""
    pin = pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model as peer

    machine = random_machine(seed, joints=3 + seed)
    built = peer._build(machine, None)
    (q, qd, _), order = random_state(machine, seed), np.ix_(built.order, built.order)
    qdd = np.random.default_rng(seed).uniform(-2, 2, len(q))
    at, rate, outside = peer._put(built, q, position=True), peer._put(built, qd), peer._external_forces(built)
    by_q, by_qd, _ = pin.computeRNEADerivatives(built.model, built.data, at, rate, peer._put(built, qdd), outside)
    viscous = np.diag([built.numbers.joints[j].viscous for j in built.numbers.moving])
    found = numbers(rigid(machine), INVERSE, (q, qd, qdd))
    assert_close(found["dtau_dq"], by_q[order], ROUNDED)
    assert_close(found["dtau_dqd"], by_qd[order] + viscous, ROUNDED)

    tau = random_state(machine, seed)[2]
    forces = peer._joint_forces(built, np.asarray(q), np.asarray(qd))
    forces[built.numbers.motors] += tau
    by_q, by_qd, inverse = pin.computeABADerivatives(
        built.model, built.data, at, rate, peer._put(built, forces), outside
    )
    inverse = (np.triu(inverse) + np.triu(inverse, 1).T)[order]
    laws = [built.numbers.joints[j] for j in built.numbers.moving]
    soft = [law.kind is Kind.ELASTIC for law in laws]
    stiffness = np.diag([law.stiffness * on for law, on in zip(laws, soft, strict=True)])
    damping = viscous + np.diag([law.damping * on for law, on in zip(laws, soft, strict=True)])
    found = numbers(machine, DIRECT, (q, qd, tau))
    assert_close(found["dqdd_dq"], by_q[order] - inverse @ stiffness, 1e-11)
    assert_close(found["dqdd_dqd"], by_qd[order] - inverse @ damping, 1e-11)
    assert_close(found["dqdd_dtau"], inverse[:, built.numbers.motors], 1e-11)


def test_inertia_matrix_and_its_inverse() -> None:
    """Both are symmetric, entry for entry, and inverse to each other."""
    machine = chain(5)
    state = random_state(machine, 0)
    A, inverse = numbers(machine, INVERSE, state)["dtau_dqdd_motor"], numbers(machine, DIRECT, state)["dqdd_dtau"]
    assert (A == A.T).all() and (inverse == inverse.T).all()
    with workdps(50):
        assert_close(A @ inverse, np.eye(5, dtype=int).astype(object) * mp.one, 1e-30)
    assert_close(A, np.array(reference.inertia_matrix(machine, state[0]), dtype=object), 1e-30)


def nodes(machine: Machine, name: str, fold: bool = False) -> int:
    """Products, divisions, sums and differences."""
    found = results(machine, name, [p.name for p in machine.parameters] if fold else ())
    expressions = reachable(x for result in found.values() for x in result.entries)
    return sum(x.operation in "+-*/" and x.operation != SYMBOL for x in expressions)


@pytest.mark.thorough
def test_long_chains_are_solved_by_recursion(monkeypatch: pytest.MonkeyPatch) -> None:
    machine, state = chain(6), random_state(chain(6), 1)
    short = numbers(machine, DIRECT, state)
    fewer = nodes(machine, DIRECT)
    monkeypatch.setattr(acceleration_derivatives, "LONG", -1)
    for name, found in numbers(machine, DIRECT, state).items():
        assert_close(found, short[name], 1e-30)
    assert nodes(machine, DIRECT) > fewer
    counts = [nodes(long_chain(n), DIRECT) / n**2 for n in (5, 10, 20)]
    assert max(counts) < 223 and counts[2] < 1.02 * counts[1]


@pytest.mark.thorough
def test_operations_grow_as_the_square_of_the_joints() -> None:
    counts = [nodes(long_chain(n), INVERSE) / n**2 for n in (5, 10, 20)]
    assert counts == sorted(counts, reverse=True) and counts[0] < 85
    assert max(nodes(long_chain(n), DIRECT) / n**2 for n in (5, 10)) < 150


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("machine", "name", "most", "casadi"),
    [
        (arm_6, INVERSE, 2050, 6794),
        (arm_6, DIRECT, 3950, 12617),
        (arm_7, INVERSE, 2600, 10519),
        (arm_7, DIRECT, 5300, 18622),
        (humanoid, INVERSE, 14400, 59442),
        (humanoid, DIRECT, 33600, 118112),
    ],
)
def test_fewer_operations_than_automatic_differentiation(
    machine: Callable[[], Machine], name: str, most: int, casadi: int
) -> None:
    """Against the Jacobians that CasADi 3.8 makes of Pinocchio's recursions, same numbers, subexpressions shared."""
    assert nodes(machine(), name, fold=True) <= most < casadi / 3


def test_graph_where_it_is_shorter() -> None:
    """On the machine tool, whose slides and springs make for short derivatives."""
    assert nodes(example("two_axis.toml"), DIRECT) < 900
    assert nodes(example("two_axis.toml"), INVERSE) < 950


def test_no_row_for_accelerations_that_are_given() -> None:
    assert list(results(chain(3), INVERSE)) == ["dtau_dq", "dtau_dqd", "dtau_dqdd_motor"]
    assert list(results(chain(3), INVERSE_BY_P)) == ["dtau_dp"]
    elastic = results(planar_2r(elastic=(2,)), INVERSE)
    assert {name: result.shape for name, result in elastic.items()} == {
        "dtau_dq": (1, 2),
        "dtau_dqd": (1, 2),
        "dtau_dqdd_motor": (1, 1),
        "dqdd_dq": (1, 2),
        "dqdd_dqd": (1, 2),
        "dqdd_dqdd_motor": (1, 1),
    }


def test_columns_are_parameters_that_matter() -> None:
    machine = planar_2r(elastic=(2,))
    (by_p,) = results(machine, DIRECT_BY_P).values()
    assert by_p.column_labels == tuple(p.name for p in machine.parameters if p.name in by_p.column_labels)
    assert "M1" not in by_p.column_labels and {"L1", "M2", "K2", "G"} <= set(by_p.column_labels)
    chosen = Scene(models=(DIRECT_BY_P,), fold=tuple(p.name for p in machine.parameters if p.name not in ("K2", "L1")))
    (traced,) = trace_scene(machine, chosen)
    assert set(traced.results["dqdd_dp"].column_labels) == {"K2", "L1"}


@pytest.mark.thorough
def test_generated_code_gives_what_the_equations_give() -> None:
    """C and numpy against 50 digits, at moderate and extreme states; and the rows that a scene asks for."""
    scene = Scene(models=tuple(model.name for model in DERIVATIVES), outputs={DIRECT: ("joint2",)})
    found = verify(planar_2r(elastic=(2,)), scene, states=(3, 8))
    assert found.ok and {model.name for model in found.models} == set(scene.models)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", [model.name for model in DERIVATIVES])
@pytest.mark.parametrize("machine", [planar_2r(), planar_2r(elastic=(2,)), chain(3)], ids=["2r", "elastic", "chain"])
def test_equations_in_latex(machine: Machine, name: str) -> None:
    """Every quantity has a symbol; those of differentiated graphs too."""
    package = programs(machine, Scene(models=(name,))).package
    solved = solution(package, package.functions[0])
    written = [*solved.results, *(x for stretch in (*solved.once, *solved.steps) for x in stretch.equations)]
    assert any(r"\partial" in equation.left for equation in written)
    assert "&part;" in html_page(package, package.functions[0])
    literal = [x.left for x in written if x.left.startswith((r"\mathit{by", r"\mathit{F", r"\mathit{q"))]
    assert literal == []


@pytest.mark.thorough
@pytest.mark.parametrize("compiler", COMPILERS)
def test_c_compiles_without_a_warning(compiler: str, tmp_path: Path) -> None:
    for machine in (planar_2r(elastic=(2,)), chain(3, symbolic=True)):
        folder = tmp_path / machine.name
        write_files(folder, rendered(machine, Scene(models=tuple(model.name for model in DERIVATIVES)), ("c",)))
        compiled(folder, tmp_path, compiler)


def massless(machine: Machine) -> Machine:
    last = replace(machine.joints[-1], body=Body(), rotor_inertia=machine.joints[0].gamma)
    return replace(machine, joints=(*machine.joints[:-1], last))


@pytest.mark.parametrize("name", [DIRECT, DIRECT_BY_P])
def test_singular_derivatives_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"joint 3.*H3 is zero") as refused:
        refuse_degenerate(massless(chain(3)), Scene(models=(name,)))
    assert "\n" not in str(refused.value)


def test_nothing_left_to_differentiate_by() -> None:
    for name in (INVERSE_BY_P, DIRECT_BY_P):
        with pytest.raises(InputError, match=r"parameters: nothing depends on a parameter .* fold fewer") as refused:
            trace_scene(planar_2r(), Scene(models=(name,), fold=ALL))
        assert "\n" not in str(refused.value)


def test_rules_of_differentiation() -> None:
    """Every operation, by mpmath's numerical derivative."""
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    cosine, sine = cosine_sine(graph, 2 * x)
    root = graph.node(SQRT, x * x + 1)
    made = (cosine - x / root) * sine + 1 / (y - root) + graph.node(ATAN2, y, x) * graph.node(SIGN, x) - graph.pi * x

    def function(x: Any, y: Any) -> Any:
        root = mp.sqrt(x * x + 1)
        return (mp.cos(2 * x) - x / root) * mp.sin(2 * x) + 1 / (y - root) + mp.atan2(y, x) * mp.sign(x) - mp.pi * x

    with workdps(50):
        at = {"x": mpf("-0.7"), "y": mpf("0.4")}
        for k, variable in enumerate((x, y)):
            found = Differentiation([made]).by(variable).of(made)
            value = evaluate([found], at, multiprecision(50))(found)
            expected = mp.diff(function, (at["x"], at["y"]), (1 - k, k))
            assert abs(value - expected) < mpf("1e-20")


def test_substitution() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    made = [x * y - graph.node(SQRT, x), y, 3]
    assert substitute(graph, made, {"x": y + 1}) == [(y + 1) * y - graph.node(SQRT, y + 1), y, 3]
