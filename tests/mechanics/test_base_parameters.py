"""Base inertial parameters by rules: counts, torques and formulas, against the rank of the regressor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.formats import read_machine, write_machine
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine, Parameter, Spring, Vector3
from symoro_elastic.mechanics.base_parameters import CarriedMotion
from symoro_elastic.mechanics.spatial import Twist, Vector
from symoro_elastic.models.parameters.base_parameters import (
    GROUPED,
    KEPT,
    NO_EFFECT,
    POLYNOMIALS,
    Polynomial,
    base_grouping,
    polynomial_text,
)
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.linear.grouping import checked_grouping
from symoro_elastic.numerics.linear.rank import cross_check
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from tests.examples import example
from tests.references.random_machines import chain, planar_2r, random_machine, random_state, two_children

pytestmark = pytest.mark.sampled(6)

INERTIA = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
TORQUES = 1e-12

REVOLUTE, PRISMATIC, FIXED = 0, 1, 2
ALONG_Z: Vector3 = (ZERO, ZERO, Formula.parse("-9.81"))
ALONG_Y: Vector3 = (ZERO, Formula.parse("-9.81"), ZERO)
OBLIQUE: Vector3 = (Formula.parse(3), Formula.parse("-2"), Formula.parse("-9"))
WEIGHTLESS: Vector3 = (ZERO, ZERO, ZERO)


def body(j: int) -> Body:
    """General inertial parameters by name."""
    f = Formula.parse
    six = tuple(f(f"{name}{j}") for name in INERTIA)
    return Body(f(f"M{j}"), (f(f"MX{j}"), f(f"MY{j}"), f(f"MZ{j}")), six)  # type: ignore[arg-type]


def robot(rows: Sequence[tuple[int, str, str, str]], gravity: Vector3, rotors: bool = True) -> Machine:
    """A chain of motors from (sigma, alpha, d, r or theta); all inertial parameters are names without value."""
    f = Formula.parse
    joints = []
    for j, (sigma, alpha, d, other) in enumerate(rows, start=1):
        rotor = f(f"IA{j}") if rotors and sigma != FIXED else ZERO
        cells = {"theta" if sigma == PRISMATIC else "r": f(other)}
        kind, variable = (Kind.FIXED, None) if sigma == FIXED else (Kind.MOTOR, f"q{j}")
        joint = Joint(f"j{j}", j - 1, kind, sigma, variable, alpha=f(alpha), d=f(d), body=body(j), rotor_inertia=rotor)
        joints.append(replace(joint, **cells))
    used = sorted({name for joint in joints for cell in (joint.d, joint.r, joint.alpha) for name in cell.names})
    names = [f"{name}{j}" for j in range(1, len(rows) + 1) for name in (*INERTIA, "MX", "MY", "MZ", "M", "IA")]
    return Machine("robot", tuple(joints), tuple(Parameter(name) for name in (*names, *used)), Base(gravity))


def bare(machine: Machine) -> Machine:
    """The machine without rotor inertias."""
    return replace(machine, joints=tuple(replace(joint, rotor_inertia=ZERO) for joint in machine.joints))


R, P = REVOLUTE, PRISMATIC
GENERIC_6R = [(R, "0", "0", "0"), *((R, f"A{j}", f"D{j}", f"R{j}") for j in range(2, 7))]
PLANAR_3R = [(R, "0", "0", "0"), (R, "0", "L1", "0"), (R, "0", "L2", "0")]
SCARA = [(R, "0", "0", "0"), (R, "0", "L1", "0"), (P, "0", "L2", "0"), (R, "0", "0", "0")]
PPP = [(P, "0", "0", "0"), (P, "pi/2", "0", "pi/2"), (P, "pi/2", "0", "0")]
PPR = [(P, "0", "0", "0"), (P, "pi/2", "0", "0"), (R, "pi/2", "0", "0")]
RPPP = [(R, "0", "0", "0"), (P, "0", "0", "0"), (P, "pi/2", "0", "pi/2"), (P, "pi/2", "0", "0")]

KNOWN = [
    pytest.param(example("rx90.par"), 36, 40, id="RX90"),
    pytest.param(example("puma560.par"), 36, 40, id="PUMA 560"),
    pytest.param(robot(GENERIC_6R, OBLIQUE), 38, 43, id="generic 6R"),
    pytest.param(robot(PLANAR_3R, ALONG_Z), 7, 9, id="planar 3R, axes along gravity"),
    pytest.param(robot(PLANAR_3R, ALONG_Y), 9, 11, id="planar 3R, gravity in the plane"),
    pytest.param(robot(SCARA, ALONG_Z), 8, 11, id="SCARA"),
    pytest.param(robot(PPP, ALONG_Z), 3, 4, id="PPP"),
    pytest.param(robot(PPR, ALONG_Z), 5, 6, id="PPR"),
    pytest.param(robot(RPPP, OBLIQUE), 10, 13, id="R-PPP"),
    # the prismatic joint is parallel to the revolute one and perpendicular to gravity: its rotor joins its mass
    pytest.param(robot(RPPP, ALONG_Y), 10, 12, id="R-PPP, gravity across the axis"),
    # all axes meet and nothing weighs: first moments have no effect
    pytest.param(
        robot([(R, "0", "0", "0"), (R, "pi/2", "0", "0"), (R, "-pi/2", "0", "0")], WEIGHTLESS),
        11,
        12,
        id="axes that meet, no gravity",
    ),
]


@pytest.mark.parametrize(("machine", "without", "with_rotors"), KNOWN)
def test_known_counts(machine: Machine, without: int, with_rotors: int) -> None:
    assert (base_grouping(bare(machine)).count, base_grouping(machine).count) == (without, with_rotors)
    for each in (bare(machine), machine):
        found = cross_check(each, base_grouping(each))
        assert found.agrees, found.message


def aligned_tree(seed: int) -> Machine:
    """A random tree of quarter turns, angles that cancel, zero lengths, and gravity along axes or absent."""
    rng = np.random.default_rng([seed, 77])
    turns = ["0", "0", "0", "pi/2", "-pi/2", "pi", "0.37", "-0.37", "pi/3"]
    inclinations = ["0"] * int(rng.choice([1, 6])) + ["pi", "pi/2", "-pi/2", "pi/2", "0.37", "-0.37", "pi/3"]
    slides, frames, straight = rng.choice([0.0, 0.2, 0.5, 0.8]), rng.choice([0, 0.1, 0.25]), rng.choice([0.3, 0.7, 1])
    numeric = rng.random() < 0.3
    parameters: list[Parameter] = []

    def cell(name: str, low: float = -1) -> Formula:
        value = Formula.parse(float(f"{rng.uniform(low, 2):.4g}"))
        parameters.extend([] if numeric else [Parameter(name, value)])
        return value if numeric else Formula.parse(name)

    def length() -> Formula:
        return ZERO if rng.random() < straight else Formula.parse(round(float(rng.uniform(-0.5, 0.5)), 3))

    def angle(among: list[str]) -> Formula:
        return Formula.parse(str(rng.choice(among)))

    joints = []
    for j in range(1, int(rng.integers(1, 9)) + 1):
        sigma = FIXED if rng.random() < frames else int(rng.random() < slides)
        kind = (
            Kind.FIXED
            if sigma == FIXED
            else Kind(rng.choice([Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE], p=[0.7, 0.2, 0.1]))
        )
        general = Body(
            cell(f"M{j}", 0.2),
            (cell(f"MX{j}"), cell(f"MY{j}"), cell(f"MZ{j}")),
            tuple(cell(f"{name}{j}") for name in INERTIA),  # type: ignore[arg-type]
        )
        branch = rng.random() < 0.3
        joints.append(
            Joint(
                f"j{j}",
                int(rng.integers(0, j)) if rng.random() < 0.25 else j - 1,
                kind,
                sigma,
                None if sigma == FIXED else f"q{j}",
                gamma=angle(turns) if branch else ZERO,
                b=length() if branch else ZERO,
                alpha=angle(inclinations),
                d=length(),
                theta=angle(turns),
                r=length(),
                body=general if rng.random() < 0.9 else Body(),
                spring=Spring(Formula.parse(100)) if kind is Kind.ELASTIC else Spring(),
                rotor_inertia=cell(f"IA{j}", 0.2) if kind is Kind.MOTOR and rng.random() < 0.85 else ZERO,
            )
        )
    gravity = [WEIGHTLESS, ALONG_Z, ALONG_Y, OBLIQUE][rng.choice(4, p=[0.25, 0.4, 0.2, 0.15])]
    base = Base(gravity, velocity=OBLIQUE) if rng.random() < 0.1 else Base(gravity)
    return Machine(f"aligned{seed}", tuple(joints), tuple(parameters), base)


def trees() -> list[Machine]:
    random_trees = [
        random_machine(seed, joints=3 + seed % 8, symbolic=seed % 2 == 0, moving_base=seed % 5 == 4)
        for seed in range(20)
    ]
    return [*map(aligned_tree, range(40)), *random_trees, chain(6), chain(5, prismatic=(2, 4)), two_children()]


TREES = [pytest.param(machine, id=f"{machine.name}-{k}") for k, machine in enumerate(trees())]


@pytest.mark.parametrize("machine", TREES)
def test_count_is_the_rank_and_torques_stay(machine: Machine) -> None:
    """And the regrouped machine is in order, and does not change when it is grouped again."""
    grouping = base_grouping(machine)
    found = cross_check(machine, grouping)
    assert found.agrees, found.message
    assert found.count == found.rank
    assert found.torque_error < TORQUES
    check(grouping.machine)
    assert base_grouping(grouping.machine).machine.joints == grouping.machine.joints


@pytest.mark.parametrize("suffix", ["toml", "par"])
@pytest.mark.parametrize("machine", [example("rx90.par"), example("planar_2r.toml"), chain(6), two_children()])
def test_regrouped_machine_is_written_and_read(machine: Machine, suffix: str, tmp_path: Path) -> None:
    regrouped = base_grouping(machine).machine
    assert regrouped.is_grouped
    path = tmp_path / f"machine.{suffix}"
    write_machine(regrouped, path)
    assert replace(read_machine(path)[0], source="") == replace(DescribedMachine.of(regrouped), source="")


def test_motions_about_a_point_of_the_axis_have_no_pitch() -> None:
    """A turn about the point at height h on the axis moves the origin by h (w_y, -w_x)."""

    def twist(x: int, y: int, z: int, *, height: int, pitch: int = 0, lift: int = 0) -> Twist:
        return Twist(Vector(height * y + pitch * x, pitch * y - height * x, lift), Vector(x, y, z))

    def is_about_a_point(*twists: Twist) -> bool:
        return CarriedMotion(twists, Vector(0, 0, 0)).about_a_point_of_axis

    other = twist(3, 1, -5, height=2)
    assert is_about_a_point(twist(-1, 2, 4, height=2), other)
    for first in (
        *(twist(-1, 2, 4, height=3), twist(-1, 2, 4, height=2, lift=1)),
        *(twist(x, y, 4, height=2, pitch=1) for x, y in ((-1, 2), (0, 2), (-1, 0))),
    ):
        assert not is_about_a_point(first, other) and not is_about_a_point(other, first)
    for x, y in ((1, 0), (0, 1), (2, -3)):
        assert not is_about_a_point(*(twist(k * x, k * y, 0, height=0, pitch=1) for k in (1, 2)))


def test_formulas_of_rx90() -> None:
    """As printed by SYMORO+."""
    formulas = base_grouping(example("rx90.par")).formulas
    assert formulas["ZZR1"] == "ZZ1 + YY2 + YY3 + IA1 + D3^2*(M3 + M4 + M5 + M6)"
    assert formulas["XXR2"] == "XX2 - YY2 - D3^2*(M3 + M4 + M5 + M6)"
    assert formulas["XZR2"] == "XZ2 - D3*MZ3"
    assert formulas["MYR3"] == "MY3 + MZ4 + RL4*(M4 + M5 + M6)"
    assert formulas["MX3"] == "MX3"
    assert "MZ4" not in formulas
    effects = base_grouping(example("rx90.par")).effects
    assert (effects[3, "MX"], effects[4, "MZ"], effects[1, "XX"]) == (KEPT, GROUPED, NO_EFFECT)


def test_names_that_are_taken_are_left_alone() -> None:
    rx90 = example("rx90.par")
    first = replace(rx90.joints[0], r=Formula.parse("ZZR1"))
    taken = replace(rx90, joints=(first, *rx90.joints[1:]), parameters=(*rx90.parameters, Parameter("ZZR1")))
    regrouped = base_grouping(taken)
    assert regrouped.machine.joints[0].body.inertia[5] == Formula.parse("ZZRR1")
    check(regrouped.machine)


def test_parameters_get_values_where_the_machine_gives_all() -> None:
    valued = base_grouping(chain(3)).machine
    assert all(parameter.value is not None for parameter in valued.parameters)
    known = {parameter.name: parameter.value.value() for parameter in chain(3).parameters if parameter.value}
    values = base_grouping(chain(3)).values(known)
    assert values["XXR3"] == pytest.approx(known["XX3"] - known["YY3"], rel=1e-15)
    rx90 = base_grouping(example("rx90.par")).machine
    assert all(parameter.value is None for parameter in rx90.parameters)
    assert {"D3", "RL4", "G3", "XXR2"} <= {parameter.name for parameter in rx90.parameters}
    assert not {"M1", "MZ4", "YY3"} & {parameter.name for parameter in rx90.parameters}


@pytest.mark.thorough
def test_long_formulas_are_split() -> None:
    """A long chain of general angles: sums on their way get names, and everything stays small."""
    grouping = base_grouping(chain(30))
    assert grouping.composites
    assert max(map(len, grouping.formulas.values())) <= 1000
    assert cross_check(chain(30), grouping).agrees


@pytest.mark.parametrize(("name", "products", "sums"), [("rx90.par", 253, 237), ("puma560.par", 279, 261)])
def test_inverse_model_with_base_parameters_is_no_longer_than_that_of_symoro(
    name: str, products: int, sums: int
) -> None:
    count = trace(base_grouping(example(name)).machine, "inverse_dynamics").program.count
    assert count.products <= products
    assert count.add <= sums


@pytest.mark.parametrize("seed", range(8))
def test_direct_model_stays(seed: int) -> None:
    machine = random_machine(seed, joints=6, symbolic=seed % 2 == 0)
    q, qd, tau = random_state(machine, seed)

    def accelerations(each: Machine) -> list[float]:
        program = trace(each, "direct_dynamics").program
        arithmetic = multiprecision(50)
        symbols = {p.name: arithmetic.number(p.value.value()) for p in each.parameters if p.value}
        for argument, numbers in zip(program.inputs, (q, qd, tau), strict=True):
            symbols |= zip(argument.symbols, map(arithmetic.number, numbers), strict=True)
        value = evaluate(program.outputs[0].entries, symbols, arithmetic)
        return [float(value(x)) for x in program.outputs[0].entries]

    before, after = accelerations(machine), accelerations(base_grouping(machine).machine)
    assert after == pytest.approx(before, rel=1e-12, abs=1e-12 * max(map(abs, before)))


def test_conditioning_names_the_weakest() -> None:
    machine = example("rx90.par")
    found = cross_check(machine, base_grouping(machine)).conditioning
    assert 1 < found.condition < 100
    assert list(found.distinct.values()) == sorted(found.distinct.values())
    assert len(found.distinct) == 40 and all(0 < part <= 1 for part in found.distinct.values())


def test_polynomials_are_written_in_the_grammar_of_machine_files() -> None:
    a, b, m, n = map(Polynomial.factor, ("a", "b", "m", "n"))
    assert polynomial_text(m - a * a * (m + n) * 2, {"m", "n"}) == "m - 2*a^2*(m + n)"
    assert polynomial_text(a * (m - 3 * n), {"m", "n"}) == "a*(m - 3*n)"
    assert polynomial_text(-a) == "-a"
    assert polynomial_text(a - a) == "0"
    assert polynomial_text((a - b) / (b - a) / 3) == "1/3*(1/(b - a))*a - 1/3*(1/(b - a))*b"
    assert polynomial_text(1 / (a + 1) - 1) == "(1/(a + 1)) - 1"
    half = POLYNOMIALS.operations["sin"](POLYNOMIALS.number(1) / 2 * a)
    values = {"a": 0.3, "b": 0.7}
    assert Formula.parse(polynomial_text(half * half + a / b)).value(values) == pytest.approx(np.sin(0.15) ** 2 + 3 / 7)


def test_labels_are_no_names_of_other_quantities() -> None:
    """A table that calls the first moments of joint 2 MX1 and MY1, as those of joint 1 are called elsewhere."""
    rows = planar_2r()
    first, second = rows.joints
    moments = (Formula.parse("MX1"), Formula.parse("ZZ1"), Formula.parse(0))
    swapped = replace(rows, joints=(first, replace(second, body=replace(second.body, moments=moments))))
    grouping = base_grouping(swapped)
    own = {parameter.name for parameter in swapped.parameters}
    for parameter in grouping.parameters:
        assert parameter.name not in own or parameter.formula.text == parameter.name
    assert {grouping.labels[2, "MX"], grouping.labels[2, "MY"]} == {"MX_2", "MY_2"}
    assert grouping.formulas["MX_2"] == "MX1" and grouping.formulas["MY_2"] == "ZZ1"
    check(grouping.machine)


def test_every_base_parameter_has_one_label() -> None:
    """Those that are zero too, and the conditioning calls each as the list does."""
    for name in ("planar_2r.toml", "rx90.par"):
        grouping, found = checked_grouping(example(name))
        named = {parameter.name for parameter in grouping.parameters}
        assert len(named) + len(grouping.zero) == grouping.count == len(set(grouping.labels.values()))
        assert found.conditioning.distinct.keys() == named | set(grouping.zero)
