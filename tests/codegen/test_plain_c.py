"""The C of the target `c` as a reviewer of embedded software reads it: plain C99, names of its own, MISRA."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, PRECISIONS, Precision
from symoro_elastic.codegen.targets import RESERVED, SCALED_TARGETS, TARGETS, c, c_batch, render_targets
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine, Parameter
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.guarantees.fixed_point import with_scales
from symoro_elastic.quantities.time_steps import OF_TIME_STEPS, TimeStep
from tests.generated_code import ALL_MODELS, COMPILERS
from tests.golden import FIVE
from tests.references.random_machines import chain, planar_2r, random_machine

pytestmark = pytest.mark.sampled(5)

ROOT = Path(__file__).parents[2]
LONGEST_LINE = 120
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wconversion", "-Wshadow")
COMPILERS_OWN = ("far", "near", "huge", "interrupt", "unix", "linux", "pascal", "cdecl", "bit", "data", "code", "at")
"""Keywords and macros of common compilers; <windows.h> and <complex.h> define some."""
MACHINES = ("two_axis.toml", "rx90.par", "flex4.par", "random", "long", "constant", "steps")
PRECISION = [pytest.param(precision, id=precision.name) for precision in PRECISIONS.values()]


@cache
def machine(name: str) -> Machine:
    """An example; a machine with friction, wrenches and a moving base, or with long names, or without parameters."""
    if name == "random":
        return random_machine(0, joints=4, symbolic=True, moving_base=True)
    if name == "long":
        return replace(chain(4), name="machine_of_many_words_that_has_a_long_name")
    if name == "steps":
        return replace(planar_2r(elastic=[2]), name="stepping")
    if name == "constant":
        return random_machine(1, joints=3)
    return read_machine(ROOT / "examples" / name)[0]


@cache
def package(name: str) -> Package:
    """All models of a machine."""
    models = ALL_MODELS if name == "random" else FIVE
    return trace_models(machine(name), Scene(models, steps=tuple(TimeStep) if name == "steps" else ())).package


@cache
def written(name: str, precision: str) -> dict[str, str]:
    """Names and texts of the files of the target `c-batch`."""
    return render_c_batch(package(name), PRECISIONS[precision])


def files(name: str, precision: Precision = DOUBLE) -> dict[str, str]:
    """Files for one state and for many."""
    return written(name, precision.name)


def scalar(name: str, precision: Precision = DOUBLE) -> str:
    """The source for one state."""
    return files(name, precision)[f"{machine(name).name}{precision.suffix}.c"]


def code(text: str) -> str:
    """A text without its comments."""
    return re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)


def compiled(texts: dict[str, str], folder: Path, *command: str) -> None:
    """Read each source by a compiler, without a warning."""
    for file, text in texts.items():
        (folder / file).write_text(text)
    for file in (file for file in texts if file.endswith(".c")):
        ran = subprocess.run([*command, file], cwd=folder, capture_output=True, text=True, check=False)
        assert ran.returncode == 0 and not ran.stderr, ran.stderr


# Text


@pytest.mark.thorough
@pytest.mark.sampled(16)
@pytest.mark.parametrize("precision", PRECISION)
@pytest.mark.parametrize("name", MACHINES)
def test_lines_are_short(name: str, precision: Precision) -> None:
    for file, text in files(name, precision).items():
        assert not [line for line in text.split("\n") if len(line) > LONGEST_LINE], file


@pytest.mark.parametrize("precision", PRECISION)
@pytest.mark.parametrize("name", MACHINES)
def test_it_is_c99_without_extensions_or_macros(name: str, precision: Precision) -> None:
    """No macros with arguments, no file of its own included twice; sums of two doubles need a pragma.

    The one attribute is for GCC and Clang: what large angles need stays out of the functions that call it.
    """
    text = re.sub(
        r"#ifdef __GNUC__\n#define (\w+_APART) __attribute__\(\(noinline\)\)\n#else\n#define \1\n#endif",
        "",
        code(scalar(name, precision)),
    )
    assert "__attribute__" not in text and "__builtin" not in text and "restrict" not in text
    assert not re.search(r"#define \w+\(", text) and not re.search(r'#include "\w+\.c"', text)
    assert precision.is_pair or "#pragma" not in text
    assert re.findall(r'#include "(.*)"', text) == [f"{machine(name).name}{precision.suffix}.h"]


@pytest.mark.parametrize("name", MACHINES)
def test_loops_and_branches_have_braces(name: str) -> None:
    lines = [line.strip() for line in code(scalar(name)).split("\n")]
    assert all(line.endswith("{") for line in lines if re.match(r"(if|for|while|\} else)\b", line))


@pytest.mark.sampled(20)
@pytest.mark.parametrize("precision", PRECISION)
@pytest.mark.parametrize("name", MACHINES)
def test_names_begin_with_that_of_the_machine(name: str, precision: Precision, tmp_path: Path) -> None:
    """Functions, types, macros, enumerators; the macros of compilers are only asked for.

    Symbols are listed of all machines in double precision, of one in the others.
    """
    own = machine(name).name
    header = files(name, precision)[f"{own}{precision.suffix}.h"]
    for text in map(code, (header, scalar(name, precision))):
        macros = re.findall(r"#define (\w+)", text) + re.findall(r"^    (\w+),?$", text, re.MULTILINE)
        assert all(macro.startswith(f"{own.upper()}_") for macro in macros), macros
        assert all(found.startswith(f"{own}_") for found in re.findall(r"^\} (\w+);", text, re.MULTILINE))
    if precision is not DOUBLE and name != "flex4.par":
        return
    compiled(files(name, precision), tmp_path, COMPILERS[0], "-std=c99", "-O0", "-c")
    command = ["nm", f"{own}{precision.suffix}.o"]
    listed = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    defined = [line.split()[-1] for line in listed.splitlines() if line.split()[-2] != "U"]
    statics = {found.split(".")[0] for found in defined} - {"half_pi", "of_sine", "of_cosine"}  # inside a function
    assert all(found.startswith(f"{own}_") for found in statics), statics


@pytest.mark.parametrize("name", MACHINES)
def test_the_banner_says_where_it_comes_from(name: str) -> None:
    source = "from two_axis.toml" if name == "two_axis.toml" else "symoro-elastic"
    for text in files(name).values():
        head = text.split("*/")[0]
        assert "Generated by symoro-elastic" in head and source in head and "do not edit" in head
        assert "Options: double precision" in head and "any licence you like" in head
        assert str(ROOT) not in text


def test_the_banner_holds_the_options() -> None:
    scene = Scene(("direct_dynamics",), fold=("l1", "m2"))
    text = render_c(trace_models(read_machine(ROOT / "examples" / "planar_2r.toml")[0], scene).package)["planar_2r.c"]
    assert "constants: l1, m2" in text.split("*/")[0]


def test_prototypes_state_the_sizes_of_arrays() -> None:
    header = " ".join(files("two_axis.toml")["two_axis.h"].split())
    prototype = (
        "void two_axis_direct_dynamics( const double q[TWO_AXIS_JOINTS], const double qd[TWO_AXIS_JOINTS], "
        "const double tau[TWO_AXIS_MOTORS], const double p[TWO_AXIS_PARAMETERS], double qdd[TWO_AXIS_JOINTS]);"
    )
    assert prototype in header and "double A[12*12]" in header


@pytest.mark.skipif("gcc" not in COMPILERS, reason="GCC compares the sizes of arrays")
def test_gcc_notices_an_array_that_is_too_short(tmp_path: Path) -> None:
    texts = {file: text for file, text in files("two_axis.toml").items() if file.endswith(".h")}
    texts["main.c"] = """#include "two_axis.h"
