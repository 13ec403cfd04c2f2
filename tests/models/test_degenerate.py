"""Singular machines are found, all of them and no others, however well they hide."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mpmath
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import generate, refuse_degenerate, zero_pivots
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine, Parameter, Spring
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.checks.degenerate import degeneracies
from tests.compiled_models import cell as f
from tests.references import multiprecision as reference
from tests.references.random_machines import chain, first_joint_elastic, planar_2r, random_machine, two_children

pytestmark = pytest.mark.sampled(6)

ROOT = Path(__file__).parents[2]
PRINTED = ROOT / "examples" / "two_axis_printed.par"


HEAVY = Body(f(3), (f("0.1"), f("0.2"), f("-0.3")), tuple(f(x) for x in ("1.3", "0.1", "-0.2", "1.1", "0.15", "0.9")))
POINT = Body(f(2))
ANGLES = (
    *("0.37", "-1.2", "pi/3", "-pi/6", "2*pi/7", "pi/11", "-3*pi/13", "pi/37", "-2*pi/97", "pi/4 + 0.1", "pi/2"),
    *("atan2(3, 4)", "a1", "-2*a1", "a1 + pi/5", "1e-3", "3.1"),
)
LENGTHS = ("0.21", "-0.4", "L", "2*L", "1/3", "0", "sqrt(2)")
PARAMETERS = (Parameter("a1"), Parameter("L"), Parameter("m"), Parameter("K"))
VALUES = {"a1": 0.613, "L": 0.271, "m": 1.7, "K": 900}


@dataclass(frozen=True)
class Row:
    """The placement of a row, as texts."""

    gamma: str = "0"
    b: str = "0"
    alpha: str = "0"
    d: str = "0"
    theta: str = "0"
    r: str = "0"

    def undone(self) -> Row:
        """The inverse placement, a row as well: the six elementary screws in reverse."""
        gamma, b, alpha, d, theta, r = (f"-({x})" for x in (self.theta, self.r, self.alpha, self.d, self.gamma, self.b))
        return Row(gamma, b, alpha, d, theta, r)

    def joint(self, name: str, kind: Kind, sigma: int, body: Body, antecedent: int) -> Joint:
        cells = {key: f(getattr(self, key)) for key in ("gamma", "b", "alpha", "d", "theta", "r")}
        spring = Spring(f("K")) if kind == Kind.ELASTIC else Spring()
        return Joint(
            name, antecedent, kind, sigma, None if sigma == 2 else f"q_{name}", body=body, spring=spring, **cells
        )


def drawn(source: random.Random) -> Row:
    """A placement in general position."""
    turn, length = (lambda: source.choice(ANGLES)), (lambda: source.choice(LENGTHS))
    if source.random() < 0.4:
        return Row(alpha=turn(), d=length(), theta=turn(), r=length())
    return Row(turn(), length(), turn(), length(), turn(), length())


def serial(*rows: tuple[Row, Kind, int, Body]) -> Machine:
    """A chain of rows; `sigma` 2 rows are frames."""
    joints = [row.joint(f"j{k}", kind, sigma, body, k - 1) for k, (row, kind, sigma, body) in enumerate(rows, start=1)]
    return Machine("hidden", tuple(joints), PARAMETERS)


def inertia_is_singular(machine: Machine, seed: int = 0) -> bool:
    """Whether A(q) of the reference, which knows nothing of recursions, is singular to 50 digits at a random state."""
    source = random.Random(seed)
    with mpmath.workdps(50):
        matrix = mpmath.matrix(
            reference.inertia_matrix(machine, [source.uniform(-2, 2) for _ in machine.independent], VALUES)
        )
        scale = mpmath.fprod([max(abs(x) for x in matrix[k, :]) or 1 for k in range(matrix.rows)])
        return abs(mpmath.det(matrix)) < mpmath.mpf(10) ** -40 * scale


def blamed(machine: Machine, known_motors: bool = False) -> list[tuple[int, tuple[int, ...]]]:
    return [(d.joint, d.moving_together) for d in degeneracies(machine, known_motors)]


SOFT = (Kind.ELASTIC, Kind.PASSIVE, Kind.MOTOR)  # motors here have no rotor inertia


# The paper's table


def test_the_printed_table_is_refused_by_the_joints() -> None:
    machine, _ = read_machine(PRINTED)
    with pytest.raises(InputError) as caught:
        refuse_degenerate(machine, Scene())
    said = str(caught.value)
    assert said.startswith(
        f"{PRINTED}: joint 2, joint 3: H2 is zero at every position: joint 2 (bed_y) and joint 3 (bed_x)"
    )
    assert "parallel" in said and "k1 k2/(k1 + k2)" in said and said.endswith("the same holds for joint 7, joint 8")
    assert blamed(machine) == [(7, (7, 8)), (2, (2, 3))]
    assert blamed(machine, known_motors=True) == [(7, (7, 8)), (2, (2, 3))]
    assert [joints for _, joints in zero_pivots(machine, Scene())] == ["joint 2, joint 3", "joint 7, joint 8"]


def test_the_repaired_table_and_the_other_examples_are_regular() -> None:
    for name in ("two_axis.toml", "rx90.par", "puma560.par", "flex4.par", "planar_2r.toml"):
        machine, _ = read_machine(ROOT / "examples" / name)
        assert blamed(machine) == blamed(machine, known_motors=True) == []
        assert zero_pivots(machine, Scene(fold=ALL)) == []


@pytest.mark.parametrize("locked", [("bed_y", "cart_x"), ("bed_x", "cart_y")])
def test_locking_one_of_each_pair_mends_the_printed_table(locked: tuple[str, ...]) -> None:
    machine, _ = read_machine(PRINTED)
    assert zero_pivots(machine, Scene(locked=dict.fromkeys(locked, f("0.1")))) == []
    assert len(zero_pivots(machine, Scene(locked={locked[0]: ZERO}))) == 1


# Hidden parallel joints


@pytest.mark.sampled(12)
@pytest.mark.parametrize("seed", range(120))
def test_joints_on_one_axis_hidden_by_frames(seed: int) -> None:
    """Placements between two joints that undo each other: same axis, whatever the angles; massless between."""
    source = random.Random(seed)
    sigma, kinds = source.choice((0, 1)), [source.choice(SOFT) for _ in range(2)]
    between = [drawn(source) for _ in range(source.randint(1, 2))]
    back = [row.undone() for row in reversed(between)]
    along = Row(gamma=source.choice(ANGLES), b=source.choice(LENGTHS))  # about and along the axis: still the same one
    frames = [*between, *back]
    last = frames.pop() if source.random() < 0.5 else Row()
    lead = [(drawn(source), Kind.MOTOR, source.choice((0, 1)), HEAVY)] if source.random() < 0.5 else []
    rows = [
        *lead,
        (drawn(source), kinds[0], sigma, Body()),
        (along, Kind.FIXED, 2, Body()),
        *((row, Kind.FIXED, 2, Body()) for row in frames),
        (last, kinds[1], sigma, Body()),
        (drawn(source), Kind.FIXED, 2, HEAVY),
        (drawn(source), Kind.MOTOR, 0, HEAVY),
    ]
    machine = serial(*rows)
    first, second = 1 + len(lead), len(rows) - 2
    assert inertia_is_singular(machine)
    assert blamed(machine) == [(first, (first, second))]
    inverse = [(first, (first, second))] if Kind.MOTOR not in kinds else []
    assert blamed(machine, known_motors=True) == inverse


@pytest.mark.parametrize("seed", range(60))
def test_nearly_the_same_axis_is_no_alarm(seed: int) -> None:
    """The same, one angle a billionth off."""
    source = random.Random(seed)
    sigma = source.choice((0, 1))
    row = drawn(source)
    other = replace(row.undone(), alpha=f"{row.undone().alpha} + 1e-9")
    rows = [
        (Row(), Kind.ELASTIC, sigma, Body()),
        (row, Kind.FIXED, 2, Body()),
        (other, Kind.ELASTIC, sigma, HEAVY),
    ]  # fmt: skip
    assert blamed(serial(*rows)) == []
    assert blamed(serial(rows[0], rows[1], (row.undone(), Kind.ELASTIC, sigma, HEAVY))) == [(1, (1, 3))]


@pytest.mark.parametrize("angle", ["pi/11", "pi/37", "2*pi/41", "pi/97", "5*pi/1009"])
def test_prismatic_axes_parallel_after_three_turns(angle: str) -> None:
    """x + x = 2 x, for multiples of pi too that have no image of their order modulo the prime."""
    rows = [
        (Row(), Kind.ELASTIC, 1, Body()),
        (Row(alpha=angle), Kind.FIXED, 2, Body()),
        (Row(alpha=angle), Kind.FIXED, 2, Body()),
        (Row(alpha=f"-2*({angle})"), Kind.PASSIVE, 1, HEAVY),
    ]
    assert blamed(serial(*rows)) == [(1, (1, 4))]
    assert blamed(serial(*rows[:3], (Row(alpha=f"-({angle})"), Kind.PASSIVE, 1, HEAVY))) == []


@pytest.mark.parametrize("body", [Body(), POINT], ids=["massless", "mass on the axis"])
def test_parallel_revolute_joints_apart_are_regular(body: Body) -> None:
    rows = [(Row(), Kind.ELASTIC, 0, body), (Row(d="L"), Kind.ELASTIC, 0, HEAVY)]
    assert blamed(serial(*rows)) == []
    assert blamed(serial(rows[0], (Row(b="L"), Kind.ELASTIC, 0, HEAVY))) == [(1, (1, 2))]


# One joint that moves nothing


MASS_ON_AXIS = {
    "massless": (Row(), Body()),
    "point at the origin": (Row(), POINT),
    "points along the axis": (Row(), Body(f(2), (ZERO, ZERO, f(1)), tuple(f(x) for x in ("0.7", 0, 0, "0.7", 0, 0)))),
    "in a frame on the axis": (Row(r="0.3", alpha="0"), POINT),
    "in a frame beside the axis": (
        Row(d="L"),
        Body(f("m"), (f("-m*L"), ZERO, ZERO), (ZERO, ZERO, ZERO, f("m*L^2"), ZERO, f("m*L^2"))),
    ),
    "about its centre, in a turned frame beside the axis": (
        Row(gamma="0.3", alpha="pi/2", d="L"),
        Body(f("m"), (f("-L"), ZERO, ZERO), (ZERO,) * 6, central=True),
    ),
}


@pytest.mark.parametrize("kind", SOFT)
@pytest.mark.parametrize("name", MASS_ON_AXIS)
def test_mass_on_the_axis_of_a_revolute_leaf(name: str, kind: Kind) -> None:
    row, body = MASS_ON_AXIS[name]
    machine = serial(
        (Row(alpha="0.4"), Kind.MOTOR, 0, HEAVY),
        (Row(alpha="pi/3", d="0.2"), kind, 0, Body()),
        (row, Kind.FIXED, 2, body),
    )
    assert inertia_is_singular(machine)
    assert blamed(machine) == [(2, (2,))]
    assert blamed(machine, known_motors=True) == ([] if kind == Kind.MOTOR else [(2, (2,))])
    ((message, joints),) = zero_pivots(machine, Scene())
    assert joints == "joint 2" and "inertia about this axis" in message
    moved = replace(machine.joints[1], sigma=1)
    sliding = replace(machine, joints=(machine.joints[0], moved, machine.joints[2]))
    assert blamed(sliding) == ([(2, (2,))] if name == "massless" else [])


def test_a_rotor_makes_it_regular() -> None:
    machine = serial((Row(), Kind.MOTOR, 0, HEAVY), (Row(alpha="0.4"), Kind.MOTOR, 1, Body()))
    assert blamed(machine) == [(2, (2,))]
    with_rotor = replace(machine.joints[1], rotor_inertia=f("m"))
    assert blamed(replace(machine, joints=(machine.joints[0], with_rotor))) == []


# Too many joints for what they move


def spread(count: int, sigma: int, row: Row, body: Body, seed: int = 0) -> Machine:
    """Elastic joints in general position (or in that of `row`), massless but for the last."""
    source = random.Random(seed)
    rows = [(row if row != Row() else drawn(source), Kind.ELASTIC, sigma, Body()) for _ in range(count)]
    return serial(*rows[:-1], (*rows[-1][:3], body))


@pytest.mark.parametrize(
    ("machine", "singular"),
    [
        (spread(4, 1, Row(), HEAVY), True),  # four translations in space
        (spread(3, 1, Row(alpha="pi/3", theta="0.2"), HEAVY), False),
        (spread(3, 1, Row(alpha="pi/3"), HEAVY), True),  # three translations in a plane
        (spread(4, 0, Row(alpha="0.7", theta="0.2"), HEAVY), True),  # four axes through a point
        (spread(3, 0, Row(alpha="0.7", theta="0.2"), HEAVY), False),
        (spread(4, 0, Row(d="L"), HEAVY), True),  # four parallel axes
        (spread(3, 0, Row(d="L"), HEAVY), False),
        (spread(3, 0, Row(d="L"), Body(f(2), (f(1), ZERO, ZERO), (ZERO, ZERO, ZERO, f("0.5"), ZERO, f("0.5")))), True),
        (spread(7, 0, Row(), HEAVY), True),  # seven joints for a body
        (spread(6, 0, Row(), HEAVY), False),
    ],
)
def test_more_joints_than_motions(machine: Machine, singular: bool) -> None:
    n = len(machine.joints)
    assert inertia_is_singular(machine) == singular
    assert blamed(machine) == ([(1, tuple(range(1, n + 1)))] if singular else [])


def test_singularities_in_branches_are_all_found() -> None:
    rows = [
        Row().joint("base", Kind.MOTOR, 0, HEAVY, 0),
        Row(alpha="0.3").joint("a1", Kind.ELASTIC, 1, Body(), 1),
        Row(d="L").joint("a2", Kind.ELASTIC, 1, HEAVY, 2),
        Row(alpha="-0.3").joint("b1", Kind.ELASTIC, 0, Body(), 1),
        Row(b="0.2").joint("b2", Kind.PASSIVE, 0, HEAVY, 4),
        Row(alpha="1").joint("leaf", Kind.PASSIVE, 0, Body(), 5),
    ]
    machine = Machine("branches", tuple(rows), PARAMETERS)
    assert sorted(blamed(machine)) == [(2, (2, 3)), (4, (4, 5)), (6, (6,))]
    with pytest.raises(InputError, match=r"the same holds for joint 4, joint 5; the same holds for joint 6$"):
        refuse_degenerate(machine, Scene())


# What is asked decides


def test_the_inverse_model_alone_needs_no_inertia_of_motors(tmp_path: Path) -> None:
    machine = serial((Row(), Kind.MOTOR, 0, Body()), (Row(r="0.1"), Kind.ELASTIC, 0, HEAVY))
    assert blamed(machine) == [(1, (1, 2))]
    assert blamed(machine, known_motors=True) == []
    generate(machine, Scene(models=("inverse_dynamics", "inertia_matrix", "bias_forces")), ["c"], tmp_path)
    with pytest.raises(InputError, match="hidden: joint 1, joint 2: H1 is zero"):
        generate(machine, Scene(models=("inverse_dynamics", "direct_dynamics")), ["c"], tmp_path / "refused")
    assert not (tmp_path / "refused").exists()


def test_models_without_division_are_given_for_singular_machines(tmp_path: Path) -> None:
    machine, _ = read_machine(PRINTED)
    asked = Scene(models=("inertia_matrix", "bias_forces", "geometric_model"))
    assert len(generate(machine, asked, ["c"], tmp_path).models) == 3


def test_values_that_are_folded_decide_too() -> None:
    """alpha = a1 is general, a1 = 0 is not; a mass m is one, m = 0 is none."""
    machine = serial((Row(), Kind.ELASTIC, 1, Body()), (Row(alpha="a1"), Kind.ELASTIC, 1, HEAVY))
    valued = replace(machine, parameters=(Parameter("a1", f(0)), Parameter("K", f(1))))
    assert zero_pivots(valued, Scene()) == []
    assert len(zero_pivots(valued, Scene(fold=("a1",)))) == 1
    leaf = serial((Row(), Kind.ELASTIC, 1, Body(f("m"))))
    without = replace(leaf, parameters=(Parameter("m", f(0)), Parameter("K", f(1))))
    assert zero_pivots(without, Scene()) == []
    assert len(zero_pivots(without, Scene(fold=ALL))) == 1


# No false alarms


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("first", range(0, 300, 50))
def test_regular_trees_raise_no_alarm(first: int) -> None:
    for seed in range(first, first + 50):
        machine = random_machine(seed, joints=2 + seed % 11, symbolic=seed % 3 == 0, massless=0.5)
        assert blamed(machine) == [], seed
        assert blamed(machine, known_motors=True) == [], seed


@pytest.mark.parametrize(
    "machine", [chain(6), first_joint_elastic(), planar_2r(elastic=(1, 2)), two_children()], ids=lambda m: m.name
)
def test_known_machines_raise_no_alarm(machine: Machine) -> None:
    assert blamed(machine) == blamed(machine, known_motors=True) == []


def test_messages_are_one_line_and_name_a_cure() -> None:
    cases: Sequence[tuple[Machine, str]] = [
        (serial((Row(), Kind.PASSIVE, 1, Body())), "geometry and kinematics (geometric_model, jacobian"),
        (serial((Row(), Kind.MOTOR, 0, HEAVY), (Row(), Kind.PASSIVE, 1, Body())), "give a body beyond it mass"),
        (serial((Row(), Kind.PASSIVE, 0, POINT)), "inertia about this axis"),
        (spread(2, 1, Row(d="L"), HEAVY), "one of stiffness k1 k2/(k1 + k2)"),
        (spread(4, 1, Row(), HEAVY), "what lies between is massless"),
        (serial((Row(), Kind.PASSIVE, 1, Body()), (Row(), Kind.ELASTIC, 1, HEAVY)), "merge them"),
    ]
    for machine, cure in cases:
        ((message, _),) = zero_pivots(machine, Scene())
        assert cure in message and "\n" not in message and ("j1" in message or "bod" in message)
