"""Columns of derivatives that are asked for by name: the numbers of the whole model, fewer operations, refusals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from symoro_elastic.cli import cli
from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import RequestedPart, Scene
from symoro_elastic.models.programs.catalogue import TracedModel, trace_scene
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.symbolic.arithmetic import FLOATS
from tests.generated_code import imported
from tests.models.test_scenes import results, state_of, symbols
from tests.references.random_machines import chain, planar_2r, random_machine, two_children

pytestmark = pytest.mark.sampled(5)

EXAMPLES = Path(__file__).parents[2] / "examples"
TWO_R = EXAMPLES / "planar_2r.toml"
INVERSE, DIRECT = "inverse_dynamics_derivatives", "direct_dynamics_derivatives"
INVERSE_BY_P, DIRECT_BY_P = "inverse_dynamics_parameter_derivatives", "direct_dynamics_parameter_derivatives"
MACHINES = [
    planar_2r(elastic=(2,)),
    chain(3, symbolic=True),
    two_children(symbolic=True),
    *(random_machine(seed, joints=4, symbolic=True) for seed in range(3)),
]
VARIOUS = [pytest.param(machine, id=f"{machine.name}-{k}") for k, machine in enumerate(MACHINES)]


def traced(machine: Machine, name: str, *asked: str) -> TracedModel:
    (model,) = trace_scene(machine, Scene((name,), {name: asked} if asked else {}))
    return model


def cost(model: TracedModel) -> int:
    return sum(count.products + count.add for count in (model.program.count, model.program.count_once))


def columns(model: TracedModel, machine: Machine) -> dict[tuple[str, str], Any]:
    """Columns by result and name."""
    values = results(model, symbols(machine, state_of(machine, 1), FLOATS))
    labels = {name: result.column_labels for name, result in model.results.items()}
    return {(name, label): values[name][:, k] for name in values for k, label in enumerate(labels[name])}


@pytest.mark.thorough
@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", [INVERSE_BY_P, DIRECT_BY_P])
@pytest.mark.parametrize("machine", VARIOUS)
def test_parameters_by_name(machine: Machine, name: str) -> None:
    """In the order asked; other parameters stay symbols and cost nothing."""
    whole = traced(machine, name)
    every = next(iter(whole.results.values())).column_labels
    wanted = every[::4][::-1]
    part = traced(machine, name, f"by {', '.join(wanted)}")
    assert all(result.column_labels == wanted for result in part.results.values())
    full, some = columns(whole, machine), columns(part, machine)
    assert set(some) == {(of, label) for of in part.results for label in wanted}
    for key, column in some.items():
        np.testing.assert_allclose(column.astype(float), full[key].astype(float), rtol=1e-9, atol=1e-9)
    assert cost(part) < cost(whole)
    assert set(every) - set(wanted) & part.program.used


@pytest.mark.parametrize("name", [INVERSE, DIRECT])
@pytest.mark.parametrize("machine", VARIOUS)
def test_variables_by_name(machine: Machine, name: str) -> None:
    """An argument, an entry of another one, and the rows of one joint: what is left out has no result."""
    last = machine.independent[-1]
    variable, row = str(machine.joints[last - 1].variable), machine.joints[last - 1].name
    whole, part = traced(machine, name), traced(machine, name, f"{row} by qd", f"by {variable}")
    values = symbols(machine, state_of(machine, 2), FLOATS)
    full, some = results(whole, values), results(part, values)
    assert set(some) == {of for of in full if of.endswith(("_dq", "_dqd"))}
    for of, entries in some.items():
        rows = [whole.rows[of].index(j) for j in part.rows[of]]
        wanted = full[of][rows] if of.endswith("_dqd") else full[of][rows][:, [machine.independent.index(last)]]
        np.testing.assert_allclose(entries.astype(float), wanted.astype(float), rtol=1e-9, atol=1e-9)
    assert part.results[next(of for of in some if of.endswith("_dq"))].column_labels == (variable,)
    assert cost(part) < cost(whole)


def test_symmetric_entries_by_name() -> None:
    """One column of the inertia matrix that motors feel."""
    machine = planar_2r(elastic=(2,))
    part = traced(machine, INVERSE, "by qdd1")
    assert list(part.results) == ["dtau_dqdd_motor", "dqdd_dqdd_motor"]
    whole, values = traced(machine, INVERSE), symbols(machine, state_of(machine, 2), FLOATS)
    for of, entries in results(part, values).items():
        wanted = results(whole, values)[of]
        np.testing.assert_allclose(entries.astype(float), wanted.astype(float), rtol=1e-14)


def test_a_parameter_without_effect_has_a_column_of_zeros() -> None:
    machine = planar_2r(elastic=(2,))
    part = traced(machine, DIRECT_BY_P, "by M1, K2, M1")
    (result,) = part.results.values()
    assert result.column_labels == ("M1", "K2") and result.entries[::2] == (0, 0) and result.entries[1] != 0


def test_generated_code_has_these_columns() -> None:
    machine = planar_2r(elastic=(2,))
    outputs = {INVERSE: ("by q2, qd",), DIRECT: ("by tau",), INVERSE_BY_P: ("by K2, M2",), DIRECT_BY_P: ("by L1",)}
    assert verify(machine, Scene(tuple(outputs), outputs), states=(3, 4)).ok


def test_command_line_and_scene_file_ask_alike(tmp_path: Path) -> None:
    words = [str(TWO_R), "--model", DIRECT_BY_P, "--model", DIRECT]
    asked = ["--only", f"{DIRECT_BY_P} by l1, m2", "--only", f"{DIRECT}=elbow by q2, qd", "--out", str(tmp_path / "c")]
    CliRunner().invoke(cli, ["generate", *words, *asked], catch_exceptions=False)
    scene = tmp_path / "asked.toml"
    outputs = f'{{ {DIRECT_BY_P} = ["by l1", "by m2"], {DIRECT} = ["elbow", "by q2, qd"] }}'
    scene.write_text(f'models = ["{DIRECT_BY_P}", "{DIRECT}"]\noutputs = {outputs}\n')
    again = ["generate", str(TWO_R), "--scene", str(scene), "--out", str(tmp_path / "s")]
    CliRunner().invoke(cli, again, catch_exceptions=False)
    header, other = ((tmp_path / k / "planar_2r" / "planar_2r.h").read_text(encoding="utf-8") for k in "cs")
    assert header == other
    for line in (
        "columns: l1, m2",
        "rows of dqdd_dq: elbow",
        "columns of dqdd_dq: q2",
        "columns of dqdd_dqd: qd1, qd2",
    ):
        assert f" *   {line}\n" in header
    assert imported(tmp_path / "c" / "planar_2r").COLUMNS == {DIRECT_BY_P: ("l1", "m2")}


def test_equations_of_chosen_columns() -> None:
    words = ["equations", str(TWO_R), "--model", DIRECT, "--only", f"{DIRECT} by q2"]
    assert r"[\partial\ddot{q}/\partial q]_{2,q_{2}}" in CliRunner().invoke(cli, words, catch_exceptions=False).stdout


@pytest.mark.parametrize(
    ("model", "name", "reason"),
    [
        (DIRECT_BY_P, "l3", "no column 'l3'; did you mean 'l2'?"),
        (DIRECT_BY_P, "qd1", f"no column 'qd1': it is a column of {INVERSE}, {DIRECT}"),
        (DIRECT, "l1", f"no column 'l1': it is a column of {INVERSE_BY_P}, {DIRECT_BY_P}"),
        (DIRECT, "qdd1", f"no column 'qdd1': it is a column of {INVERSE}"),
        (DIRECT, "q3", "no column 'q3'; did you mean 'q"),
        (DIRECT, "q1,", "write one list of names"),
        ("jacobian", "q1", f"'by q1': only {INVERSE}, "),
    ],
)
def test_names_that_are_not_there(model: str, name: str, reason: str, tmp_path: Path) -> None:
    words = ["generate", str(TWO_R), "--model", model, "--only", f"{model} by {name}", "--out", str(tmp_path)]
    with pytest.raises(InputError) as refused:
        CliRunner().invoke(cli, words, catch_exceptions=False)
    said = str(refused.value)
    assert f": --only, {model}: " in said and reason in said and "\n" not in said
    assert not list(tmp_path.iterdir())


def test_names_that_a_scene_has_taken_away() -> None:
    machine, zero = planar_2r(), {"joint2": Formula.parse(0)}
    with pytest.raises(InputError, match="no column 'L1': it becomes a constant: do not fold it"):
        trace_scene(machine, Scene((DIRECT_BY_P,), {DIRECT_BY_P: ("by L1",)}, fold=("L1",)))
    with pytest.raises(InputError, match=f"no column '{machine.joints[1].variable}': it belongs to a locked joint"):
        trace_scene(machine, Scene((DIRECT,), {DIRECT: (f"by {machine.joints[1].variable}",)}, zero))


@pytest.mark.parametrize("text", ["by M1, K2", "tool by M1", "tool at (0, 0, 1) in base"])
def test_words(text: str) -> None:
    assert str(RequestedPart.parse(text.replace(" by ", "  by  ").replace(", ", " ,  "))) == text.replace(" ,  ", ", ")


@pytest.mark.parametrize("file_format", [toml, par])
def test_files_keep_the_columns(file_format: Any) -> None:
    scene = Scene((DIRECT_BY_P,), {DIRECT_BY_P: ("joint2 by M1, K2",)})
    machine = planar_2r(elastic=(2,))
    again = file_format.read(file_format.write(DescribedMachine.of(machine).asking(scene=scene)), "a")
    assert again.asked.scene.outputs == scene.outputs