int main(void)
{
    double q[TWO_AXIS_JOINTS] = {0}, H[TWO_AXIS_JOINTS - 1];
    two_axis_bias_forces(q, q, two_axis_defaults, H);
    return H[0] > 0;
}
"""
    with pytest.raises(AssertionError, match="stringop-overflow"):
        compiled(texts, tmp_path, "gcc", *STRICT, "-O1", "-c")


# Compilers


@pytest.mark.sampled(60)
@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("precision", PRECISION)
@pytest.mark.parametrize("name", MACHINES)
def test_compilers_do_not_complain(name: str, precision: Precision, compiler: str, tmp_path: Path) -> None:
    compiled(files(name, precision), tmp_path, compiler, *STRICT, "-fsyntax-only")


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("precision", PRECISION)
def test_no_name_is_a_keyword_of_some_compiler(precision: Precision, compiler: str, tmp_path: Path) -> None:
    away = [f"-D{word}=" for word in COMPILERS_OWN]
    compiled(files("random", precision), tmp_path, compiler, "-std=c99", "-fsyntax-only", "-DI=_Imaginary_I", *away)


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("precision", PRECISION)
def test_libm_may_be_asked_for(precision: Precision, compiler: str, tmp_path: Path) -> None:
    macro = f"{machine('random').name}{precision.suffix}".upper()
    compiled(files("random", precision), tmp_path, compiler, *STRICT, "-fsyntax-only", f"-D{macro}_LIBM")


# Named numbers


def test_numbers_of_the_machine_have_names_meanings_and_units() -> None:
    text = scalar("two_axis.toml")
    assert "    const double k13 = 25000000.0; /* sensor_head: stiffness, N/m */\n" in text
    assert "    const double Gamma13 = -k13*q13;\n" in text
    assert "    const double k1 = 40000000.0; /* bed_yaw: stiffness, N m/rad */\n" in text
    assert "    const double Ia9 = 180.0; /* motor_y: rotor inertia, kg */\n" in text
    assert "    const double gravity_y = 9.81; /* gravity along y0, magnitude, m/s2 */\n" in text


def test_numbers_that_coincide_are_one_constant() -> None:
    text = scalar("two_axis.toml")
    assert "    const double J4_yy = 12.0; /* motor_secondary: inertia YY, inertia ZZ, kg m2 */\n" in text
    assert not re.search(r"const double J4_zz\b", text)


def test_numbers_whose_sign_is_reversed_say_so() -> None:
    """Equations hold magnitudes, so that they read the same with any value."""
    line = next(line for line in scalar("two_axis.toml").split("\n") if "const double minus_UH8_5 = 0.02;" in line)
    assert "sign reversed" in line and "-0.02" not in scalar("two_axis.toml")


def test_structural_numbers_stay_numbers() -> None:
    text = scalar("two_axis.toml")
    assert "= 2.0*qd1;" in text
    assert not re.search(r"const double \w+ = (0\.5|1\.0|2\.0|-1\.0|-2\.0|-0\.5);", text)


def test_a_name_of_the_user_stays_his() -> None:
    """A parameter called like a constant: that has no name then."""
    arm = machine("two_axis.toml")
    joints = (replace(arm.joints[0], d=Formula.parse("k13")), *arm.joints[1:])
    named = replace(arm, joints=joints, parameters=(*arm.parameters, Parameter("k13", Formula.parse("0.1"), "m")))
    text = render_c(trace_models(named, Scene(("inverse_dynamics",))).package)["two_axis.c"]
    assert "const double Gamma13 = -25000000.0*q13;" in text and "k13 = 25000000.0" not in text


def test_a_folded_parameter_keeps_its_name() -> None:
    arm = read_machine(ROOT / "examples" / "planar_2r.toml")[0]
    text = render_c(trace_models(arm, Scene(("inverse_dynamics",), fold="all")).package)["planar_2r.c"]
    assert re.search(r"const double l1 = 0\.4; /\* elbow: length d, m \*/", text)


@pytest.mark.parametrize("precision", PRECISION)
def test_each_name_has_one_value(precision: Precision) -> None:
    for body in re.split(r"\n}\n", scalar("two_axis.toml", precision)):
        names = re.findall(r"^    const \w+ (\w+) = ", body, re.MULTILINE)
        assert len(names) == len(set(names))


# Targets


AVOIDED = c.OWN | c_batch.OWN
"""Words of the templates: a variable of the user that is called so gets another local name."""


OF_VALUES = ("linuxcnc",)
"""Targets whose code holds the values of parameters."""


def test_targets_are_complete() -> None:
    for name, target in TARGETS.items():
        assert target.name == name and len(target.title) <= 80 and target.precisions
        made = render_targets(package("planar_2r.toml" if name in OF_VALUES else "flex4.par"), (name,))
        assert made and all(file.endswith(target.suffixes) for file in made)


def test_targets_with_scales_are_complete() -> None:
    """They refuse a package without scales, and take one that has them."""
    for name, target in SCALED_TARGETS.items():
        assert name not in TARGETS and target.name == name and len(target.title) <= 80 and target.precisions
        with pytest.raises(ValueError, match="has no scales"):
            target.render(package("flex4.par"), ())
        made = target.render(scaled_package(), ())
        assert made and all(file.endswith(target.suffixes) for file in made)


def scaled_package() -> Package:
    arm = read_machine(ROOT / "examples" / "planar_2r.toml")[0]
    return with_scales(trace_models(arm, Scene(("inverse_dynamics",), fold="all")), arm.limits)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_compilers_do_not_complain_of_fixed_point(compiler: str, tmp_path: Path) -> None:
    for name in SCALED_TARGETS:
        compiled(SCALED_TARGETS[name].render(scaled_package(), ()), tmp_path, compiler, *STRICT, "-fsyntax-only")


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("precision", PRECISION)
def test_words_of_templates_are_reserved_or_avoided(name: str, precision: Precision) -> None:
    """Macros, types and functions without the machine's name, and variables that no statement assigns."""
    own = machine(name).name
    for text in map(code, files(name, precision).values()):
        found = re.findall(r"#define (\w+)", text)
        found += re.findall(r"^(?:typedef .* |\} )(\w+);", text, re.MULTILINE)
        found += re.findall(r"^(?:INLINE|NOINLINE) \w+ (\w+)\(", text, re.MULTILINE)
        found += re.findall(r"^    \w+ (\w+)\[\d+\];", text, re.MULTILINE)
        others = {word for word in found if not word.lower().startswith(own.lower())}
        assert {word.removesuffix("_one") for word in others} - set(text_arrays()) <= RESERVED | AVOIDED, others


