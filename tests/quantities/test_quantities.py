"""Every quantity of generated code has one row, and whatever says something of it reads that row."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import pytest

from symoro_elastic.codegen.latex import arrays
from symoro_elastic.codegen.notation import Notation
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import KnownOfBase, Machine, Orientation
from symoro_elastic.machine.names import why_reserved
from symoro_elastic.machine.restrict import under_forces
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.dynamics import SingularPivot
from symoro_elastic.mechanics.lagrange import inertia_matrix
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Joints, Model, Result, Results
from symoro_elastic.models.bound.naming import name_composites
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.programs.catalogue import MODELS, TracedModel, trace
from symoro_elastic.models.steps.implicit_steps import base_models, implicit_system
from symoro_elastic.models.steps.time_steps import ways_to_give_motors
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.pages.equations.page import html_page, latex_document
from symoro_elastic.quantities import (
    INTERMEDIATES,
    PREFIXES,
    QUANTITIES,
    Intermediate,
    Quantity,
    Role,
    citation,
    is_intermediate,
    quantity,
)
from symoro_elastic.quantities.units import FORCE, POSITION, VELOCITY, Unit, quotient, same
from symoro_elastic.symbolic.program import Section
from tests.analysis.vibration.machines import drive
from tests.closed_chains.machines import machine as closed_chain
from tests.command_line import run
from tests.generated_code import rendered
from tests.models.test_feed_forward import with_springs
from tests.models.test_floating_base import on
from tests.references.controlled import controlled
from tests.references.random_machines import chain, planar_2r, random_machine

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.toml")) + sorted(
    (Path(__file__).resolve().parents[2] / "examples").glob("*.par")
)


# A toy model with a quantity of its own, in this file only

MOMENTUM = Quantity(
    name="L",
    meaning="generalised momenta",
    symbol=r"\mathcal{L}",
    unit=Unit("kg m2/s", "kg m/s"),
    shape="n",
    roles=(Role.RESULT,),
)
SHARE = Intermediate(
    "mom", "number", r"\mu", "", "@,#", "", (8,), None, "momentum of joint j that the velocity of joint i gives"
)


def _momenta(bound: Bound, asked: Joints) -> Results:
    composites = inertia_matrix(bound.mechanism)
    name_composites(bound, composites)
    shares = {(j, i): composites.A[j][i] * bound.qd[i] for j in asked for i in bound.machine.independent}
    for (j, i), x in shares.items():
        bound.names.give(x, f"mom{j}_{i}", Section("Momenta", j, "[8]"))
    return {"L": Result(asked, tuple(sum(x for (j, _), x in shares.items() if j == row) for row in asked))}


@pytest.fixture
def momenta(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    monkeypatch.setitem(QUANTITIES, "L", MOMENTUM)
    model = Model("momenta", "generalised momenta", "[8]", ("q", "qd"), ("L",), _momenta, family="toys")
    monkeypatch.setitem(MODELS, model.name, model)
    INTERMEDIATES.append(SHARE)
    yield "momenta"
    INTERMEDIATES.remove(SHARE)


def test_a_new_quantity_is_listed(momenta: str) -> None:
    listed = json.loads(run("models", "--json").stdout)["models"][momenta]
    assert listed["results"] == {"L": ["n", "generalised momenta, kg m2/s or kg m/s"]}
    assert listed["family"] == "toys" and list(listed["arguments"]) == ["q", "qd"]
    assert momenta in run("models").stdout


def test_a_new_quantity_is_in_docstrings_and_header(momenta: str) -> None:
    files = rendered(planar_2r(), Scene((momenta,)))
    for file in ("__init__.py", "planar_2r.h"):
        assert "-> L (2): generalised momenta, kg m2/s or kg m/s" in files[file], file
    assert "mom2_1" in files["_momenta.py"] and "mom2_1" in files["planar_2r.c"]


def test_a_new_quantity_has_a_symbol(momenta: str) -> None:
    package = programs(planar_2r(), Scene((momenta,))).package
    text = latex_document(package, package.functions[0])
    assert r"\mathcal{L}_{2}" in text and r"\mu_{2,1}" in text and SHARE.meaning in text
    assert html_page(package, package.functions[0]).count("generalised momenta") >= 2


def test_names_of_a_new_quantity_are_refused_or_avoided(momenta: str) -> None:
    """Intermediates and models are refused as names of users; a result is not, generated code avoids it."""
    assert why_reserved("mom2_1") and why_reserved(momenta, reserved_words())
    machine = planar_2r()
    renamed = replace(machine, joints=(replace(machine.joints[0], variable="L"), *machine.joints[1:]))
    assert verify(renamed, Scene((momenta,)), states=(2, 1)).ok


def test_a_new_model_is_verified(momenta: str) -> None:
    assert verify(planar_2r(), Scene((momenta,)), states=(2, 2)).ok


def test_the_toy_is_gone() -> None:
    assert "momenta" not in MODELS and "L" not in QUANTITIES and why_reserved("mom2_1") is None


# Rows of what models use


@dataclass(frozen=True)
class Found:
    """Rows that stand for the names of all machines, and the names that are none's or several rows'."""

    rows: frozenset[Intermediate]
    prefixes: frozenset[str]
    wrong: tuple[str, ...]


def machines() -> list[Machine]:
    """The examples, 8 random machines on fixed, moving and floating bases, and one for each model that is choosy."""
    kinds = [("motor",), ("motor", "elastic", "passive", "fixed"), ("motor", "elastic")]
    fixed = [
        random_machine(
            seed, joints=2 + seed % 3, kinds=kinds[seed % 3], symbolic=seed % 2 == 0, moving_base=seed % 4 == 1
        )
        for seed in range(5)
    ]
    floating = [
        on(
            random_machine(seed, joints=2 + seed % 2, symbolic=True),
            tuple(KnownOfBase)[seed % 2],
            turned=tuple(Orientation)[seed // 2 % 2],
        )
        for seed in range(20, 23)
    ]
    springs = with_springs(chain(3, elastic=()), [2], 1)
    closed = [closed_chain("ring"), closed_chain("spatial_four_bar")]
    return [*(read_machine(path)[0] for path in EXAMPLES), controlled(), *fixed, *floating, drive(), springs, *closed]


def traces() -> Iterator[tuple[Machine, TracedModel]]:
    for machine in machines():
        for name in MODELS:
            if MODELS[name].columns and len(machine.independent) > 8:
                continue  # derivatives of long machines have the names of those of short ones
            try:
                yield machine, trace(machine, name, grouping_of=grouping_by_rank)
            except (InputError, SingularPivot):
                continue
        if machine.independent and not machine.floating:
            yield (
                machine,
                trace(under_forces(machine, [machine.joint(machine.independent[-1]).name]), "external_forces"),
            )
        if machine.independent and len(machine.independent) < 8 and _takes_steps(machine):
            for motors in ways_to_give_motors(machine):
                yield from ((machine, one) for one in implicit_system(machine, motors))
            yield from ((machine, one) for one in (base_models(machine) if machine.floating else ()))


def _takes_steps(machine: Machine) -> bool:
    return machine.floating is None or machine.floating.known is KnownOfBase.WRENCH


@cache
def rows_of(name: str) -> tuple[Intermediate, ...]:
    return tuple(row for row in INTERMEDIATES if row.match(name))


@cache
def found() -> Found:
    rows: set[Intermediate] = set()
    prefixes, wrong = set(), []
    for machine, traced in traces():
        program, outputs = traced.program, set(traced.results)
        variables = {str(machine.joint(j).variable) for j in machine.with_variable}
        given = [x for argument in program.inputs for x in argument.symbols]
        for name in (*(s.name for s in (*program.once, *program.statements)), *given):
            prefix = next((prefix for prefix in PREFIXES if name.startswith(prefix)), "")
            matching = [row for row in rows_of(name) if not row.of_results or outputs & {*row.of_results}]
            prefixes.add(prefix)
            rows.update(matching)
            if len(matching) + bool(prefix) != 1 and name not in variables:
                wrong.append(f"{traced.model.name}: {name}: {len(matching)} rows")
    return Found(frozenset(rows), frozenset(prefixes), tuple(wrong))


@pytest.mark.thorough
def test_every_generated_name_has_one_row() -> None:
    assert found().wrong == ()


@pytest.mark.thorough
def test_every_row_is_the_row_of_some_name() -> None:
    assert [row.name + row.component for row in INTERMEDIATES if row not in found().rows] == []
    assert set(PREFIXES) - found().prefixes == set()


OF_PARAMETERS = {"Y", "h", "X", "p", "singularity", "residual", "detJ", "weights", "zc", "zc_next"}
"""Their units are those of parameters, of several states, of products of lengths, of lengths and angles together ..."""


@pytest.mark.parametrize("name", MODELS)
def test_arguments_and_results_have_symbol_unit_and_meaning(name: str) -> None:
    model = MODELS[name]
    for role, names in ((Role.ARGUMENT, model.arguments), (Role.RESULT, model.results)):
        for each in names:
            row = model.quantity(each)
            assert row.name == each and role in row.roles
            assert row.symbol and row.meaning and row.shape
            assert row.unit or each in OF_PARAMETERS or each.endswith("_dp")
    assert model.family and {row.name for row in model.own} <= {*model.arguments, *model.results, "qdd"}


def test_intermediate_rows_have_symbol_and_meaning() -> None:
    keys = [(row.name, row.component, row.of_results) for row in INTERMEDIATES]
    assert len(set(keys)) == len(keys)
    for row in INTERMEDIATES:
        assert row.symbol() and row.meaning and row.role is Role.INTERMEDIATE
        assert row.unit or row.name in ("y", "Y", "root", "W", "handed", "weight", "zc")


def test_names_of_a_linearization_have_symbols() -> None:
    """M, D and K, and the entries of the inertia matrix that they are made of."""
    package = programs(planar_2r(), Scene(("linearization",))).package
    (function,) = package.functions
    assert [array.entries[1] for array in arrays(package, function)] == [f"{letter}_{{1,2}}" for letter in "MDK"]
    notation = Notation(function.program)
    assert notation["A1_2"] == "A_{1,2}"
    assert all(notation.quantity(statement.name) for statement in function.program.statements)


def test_rows_of_a_floating_base_are_numbered_apart() -> None:
    package = programs(on(planar_2r()), Scene(("inertia_matrix", "bias_forces", "direct_dynamics"))).package
    for function in package.functions:
        symbols = [symbol for array in arrays(package, function) for symbol in array.entries]
        assert len(set(symbols)) == len(symbols), function.name
        assert any("_{0,1" in symbol for symbol in symbols), function.name


# Units


@pytest.mark.parametrize(
    ("over", "under", "unit"),
    [
        ("N m", "rad/s", "N m s/rad"),
        ("N m", "m", "N"),
        ("N", "m/s", "N s/m"),
        ("", "kg m2", "1/(kg m2)"),
        ("rad/s2", "N m", "rad/(s2 N m)"),
        ("m/s", "m/s", ""),
        ("N m s/rad", "s", "N m/rad"),
        ("1/(kg m2)", "1/kg", "1/m2"),
    ],
)
def test_quotients_of_units(over: str, under: str, unit: str) -> None:
    assert quotient(over, under) == unit


def test_units_by_kind_of_joint() -> None:
    assert [quantity("tau").unit.of(sigma) for sigma in (0, 1)] == ["N m", "N"]
    assert [quantity("dtau_dqd").unit.of(*pair) for pair in ((0, 0), (0, 1), (1, 0), (1, 1))] == [
        "N m s/rad",
        "N s",
        "N s/rad",
        "N s/m",
    ]
    assert (FORCE / POSITION).text == "N m/rad, N, N/rad or N/m"
    assert (VELOCITY / same("s")).of(0, 0) == "rad/s2"


def test_sentences_name_the_unit() -> None:
    assert quantity("q").sentence == "joint variables, rad or m"
    assert quantity("V0").sentence.endswith("in its axes, m/s and rad/s")
    assert quantity("T").sentence.endswith("row by row, lengths in m")
    assert quantity("E").sentence.endswith(", J")
    assert quantity("dqdd_dp").sentence == "derivatives of joint accelerations by the parameters that its columns name"


# Equation numbers


def numbers_cited(text: str) -> tuple[int, ...]:
    """Equation numbers of a text that cites them, ranges written out: 8 and 12 to 14 of `[8], [12]-[14]`."""
    found: list[int] = []
    for first, last in re.findall(r"\[(\d+)\](?:-\[(\d+)\])?", text):
        found += range(int(first), int(last or first) + 1)
    return tuple(found)


def test_citations_are_read_and_written() -> None:
    assert citation((28, 50)) == "[28], [50]" and citation(()) == ""
    assert numbers_cited("[8], [12]-[14]") == (8, 12, 13, 14)
    assert numbers_cited("(Pieper 1968, Paul 1981)") == ()
    for row in (*QUANTITIES.values(), *INTERMEDIATES):
        assert numbers_cited(citation(row.equations)) == row.equations
        assert all(1 <= number <= 61 for number in row.equations)


def test_intermediate_names_are_told_from_others() -> None:
    assert all(map(is_intermediate, ("H5", "H5a", "K5_33", "K5_x", "sin_q1", "by_q2_f3_6", "T0_11")))
    assert not any(map(is_intermediate, ("L1", "K4", "x", "F_max", "pose_1", "bstar3", "N5_1", "DV2_x")))


def test_a_name_without_a_row_is_refused_with_what_to_add() -> None:
    what = "momentum: no row of the table of quantities has this name: add it to quantities/signatures.py"
    with pytest.raises(LookupError, match=what):
        quantity("momentum")
    with pytest.raises(LookupError, match="dtau_dmomentum: no row"):
        quantity("dtau_dmomentum")


def test_parts_have_the_symbol_of_their_quantity() -> None:
    notation = Notation(trace(planar_2r(), "direct_dynamics").program)
    assert notation.quantity("Js4_33ab") == r"J^{*\mathrm{ab}}_{4,33}"
