"""What is listed and said of models against what is traced and generated."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.codegen.package_context import SINGULAR
from symoro_elastic.foundation.output_files import write_files
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.programs.catalogue import MODELS, trace
from symoro_elastic.quantities import MOTION
from tests.analysis.vibration.machines import drive
from tests.analysis.vibration.test_singular_inertia import on_the_axis
from tests.closed_chains.machines import machine as closed_chain
from tests.command_line import run
from tests.generated_code import imported, rendered
from tests.references.controlled import controlled
from tests.references.random_machines import chain, planar_2r, two_children

ANY = ("columns", "parameters", "solutions", "joints", "components", "states")


@pytest.fixture(scope="module")
def listed() -> Any:
    return json.loads(run("models", "--json").stdout)


def lengths(shape: str, sizes: dict[str, int]) -> list[int | None]:
    """Lengths of the axes; None where they depend on the machine's equations."""
    return [None if word in ANY else sizes[word] if word in sizes else int(word) for word in shape.split(" x ")]


@pytest.mark.sampled(16)
@pytest.mark.parametrize("name", [name for name in MODELS if "geometric" not in name and "position" not in name])
def test_shapes_are_those_of_traced_models(name: str, listed: Any) -> None:
    """A motor and springs beside each other; a motor and its load where motions beyond springs are wanted."""
    machine = drive() if name == "feed_forward" else two_children(symbolic=True)
    if MODELS[name].family == "closed chains":
        machine = closed_chain("ring" if name == "assemble" else "geared_five_bar")
    if MODELS[name].family == "static springs":
        machine = restrict(machine, Scene(static={next(j.name for j in machine.joints if j.kind == "elastic"): None}))
    if MODELS[name].family == "inverse kinematics":
        machine = chain(6, elastic=(6,))
    if MODELS[name].family == "controllers":
        machine = controlled()
    n, m = len(machine.independent), sum(joint.kind == "motor" for joint in machine.joints)
    sizes = {"n": n, "m": m, "(n - m)": n - m, "frames": len(machine.joints), "loops": len(machine.loops)}
    sizes |= {"d": len(machine.dependent), "s": len(machine.static), "n(n + 1)/2": n * (n + 1) // 2}
    assert 0 < m < n
    traced = trace(machine, name)
    assert set(traced.results) == set(listed["models"][name]["results"])
    for result, (shape, _) in listed["models"][name]["results"].items():
        (found,) = (each.shape for each in traced.program.outputs if each.name == result)
        wanted = lengths(shape, sizes)
        assert len(wanted) == len(found) and all(w in (None, x) for w, x in zip(wanted, found, strict=True)), result


def test_feed_forward_takes_as_many_derivatives_as_the_chain_needs(listed: Any) -> None:
    assert tuple(listed["models"]["feed_forward"]["arguments"]) == tuple(row.name for row in MOTION)
    assert any(note.startswith("y ...: y and as many derivatives") for note in listed["notes"])
    shown = run("models").stdout
    assert "y ... " in shown and "yd, ydd, yddd, ydddd" not in shown and listed["notes"][-1] in shown


def test_models_say_what_a_singular_inertia_gives(tmp_path: Path, listed: Any) -> None:
    """Of models that divide by it, and of no others; and so it is."""
    models = ("direct_dynamics", "direct_dynamics_derivatives", "inverse_dynamics", "bias_forces")
    for target, file in (("numpy", "__init__.py"), ("c", "planar_2r.h")):
        assert rendered(planar_2r(), Scene(models), [target])[file].count(SINGULAR) == 2
        elastic = rendered(planar_2r(elastic=(2,)), Scene(models), [target])[file]
        assert elastic.count(SINGULAR) == 3
    assert any(SINGULAR in note for note in listed["notes"])
    write_files(tmp_path / "sing", rendered(on_the_axis(), Scene(models[:2]), ["numpy"]))
    code, zero = imported(tmp_path / "sing"), np.zeros(3)
    given = {"q": zero, "qd": zero, "tau": np.ones(2)}
    for found in (code.direct_dynamics(**given), *code.direct_dynamics_derivatives(**given)):
        assert not np.isfinite(found).all()