def text_arrays() -> tuple[str, ...]:
    """Arguments and results: names that a user cannot take either, or that the names of users give way to."""
    return (
        *("q", "qd", "qdd", "tau", "qdd_motor", "A", "H", "T", "J", "V", "Vd", "f", "E", "Y", "h", "X", "A_packed"),
        *(row.name for row in OF_TIME_STEPS),
    )


# MISRA C:2012

DEVIATIONS = set(re.findall(r"^\| (\d+\.\d+) \|", (ROOT / "docs" / "misra.md").read_text(), re.MULTILINE))


IN_PRECISION: dict[str, tuple[TimeStep, ...]] = {
    "double": (TimeStep.W3, TimeStep.RK4),
    "single": (TimeStep.RODAS4,),
    "mixed": (TimeStep.MIDPOINT, TimeStep.W2),
}
"""Every method once: the checker takes seconds for each."""


@pytest.mark.thorough
@pytest.mark.sampled(6)
@pytest.mark.skipif(not shutil.which("cppcheck"), reason="cppcheck and its MISRA addon are not installed")
@pytest.mark.parametrize("precision", PRECISION)
@pytest.mark.parametrize("name", ["random", "constant", "steps"])
def test_deviations_from_misra_are_documented(name: str, precision: Precision, tmp_path: Path) -> None:
    steps = IN_PRECISION.get(precision.name, ()) if name == "steps" else ()
    made = trace_models(machine(name), Scene(("bias_forces", "inertia_matrix"), steps=steps)).package
    texts = render_c(made, precision)
    for file, text in texts.items():
        (tmp_path / file).write_text(text)
    command = ["cppcheck", "--addon=misra", "--std=c99", "--quiet", *(file for file in texts if file.endswith(".c"))]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    if "misra-c2012" not in ran.stderr:
        pytest.skip(f"cppcheck has no MISRA addon: {ran.stderr}")
    found = set(re.findall(r"misra-c2012-(\d+\.\d+)", ran.stderr))
    assert found <= DEVIATIONS, f"{sorted(found - DEVIATIONS)}\n{ran.stderr[:4000]}"
