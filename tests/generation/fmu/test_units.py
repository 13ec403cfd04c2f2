"""FMUs as files: descriptions without a finding, the same bytes every time, sources that the standard's headers fit."""

from __future__ import annotations

import io
import re
import shutil
import subprocess
import zipfile
from dataclasses import replace
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

pytest.importorskip("fmpy")

import fmpy
from fmpy import read_model_description
from fmpy.validation import validate_fmu

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.fmu import Options
from symoro_elastic.generation.fmu.mock_up_unit import MockUpUnit, unit_of
from symoro_elastic.generation.fmu.scalar_variables import IDLE, layout_of
from symoro_elastic.generation.fmu.start import start_of
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from tests.command_line import refused, run
from tests.generation.fmu.machines import CASES, EXAMPLES, elastic_arm, sources_of_unit

pytestmark = pytest.mark.sampled(5)

TWO_R = EXAMPLES / "planar_2r.toml"


@pytest.fixture(autouse=True)
def without_compiler(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Descriptions and sources need no binary."""
    if "compiled" not in request.fixturenames:
        monkeypatch.setenv("CC", "no-compiler-of-this-name")


@pytest.fixture
def compiled() -> None:
    """Marks a test that compiles."""


def written(unit: MockUpUnit, folder: Path) -> Path:
    path = folder / "unit.fmu"
    path.write_bytes(unit.archive)
    return path


def text_of(unit: MockUpUnit, name: str) -> str:
    with zipfile.ZipFile(io.BytesIO(unit.archive)) as archive:
        return archive.read(name).decode()


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("case", CASES)
def test_fmpy_finds_nothing(case: str, version: int, tmp_path: Path) -> None:
    unit = sources_of_unit(case, version)
    assert validate_fmu(str(written(unit, tmp_path))) == []
    assert "sources only" in unit.notes[-1]


def test_names_are_those_of_signals(tmp_path: Path) -> None:
    description = read_model_description(str(written(sources_of_unit("springs", 2), tmp_path)))
    by_causality = {}
    for one in description.modelVariables:
        by_causality.setdefault(one.causality, []).append(one.name)
    assert by_causality["input"] == ["drive.tau", *(f"tool.{x}" for x in ("fx", "fy", "fz", "mx", "my", "mz"))]
    assert by_causality["output"][:6] == ["drive.q", "arm.q", "rod.q", "drive.qd", "arm.qd", "rod.qd"]
    assert by_causality["output"][6:] == ["rod.deflection", "'tool at (0.1, 0, L)'.x", "'tool at (0.1, 0, L)'.y"]
    assert {"L", "arm.mass", "arm.stiffness", "rod.damping", "rod.neutral"} <= {*by_causality["parameter"]}


def test_units_have_their_base_units(tmp_path: Path) -> None:
    description = read_model_description(str(written(sources_of_unit("springs", 3), tmp_path)))
    powers = {unit.name: unit.baseUnit for unit in description.unitDefinitions}
    stiffness = powers["N.m/rad"]
    assert (stiffness.kg, stiffness.m, stiffness.s, stiffness.rad) == (1, 2, -2, -1)
    units = {one.name: one.unit for one in description.modelVariables}
    assert units["arm.stiffness"] == "N.m/rad"
    assert units["rod.stiffness"] == "N/m"
    assert units["der(arm.qd)"] == "rad/s2"
    assert units["arm.XX"] == "kg.m2"


def test_units_that_are_not_known_are_left_out(tmp_path: Path) -> None:
    machine = elastic_arm()
    strange = replace(machine, parameters=(replace(machine.parameters[0], unit='"<furlong>&'),))
    path = written(unit_of(strange, Scene(), Options(2)), tmp_path)
    assert validate_fmu(str(path)) == []


def test_springs_have_the_nominal_of_their_load(tmp_path: Path) -> None:
    """The deflection that an acceleration of g gives, and never 1; velocities by the frequency of the spring."""
    description = read_model_description(str(written(sources_of_unit("springs", 2), tmp_path)))
    nominal = {one.name: one.nominal for one in description.modelVariables if one.nominal}
    assert float(nominal["rod.q"]) == pytest.approx(1.5 * 9.81 / 5e4, rel=0.05)
    assert float(nominal["rod.qd"]) == pytest.approx(1.5 * 9.81 / 5e4 * np.sqrt(5e4 / 1.5), rel=0.05)
    assert 1e-3 < float(nominal["arm.q"]) < 1e-2
    assert all(float(x) != 1.0 for name, x in nominal.items() if name.startswith(("arm.", "rod.")))


def test_the_start_holds_the_motors_where_they_are_asked_to_stand() -> None:
    machine = elastic_arm()
    at = unit_of(machine, Scene(), Options(2, {"drive": 1.2}))
    text = text_of(at, "modelDescription.xml")
    start = dict(re.findall(r'name="(\S+)" [^>]*>\s*<Real [^>]*start="(\S+?)"', text))
    found = se.linearize(machine, at={"drive": 1.2}).state
    assert float(start["drive.q"]) == 1.2
    np.testing.assert_allclose([float(start["arm.q"]), float(start["rod.q"])], found.q[1:], rtol=1e-12)
    assert float(start["drive.tau"]) == pytest.approx(found.torques[0], rel=1e-12)


def test_a_machine_that_nothing_supports_starts_without_torques() -> None:
    joints = [{"name": "slide", "antecedent": 0, "kind": "passive", "sigma": 1, "r": "q1"}]
    bodies = {"slide": {"mass": 1}}
    machine = se.read({"name": "falling", "gravity": [0, 0, -9.81], "joints": joints, "bodies": bodies})
    unit = unit_of(machine, Scene(), Options(2))
    assert unit.notes[0].startswith("it does not start in equilibrium: ")
    assert text_of(unit, "modelDescription.xml").count('start="0.0"') >= 2


def test_other_joints_begin_the_search_where_they_are_asked_to_stand() -> None:
    """An arm that is told where its spring is starts in equilibrium all the same, and `generate` says so."""
    unit = unit_of(elastic_arm(), Scene(), Options(2, {"drive": 1.2, "arm": 0.3}))
    assert unit.notes[0].startswith("--start: arm starts in equilibrium at -0.0")
    assert unit.notes[0].endswith("the search began at 0.3 rad: only motors are held")
    assert len(unit.notes) == 2
    hanging, upright = (start_of(pendulum(), {"swing": x}) for x in (10.0, np.pi / 2))
    assert abs(hanging.q[1] - 10.0) < np.pi and np.sin(hanging.q[1]) == pytest.approx(-1, abs=1e-12)
    assert upright.q[1] == pytest.approx(np.pi / 2, abs=1e-12) and upright.notes == ()


def pendulum() -> Machine:
    """A motor that carries a pendulum, which stands out level at zero."""
    joints = [
        {"name": "cart", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "swing", "antecedent": "cart", "kind": "passive", "sigma": 0, "d": 0.3, "theta": "q2"},
    ]
    bodies = {"cart": {"mass": 1}, "swing": {"mass": 1, "center_of_mass": [0.2, 0, 0], "inertia": [0, 0.01, 0.01]}}
    return se.read({"name": "pendulum", "gravity": [0, -9.81, 0], "joints": joints, "bodies": bodies})


def test_a_level_pendulum_starts_where_it_hangs() -> None:
    found = start_of(pendulum(), {})
    assert found.notes == ()
    np.testing.assert_allclose(found.q, [0, -np.pi / 2], atol=1e-12)


def test_torques_of_rounding_are_zero() -> None:
    found = start_of(se.read(TWO_R), {"elbow": np.pi / 2})
    assert found.torques[0] > 1 and found.torques[1] == 0.0


def test_no_machine_has_the_name_of_the_interface() -> None:
    unit = unit_of(replace(se.read(TWO_R), name="fmi2"), Scene(), Options(2))
    assert "fmi2_direct_dynamics(" in text_of(unit, "sources/fmi2.c")
    assert "fmi2Instantiate" in text_of(unit, "sources/interface-fmi2.c")


def test_a_simulation_is_as_long_as_its_fastest_vibration_allows(tmp_path: Path) -> None:
    """A thousand communication steps, each at most 2.5 of its periods, and a tolerance that solvers keep."""
    found = read_model_description(str(written(sources_of_unit("springs", 2), tmp_path))).defaultExperiment
    fastest = start_of(elastic_arm(), {}).fastest
    assert 0 < float(found.stepSize) <= 2.5 * 2 * np.pi / fastest
    assert float(found.stopTime) == pytest.approx(1000 * float(found.stepSize))
    assert float(found.tolerance) == 1e-7


@pytest.mark.parametrize("version", [2, 3])
def test_masses_and_stiffnesses_have_a_least_value(version: int, tmp_path: Path) -> None:
    description = read_model_description(str(written(sources_of_unit("springs", version), tmp_path)))
    bounded = {one.name for one in description.modelVariables if one.min is not None}
    assert bounded == {"arm.mass", "rod.mass", "arm.stiffness", "rod.stiffness"}
    assert {float(one.min) for one in description.modelVariables if one.min is not None} == {0.0}


@pytest.mark.thorough
@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
def test_the_same_bytes_every_time(compiled: None) -> None:
    machine = se.read(TWO_R)
    assert unit_of(machine, Scene(), Options(3)).archive == unit_of(machine, Scene(), Options(3)).archive


def test_files_have_no_time_and_binaries_and_descriptions_one_token() -> None:
    unit = sources_of_unit("tree", 2)
    with zipfile.ZipFile(io.BytesIO(unit.archive)) as archive:
        assert {one.date_time for one in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert archive.namelist() == sorted(archive.namelist())
    (token,) = re.findall(r'guid="(\S+)"', text_of(unit, "modelDescription.xml"))
    assert f'"{token}"' in text_of(unit, "sources/interface-fmi2.c")
    other = unit_of(se.read(TWO_R), Scene(fold=("m1",)), Options(2))
    assert token not in text_of(other, "modelDescription.xml")


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
@pytest.mark.parametrize("version", [2, 3])
def test_the_headers_of_the_standard_fit_in_the_place_of_our_declarations(version: int, tmp_path: Path) -> None:
    unit = sources_of_unit("tree", version)
    with zipfile.ZipFile(io.BytesIO(unit.archive)) as archive:
        archive.extractall(tmp_path)
    source = tmp_path / "sources" / f"interface-fmi{version}.c"
    text = source.read_text()
    ours = re.compile(r"typedef void \*fmi\d(?:Component|Instance);.*?(?=typedef struct \{\n    Instance model;)", re.S)
    replaced, count = ours.subn(f'#undef EXPORT\n#define EXPORT\n#include "fmi{version}Functions.h"\n', text)
    assert count == 1
    source.write_text(replaced)
    headers = Path(fmpy.__file__).parent / "c-code"
    command = ["gcc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", f"-I{headers}", str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    declared = {*re.findall(rf"\bfmi{version}\w+(?=TYPE\b)", (headers / f"fmi{version}FunctionTypes.h").read_text())}
    assert declared - {*re.findall(rf"FMI\((fmi{version}\w+)\)", text)} == set()


@pytest.mark.skipif(not shutil.which("gcc"), reason="needs gcc")
def test_functions_have_the_prefix_that_static_linking_asks_for(tmp_path: Path) -> None:
    with zipfile.ZipFile(io.BytesIO(sources_of_unit("tree", 2).archive)) as archive:
        archive.extractall(tmp_path)
    flags = ["-std=c99", "-DFMI2_FUNCTION_PREFIX=planar_2r_", "-E"]
    command = ["gcc", *flags, str(tmp_path / "sources" / "interface-fmi2.c")]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "planar_2r_fmi2Instantiate(" in text
    assert not re.search(r"\bfmi2GetReal\(", text)


def test_references_are_the_entries_of_one_array() -> None:
    unit = sources_of_unit("springs", 2)
    start = unit.programs
    assert [one.name for one in start.package.functions][:2] == ["direct_dynamics", "outputs"]
    text = text_of(unit, "sources/interface-fmi2.c")
    values = int(re.search(r"VALUES = (\d+)", text)[1])
    assert values == text_of(unit, "modelDescription.xml").count("<ScalarVariable ")


@pytest.mark.parametrize(
    ("file", "locked", "said"),
    [
        ("floating_arm.toml", (), "an FMU has a fixed base"),
        ("gantry.toml", (), "coulomb friction jumps at rest"),
        ("flex4.par", (), "XX1 has no value (45 more as well): give it one in the file"),
        ("planar_2r.toml", ("shoulder", "elbow"), "no joint moves, so an FMU would have no state"),
    ],
)
def test_machines_without_fmu_are_refused_by_name(file: str, locked: tuple[str, ...], said: str) -> None:
    scene = Scene(locked=dict.fromkeys(locked, Formula.parse(0)))
    with pytest.raises(InputError) as error:
        unit_of(se.read(EXAMPLES / file), scene, Options())
    assert said in str(error.value)
    assert str(error.value).startswith(str(EXAMPLES / file))


def test_generate_writes_one_file_beside_the_code(tmp_path: Path) -> None:
    found = se.generate(TWO_R, out=tmp_path, targets=["c", "fmu"], fmi=3)
    assert [path.name for path in found.written] == ["planar_2r.h", "planar_2r.c", "planar_2r.fmu", "generated.json"]
    assert "sources only" in found.notes[0]
    assert [one.model.name for one in found.models] == ["direct_dynamics", "inverse_dynamics"]
    assert read_model_description(str(tmp_path / "planar_2r" / "planar_2r.fmu")).fmiVersion == "3.0"


def test_the_command_names_what_has_no_meaning(tmp_path: Path) -> None:
    run("generate", TWO_R, "--target", "fmu", "--start", "elbow=0.5", "--out", tmp_path)
    for options, said in (
        (("--start", "elbow=1"), "--start: is where an FMU starts: add --target fmu"),
        (("--fmi", "3"), "--fmi: is the version of an FMU: add --target fmu"),
        (("--target", "fmu", "--start", "elbo=1"), "did you mean 'elbow'?"),
        (("--target", "fmu", "--model", "regressor"), "--model: an FMU has models of its own"),
        (("--target", "fmu", "--precision", "single"), "--precision: concerns the C code"),
    ):
        assert said in refused("generate", TWO_R, *options, "--out", tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_parameters_in_no_equation_say_so() -> None:
    """A body that turns about one axis has six moments in its table, one in the equations."""
    joint = {"name": "arm", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"}
    body = {"mass": 2, "center_of_mass": [0.3, 0, 0], "inertia": [0.1, 0.2, 0.3]}
    machine = se.read({"name": "swing", "gravity": [0, -9.81, 0], "joints": [joint], "bodies": {"arm": body}})
    with mock.patch("symoro_elastic.generation.fmu.mock_up_unit.shared_library", return_value=None):
        programs = unit_of(machine, Scene(), Options()).programs
    variables = [one for block in layout_of(programs, start_of(machine, {})).blocks for one in block.variables]
    idle = {one.name for one in variables if one.description.endswith(f"({IDLE})")}
    assert "arm.XX" in idle and "arm.YY" in idle and "arm.ZZ" not in idle and "arm.mass" not in idle
