"""What is proven of rounding is proven of the order in which text is carried out: generated code has the same bits."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.codegen.printed_order import in_printed_order
from symoro_elastic.codegen.printers import constant_values
from symoro_elastic.generation.pipeline import programs, render
from symoro_elastic.machine.scene import ALL, INERTIA, RECURSION, Scene
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.program import Input, Names, Output, build

EXAMPLES = Path(__file__).parents[2] / "examples"
STATES = 40


def test_a_sum_in_a_sum_has_no_parentheses() -> None:
    graph = Graph()
    x, y, z = (graph.symbol(name) for name in "xyz")
    entries = x + (y - z), x - (y + z), (x + y) * z
    program = build([Input("q", ("x", "y", "z"))], [Output("r", (3,), entries)], Names())  # type: ignore[arg-type]
    printed, changed = in_printed_order(program)
    assert str(printed.outputs[0].entries[0]) == "-(z - (x + y))"  # with older operands first
    assert printed.outputs[0].entries[1:] == program.outputs[0].entries[1:]
    assert [*changed.values()] == [printed.outputs[0].entries[0]]
    assert in_printed_order(printed)[0] is printed


@pytest.mark.sampled(3)
@pytest.mark.parametrize("form", [RECURSION, INERTIA])
@pytest.mark.parametrize("name", ["planar_2r.toml", "ball_screw.toml", "two_axis.toml", "gantry.toml", "lathe.toml"])
def test_code_has_the_bits_of_the_printed_order(
    name: str, form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = programs(se.read(EXAMPLES / name), Scene(models=("direct_dynamics",), form=form, fold=ALL))
    program = asked.package.functions[0].program
    printed, _ = in_printed_order(program)
    folder = f"of_{form}_{name[:-5]}"
    (tmp_path / folder).mkdir()
    for file, text in render(asked.package, ["numpy"], name).items():
        (tmp_path / folder / Path(file).name).write_text(str(text))
    monkeypatch.syspath_prepend(str(tmp_path))
    function = import_module(folder).direct_dynamics
    draw = np.random.default_rng(0)
    roots = [x for output in printed.outputs for x in output.entries]
    known = {number: np.float64(x) for number, x in constant_values(roots).items()}
    for _ in range(STATES):
        arguments = [draw.uniform(-1, 1, len(x.symbols)) for x in program.inputs if x.name != "p"]
        symbols = [s for x in program.inputs if x.name != "p" for s in x.symbols]
        states = dict(zip(symbols, np.concatenate(arguments), strict=True))
        value = evaluate(roots, states, arithmetic(np.float64), known)
        assert np.ravel(function(*arguments)).tolist() == [float(value(x)) for x in roots]
