"""Generated code of machines with couplings and loops: names of entries, C that compiles and agrees with numpy."""

from __future__ import annotations

import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.api.machines import the_machine
from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.codegen.precision import DOUBLE, PRECISIONS
from symoro_elastic.codegen.targets import render_targets
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import Traced, trace_models
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.implementations import c_code, import_package, numpy_code
from symoro_elastic.numerics.verification.states import moderate_states
from symoro_elastic.symbolic.operations import SYMBOL
from tests.closed_chains.machines import FILES, machine
from tests.references.random_machines import planar_2r

pytestmark = pytest.mark.sampled(6)

MODELS = ("direct_dynamics", "inverse_dynamics", "dependent_coordinates", "coupling_matrix", "reaction_wrenches")
COUPLED = [name for name in FILES if machine(name).is_coupled]
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
IN_ALL_PRECISIONS = ("ball_screw", "delta", "sr400")
"""Couplings, an assembled loop and one of closed form; precisions of trees are tested in `test_plain_c`."""
STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only")


@cache
def programs(name: str) -> Traced:
    whole = machine(name)
    assembled = trace(whole, "direct_dynamics").model.arguments[1] == "q_dep"
    return trace_models(whole, Scene(models=(*MODELS, "assemble") if assembled else MODELS))


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("name", COUPLED)
def test_c_compiles_without_warnings_and_agrees_with_numpy(name: str, tmp_path: Path) -> None:
    made = programs(name)
    precisions = tuple(PRECISIONS.values()) if name in IN_ALL_PRECISIONS else (DOUBLE,)
    files = render_targets(made.package, ("c", "c-batch"), precisions)
    for file, text in files.items():
        (tmp_path / file).write_text(text)
    for compiler in COMPILERS:
        sources = [file for file in files if file.endswith(".c")]
        done = subprocess.run([compiler, *STRICT, *sources], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:2000]
    values = parameter_values(made.machine)
    p = np.array([values[one.name] for one in made.package.parameters], dtype=float)
    states = moderate_states(made.machine, 2)
    module = import_package(render_targets(made.package, ("numpy",)), tmp_path / "numpy")
    in_double = files if precisions == (DOUBLE,) else None
    library = compile_package(made.package, tmp_path / "c", in_double, flags=("-O0",), precision=DOUBLE)
    for model in made.models:
        wanted = numpy_code(module, p, stacked=True)(model, states)
        for batch in (False, True):
            for result, array in c_code(library, p, batch)(model, states).items():
                scale = 1.0 if result == "residual" else np.abs(wanted[result]).max(initial=0.0) or 1.0
                assert np.abs(array - wanted[result]).max(initial=0.0) < 1e-12 * scale, (model.model.name, result)


@pytest.mark.parametrize("name", COUPLED)
def test_no_quantity_has_the_name_of_an_argument(name: str) -> None:
    """numpy would take the second for the first in silence."""
    for model in programs(name).models:
        program = model.program
        symbols = {symbol for argument in program.inputs for symbol in argument.symbols}
        named = [one.name for one in (*program.once, *program.statements) if one.node.operation != SYMBOL]
        assert symbols.isdisjoint(named) and len({*named}) == len(named)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["delta", "four_bar", "gantry_rigid", "ball_screw"])
def test_entries_have_names(name: str, tmp_path: Path) -> None:
    whole = machine(name)
    names = {j: joint.name for j, joint in enumerate(whole.joints, start=1)}
    made = programs(name)
    module = import_package(render_targets(made.package, ("numpy",)), tmp_path)
    assert tuple(names[j] for j in whole.independent) == module.JOINTS
    assert tuple(names[j] for j in whole.dependent) == module.DEPENDENT
    assert tuple(names[j] for j in whole.motors) == module.MOTOR_NAMES
    if set(whole.motors) <= set(whole.independent):
        assert tuple(module.JOINTS[k] for k in module.MOTORS) == module.MOTOR_NAMES
    else:
        assert not hasattr(module, "MOTORS")
    assert module.OUTPUTS["dependent_coordinates"]["x"] == tuple(names[j] for j in whole.with_variable)
    header = render_targets(made.package, ("c",))[f"{whole.name}.h"]
    for macro, count in (("JOINTS", whole.independent), ("DEPENDENT", whole.dependent), ("MOTORS", whole.motors)):
        assert f"#define {whole.name.upper()}_{macro} {len(count)}\n" in header
    for k, j in enumerate(whole.dependent):
        assert f" *   q_dep[{k}]  {names[j]}, {whole.joint(j).kind}, {whole.joint(j).variable}" in header
    for k, j in enumerate(whole.motors):
        assert f" *   tau[{k}]  {names[j]}\n" in header


@pytest.mark.thorough
def test_assemble_has_a_result_of_its_own_name_in_c() -> None:
    made = programs("ring")
    header = " ".join(render_targets(made.package, ("c",))["ring.h"].split())
    assert "const double q_dep[RING_DEPENDENT], const double *p, " in header
    assert "double q_dep_out[RING_DEPENDENT], double residual[1]);" in header


def test_a_tree_names_neither(tmp_path: Path) -> None:
    made = trace_models(planar_2r(), Scene(models=("direct_dynamics",)))
    module = import_package(render_targets(made.package, ("numpy",)), tmp_path)
    assert not hasattr(module, "DEPENDENT") and not hasattr(module, "MOTOR_NAMES") and hasattr(module, "MOTORS")
    assert "DEPENDENT" not in "".join(render_targets(made.package, ("c",)).values())


@pytest.mark.parametrize("width", ["W", "1.2"])
def test_functions_of_two_numbers_take_one_that_is_the_same_for_all_states(width: str, tmp_path: Path) -> None:
    yaw = {"name": "yaw", "kind": "coupled", "sigma": 0, "alpha": "pi/2", "theta": f"2*atan2(x1 - x2, {width})"}
    one, two = ({"name": f"m{k}", "antecedent": 0, "kind": "motor", "sigma": 1, "r": f"x{k}"} for k in (1, 2))
    bodies = {"yaw": {"mass": 1, "center_of_mass": [0.1, 0, 0], "inertia": [1, 1, 1]}}
    gantry = the_machine({"joints": [one, two, yaw], "parameters": {"W": 1.2}, "bodies": bodies})
    made = trace_models(gantry, Scene(models=("inverse_dynamics",)))
    states, p = moderate_states(gantry, 5), np.array([1.2][: len(made.package.parameters)])
    library = compile_package(made.package, tmp_path, flags=("-O0",), precision=DOUBLE)
    single, batch = (c_code(library, p, many)(made.models[0], states) for many in (False, True))
    assert np.allclose(batch["tau"], single["tau"], rtol=1e-14)
