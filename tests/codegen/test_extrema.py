"""Minimum and maximum: the same numbers in all targets, NaN where one is NaN; intervals, errors, derivatives."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.api.machines import the_machine
from symoro_elastic.codegen.compile import CompiledPackage, compile_library, load_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, PRECISIONS
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.matlab import render_matlab
from symoro_elastic.codegen.targets.st import render_st
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.tree.joint_laws import JointFriction
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.functions import amount, clamp, maximum, minimum
from tests.numerics.guarantees.fixed import FixedCase
from tests.numerics.guarantees.test_fixed_point import TURNING_SPRING
from tests.octave import OCTAVE, Call, as_argument, octave, written
from tests.references.controlled import PLAIN, controlled
from tests.structured_text import interpreted, parsed

LIMIT = 2.5
GIVEN = np.array([0.0, 1.0, -1.0, LIMIT, -LIMIT, 3.0, -3.0, np.inf, -np.inf, np.nan])
WANTED = np.array([0.0, 1.0, -1.0, LIMIT, -LIMIT, LIMIT, -LIMIT, LIMIT, -LIMIT, np.nan])
"""Torques that are fed forward, and what the limit of a controller without motion and states makes of them."""
MACHINE = controlled(motor=replace(PLAIN, Tn=None, torque_limit=Formula.parse(repr(LIMIT)), windup=None))


def package() -> Package:
    return trace_models(MACHINE, Scene(models=("control",))).package


def arguments() -> dict[str, Array]:
    control = next(f for f in package().functions if f.name == "control")
    zeros = {a.name: np.zeros((len(GIVEN), a.size)) for a in control.arguments}
    return zeros | {"tau": GIVEN[:, None]}


def on_floats(folder: Path) -> Array:
    model = se.load(MACHINE, "control")
    return np.array([model.control(*(x[k] for x in arguments().values()))[0][0] for k in range(len(GIVEN))])


def on_stacks(folder: Path) -> Array:
    return np.asarray(se.load(MACHINE, "control").control(*arguments().values())[0])[:, 0]


def on(backend: str) -> Callable[[Path], Array]:
    def run(folder: Path) -> Array:
        pytest.importorskip(backend)
        model = se.load(MACHINE, "control", backend=backend)
        each = ([x[k] for x in arguments().values()] for k in range(len(GIVEN)))
        return np.array([float(np.asarray(model.control(*one)[0])[0].item()) for one in each])

    return run


def in_c(precision: str) -> Callable[[Path], Array]:
    def run(folder: Path) -> Array:
        made, of = package(), PRECISIONS[precision]
        called = CompiledPackage(made, compile_library(render_c(made, of), folder), of)
        return called.call("control", **arguments())["u"][:, 0]

    return run


def in_structured_text(folder: Path) -> Array:
    (text,) = render_st(package(), DOUBLE).values()
    named = parsed(text).blocks["ball_screw_control"].sections["var_input"]
    given = {name: arguments().get(name.removesuffix("_1"), np.zeros((len(GIVEN), 1))) for name, *_ in named}
    return interpreted(text, "ball_screw_control", given)["u"][:, 0]


def in_batches(folder: Path) -> Array:
    made = package()
    library = load_library(compile_library(render_c_batch(made), folder))
    given, u, zc = [np.ascontiguousarray(x.T) for x in arguments().values()], np.zeros((1, len(GIVEN))), np.zeros(0)
    p = np.array([one.value for one in made.parameters])
    pointers = [x.ctypes.data_as(ctypes.c_void_p) for x in (*given, p, u, zc)]
    library.ball_screw_control_batch(ctypes.c_size_t(len(GIVEN)), *pointers)
    return u[0]


def in_octave(folder: Path) -> Array:
    if OCTAVE is None:
        pytest.skip("needs octave-cli (package octave)")
    call = Call("ball_screw.control(", [as_argument(name, x) for name, x in arguments().items()])
    (answer,) = octave([call], folder / "run", [written(render_matlab(package()), folder / "code")])
    assert not answer.error
    return np.asarray(answer.results[0]).ravel()


RUNS = {"floats": on_floats, "stacks": on_stacks, "st": in_structured_text, "octave": in_octave, "batches": in_batches}
RUNS |= {backend: on(backend) for backend in ("casadi", "jax")}
RUNS |= {precision: in_c(precision) for precision in ("double", "mixed", "double-double")}


@pytest.mark.sampled(5)
@pytest.mark.parametrize("run", RUNS.values(), ids=list(RUNS))
def test_limits_are_exact_and_keep_nan(run: Callable[[Path], Array], tmp_path: Path) -> None:
    found = run(tmp_path)
    known = ~np.isinf(GIVEN) | (run is not RUNS["double-double"])  # sums of two doubles make NaN of infinity
    assert np.array_equal(found[known], WANTED[known], equal_nan=True)


@pytest.mark.parametrize("operation", [minimum, maximum])
def test_derivatives_are_one_sided_and_half_each_where_both_are_equal(operation: Callable[..., Any]) -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    z = operation(graph, x, y)
    of = Differentiation([z])
    slopes = [of.by(one).of(z) for one in (x, y)]
    least = operation is minimum
    for at, wanted in (((1.0, 2.0), (least, not least)), ((2.0, 1.0), (not least, least)), ((1.0, 1.0), (0.5, 0.5))):
        value = evaluate([z, *slopes], dict(zip("xy", at, strict=True)), FLOATS)
        assert value(z) == (min if least else max)(at) and tuple(map(value, slopes)) == wanted


def test_numbers_are_exact() -> None:
    graph = Graph()
    x = graph.symbol("x")
    assert (minimum(graph, 1, 2), maximum(graph, 1, 2), clamp(graph, 3, -1, 2), amount(graph, -3)) == (1, 2, 2, 3)
    assert minimum(graph, x, x) is x and amount(graph, -x) is amount(graph, x)


def test_intervals_hold_what_numbers_are() -> None:
    """On 1000 pairs of intervals; what is not bounded stays so, as NaN does."""
    rng = np.random.default_rng(1)
    ends = np.sort(rng.normal(size=(4, 1000)).reshape(2, 2, 1000), axis=1)
    x, y = (Interval(low, high) for low, high in ends)
    at = [rng.uniform(one.low, one.high) for one in (x, y)]
    for name, of in (("minimum", np.minimum), ("maximum", np.maximum)):
        found = INTERVALS.operations[name](x, y)
        assert np.all((found.low <= of(*at)) & (of(*at) <= found.high))
        assert np.array_equal(found.low, of(x.low, y.low)) and np.array_equal(found.high, of(x.high, y.high))
        unknown = INTERVALS.operations[name](x, Interval(np.full(1000, -np.inf), np.full(1000, np.inf)))
        assert not unknown.is_bounded.any()


def test_fixed_point_is_within_what_is_proven(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A friction made for this, on 20 000 states, half of them at ends of their ranges; its bound in double, too."""

    def force(self: JointFriction) -> Any:
        return clamp(self.graph, self.coulomb * self.v, -self.viscous, maximum(self.graph, self.viscous * self.v, 0))

    monkeypatch.setattr(JointFriction, "force", force)
    machine = the_machine(TURNING_SPRING | {"name": "limited"})
    one = FixedCase(machine, DescribedMachine.of(machine).limits, "friction_forces")
    states = one.states(20_000, np.random.default_rng(3))
    in_box, found = one.run(states, tmp_path)
    exact = one.exact(states)
    assert in_box.all() and (np.abs(found * one.units - exact).max(axis=0) <= one.proven + 1e-15).all()
    assert exact[:, -1].min() == -0.3 and exact[:, -1].max() > 0.8
    (certificate,) = se.certify(machine, "friction_forces").certificates
    assert 0 < certificate.entries[-1].error < 1e-15
