"""Equations as LaTeX, web pages and PDF: what is printed is read back and computed again."""

import random
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import pytest

import symoro_elastic as se
from symoro_elastic.codegen.closed_form import closed_equations, closed_forms
from symoro_elastic.codegen.latex import NAMED, arrays, number, solution
from symoro_elastic.codegen.notation import Notation
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs.catalogue import MODELS, trace, trace_scene
from symoro_elastic.pages.equations.page import html_page, latex_document, mathml, pieces
from symoro_elastic.pages.equations.pdf import ENGINES, pdf
from symoro_elastic.quantities import INTERMEDIATES
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.expression import Expression
from tests.command_line import run
from tests.counted_calls import calls_of
from tests.generated_code import ALL_MODELS
from tests.pages.document_readers import Page, Reader

pytestmark = pytest.mark.sampled(5)

ASKED = ("geometric_model", "inertia_matrix")
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

ODD = """
name = "odd_machine"
gravity = [0, 0, "-gravity_of_earth"]
joints = [
  { name = "base_turn", antecedent = 0, kind = "motor", sigma = 0, theta = "alpha + pi/5" },
  { name = "long_joint_name", antecedent = "base_turn", kind = "elastic", sigma = 0, alpha = "beta_2/2", d = "sqrt(L_1)", theta = "some_long_angle" },
  { name = "slide", antecedent = "long_joint_name", kind = "motor", sigma = 1, alpha = "atan2(L1, k_spring)", d = 1e-5, theta = "0.3", r = "x" },
]
[parameters]
gravity_of_earth = { value = 9.81, unit = "m/s2" }
beta_2 = {}
L_1 = { value = 1e-7, unit = "m" }
L1 = { value = 123456789 }
k_spring = {}
mu_1 = {}
alpha_body = {}
name_with_underscore = {}
[bodies]
base_turn = { mass = "name_with_underscore/3", first_moments = ["alpha_body", 0, 0], inertia_at_origin = [1, 2, 3] }
long_joint_name = { mass = 2.2, center_of_mass = [0, 0.1, 0], inertia = [1, "k_spring", 3.5e-9] }
slide = { mass = 2.2, first_moments = [0, "name_with_underscore", 250], inertia_at_origin = [1, "k_spring", 7] }
[springs]
long_joint_name = { stiffness = "k_spring", damping = "mu_1", neutral = 0.1 }
[friction]
base_turn = { coulomb = "mu_1", viscous = 3 }
"""  # noqa: E501

ONE_JOINT = """
name = "pendulum"
gravity = [0, "-g", 0]
joints = [{ name = "pivot", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" }]
[parameters]
g = {}
IZ = {}
MX = {}
[bodies]
pivot = { mass = 0, first_moments = ["MX", 0, 0], inertia_at_origin = [0, 0, "IZ"] }
"""


def machine(name):
    """The machine of a name; that of odd names has a parameter with signs to be escaped, which no file may have."""
    if name != "odd":
        return toml.read(ONE_JOINT, "one_joint.toml") if name == "one_joint" else read_machine(EXAMPLES / name)[0]
    whole = toml.read(ODD, "odd.toml")
    odd = [replace(x, unit="m<&>") if x.name == "L_1" else x for x in whole.parameters]
    return replace(whole, parameters=tuple(odd))


@cache
def made(name, model):
    """The package of one model of a machine, and its function."""
    whole = machine(name)
    found = package(whole, [trace(whole, model)], ())
    return found, found.functions[0]


CASES = [("odd", model) for model in ALL_MODELS if MODELS[model].family != "closed chains"] + [
    ("rx90.par", "direct_dynamics"),
    ("rx90.par", "inertia_matrix"),
    ("rx90.par", "jacobian"),
    ("two_axis.toml", "geometric_model"),
    ("two_axis.toml", "jacobian"),
    ("two_axis.toml", "inverse_dynamics"),
    ("flex4.par", "direct_dynamics"),
    ("planar_2r.toml", "bias_forces"),
    ("linkage.toml", "inverse_dynamics"),
    ("four_bar.par", "coupling_matrix"),
    ("gantry.toml", "constraint_forces"),
]
cases = pytest.mark.parametrize(("name", "model"), CASES)


def given_values(program):
    """Random values of every variable of a program, by name."""
    source = random.Random(5)
    names = sorted({*program.used, *(name for argument in program.inputs for name in argument.symbols)})
    return {name: source.uniform(0.3, 1.5) for name in names}


@cases
def test_each_equation_says_what_the_program_computes(name, model):
    """Read in order, from the inputs alone: nothing is used before it is defined, nothing defined twice."""
    found, function = made(name, model)
    program = function.program
    solved = solution(found, function)
    by_name = given_values(program)
    values = {solved.notation[name]: value for name, value in by_name.items()}
    reader = Reader(solved.notation.symbols.values())
    statements = [*program.once, *program.statements]
    entries = [x for output in program.outputs for x in output.entries]
    computed = evaluate([*entries, *(s.node for s in statements)], by_name, FLOATS)
    printed = [e for stretch in (*solved.once, *solved.steps) for e in stretch.equations]
    assert len(printed) == len(statements)
    for equation, statement in zip(printed, statements, strict=True):
        assert equation.left not in values
        expected = computed(statement.node) * (-1 if statement.negative else 1)
        values[equation.left] = reader.value(equation.right, values)
        assert values[equation.left] == pytest.approx(expected, rel=1e-9, abs=1e-9)
    shown = [x for cells in result_cells(solved, values) for x in cells]
    written = arrays(found, function)
    whole = [x for array in written if array.fits for x in array.output.entries]
    assert shown == pytest.approx([computed(x) for x in whole], rel=1e-9, abs=1e-9)
    for array in written:
        for symbol, x in zip(array.entries, array.output.entries, strict=True):
            assert array.fits or values.get(symbol, 0) == pytest.approx(computed(x), rel=1e-9, abs=1e-9)


def result_cells(solved, values):
    """Values of the entries of each array among the results."""
    single = [e for e in solved.results if "pmatrix" not in e.right]
    reader = Reader([*values, *(e.left for e in single)])
    assert values.keys().isdisjoint(e.left for e in single)
    values |= {e.left: reader.value(e.right, values) for e in single}
    for equation in solved.results:
        if equation not in single:
            inside = equation.right.removeprefix(r"\begin{pmatrix} ").removesuffix(r" \end{pmatrix}")
            yield [reader.value(cell, values) for cell in re.split(r" & | \\\\ ", inside)]


@pytest.mark.sampled(30)
@cases
def test_closed_forms_have_the_values_of_the_program(name, model):
    sympy = pytest.importorskip("sympy")
    _, function = made(name, model)
    program = function.program
    by_name = given_values(program)
    notation = Notation(program)
    values = {notation[name]: value for name, value in by_name.items()}
    entries = {x.id: x for o in program.outputs for x in o.entries if isinstance(x, Expression)}
    computed = evaluate(entries.values(), by_name, FLOATS)
    reader = Reader(values)
    for key, form in closed_forms(program.outputs, notation).items():
        expected = computed(entries[key])
        substituted = form.expression.subs({sympy.Symbol(name): value for name, value in by_name.items()})
        assert float(substituted) == pytest.approx(expected, rel=1e-9, abs=1e-12)
        assert reader.value(form.latex, values) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def written_out(name, model):
    found, function = made(name, model)
    return {e.left: e.right for e in closed_equations(found, function, Notation(function.program))}


def test_the_planar_arm_has_the_textbook_models():
    masses = written_out("planar_2r.toml", "inertia_matrix")
    l1, lc1, lc2 = "l_{1}", r"\mathit{lc}_{1}", r"\mathit{lc}_{2}"
    own = rf"I_{{2}} + {l1}\,{lc2}\,m_{{2}}\,\cos q_{{2}} + {lc2}^{{2}}\,m_{{2}}"
    assert masses["A_{2,2}"] == rf"I_{{2}} + {lc2}^{{2}}\,m_{{2}}"
    assert masses["A_{1,2} = A_{2,1}"] == own
    assert masses["A_{1,1}"] == (
        rf"I_{{1}} + I_{{2}} + {l1}^{{2}}\,m_{{2}} + 2\,{l1}\,{lc2}\,m_{{2}}\,\cos q_{{2}}"
        rf" + {lc1}^{{2}}\,m_{{1}} + {lc2}^{{2}}\,m_{{2}}"
    )
    forces = written_out("planar_2r.toml", "bias_forces")
    assert forces["H_{2}"] == (
        rf"g_{{0}}\,{lc2}\,m_{{2}}\,\cos(q_{{1}} + q_{{2}}) + {l1}\,{lc2}\,m_{{2}}\,\dot{{q}}_{{1}}^{{2}}\,\sin q_{{2}}"
    )
    assert forces["H_{1}"].endswith(rf"- {l1}\,{lc2}\,m_{{2}}\,\dot{{q}}_{{2}}^{{2}}\,\sin q_{{2}}")
    tip = written_out("planar_2r.toml", "geometric_model")["{}^{0}T_{3}"]
    assert r"l_{1}\,\cos q_{1} + l_{2}\,\cos(q_{1} + q_{2})" in tip


def test_results_are_numbered_by_what_was_asked_for():
    arm = machine("planar_2r.toml")
    scene = Scene(outputs={"geometric_model": ("tip in shoulder",), "inertia_matrix": ("elbow",)}, models=ASKED)
    found = package(arm, trace_scene(arm, scene), ())
    placed, masses = (arrays(found, function)[0] for function in found.functions)
    assert placed.wholes == ("{}^{1}T_{3}",)
    assert placed.entries[3] == "{}^{1}T_{3,1,4}"
    assert masses.entries == ("A_{2,2}",)


def test_a_pendulum_in_one_line():
    assert written_out("one_joint", "direct_dynamics") == {
        r"\ddot{q}_{1}": r"\frac{\Gamma_{1} - \mathit{MX}\,g\,\cos q_{1}}{\mathit{IZ}}"
    }


def test_long_results_are_not_tried():
    assert written_out("rx90.par", "direct_dynamics") == {}


@pytest.mark.thorough
def test_symbols_are_never_shared():
    for name, model in CASES:
        _, function = made(name, model)
        symbols = Notation(function.program).symbols
        assert len(set(symbols.values())) == len(symbols)


def test_names_that_would_look_alike_keep_their_own_spelling():
    symbols = Notation(made("odd", "direct_dynamics")[1].program).symbols
    assert symbols["L1"] == "L_{1}"
    assert symbols["L_1"] == r"\mathit{L\_1}"
    assert symbols["alpha"] == r"\alpha"
    assert symbols["name_with_underscore"] == r"\mathit{name\_with\_underscore}"
    assert symbols["k_spring"] == r"k_{\mathrm{spring}}"


@pytest.mark.thorough
def test_every_quantity_of_the_models_is_in_the_table():
    """A new quantity needs a row in quantities/intermediates.py."""
    for name, model in CASES:
        _, function = made(name, model)
        notation = Notation(function.program)
        for statement in (*function.program.once, *function.program.statements):
            assert notation.quantity(statement.name) or statement.name.startswith("result"), statement.name


def test_names_become_the_symbols_of_the_paper():
    symbols = Notation(made("rx90.par", "direct_dynamics")[1].program).symbols
    assert symbols["H6"] == "H_{6}"
    assert symbols["Hinv6"] == "H^{-1}_{6}"
    assert symbols["Js4_33"] == "J^{*}_{4,33}"
    assert symbols["K5_14a"] == r"K^{\mathrm{a}}_{5,14}"
    assert symbols["bs5_1"] == r"\beta^{*}_{5,1}"
    assert symbols["al6_1"] == r"\boldsymbol{\alpha}_{6,1}"
    assert symbols["w3_x"] == r"\omega_{3x}"
    assert symbols["wd3_x"] == r"\dot{\omega}_{3x}"
    assert symbols["qd5"] == r"\dot{q}_{5}"
    assert symbols["tau5"] == r"\Gamma_{5}"
    assert symbols["sin_th2"] == r"\mathrm{S}_{\mathit{th}_{2}}"
    assert symbols["RL4"] == r"\mathit{RL}_{4}"
    assert symbols["XX3"] == r"\mathit{XX}_{3}"
    symbols = Notation(made("rx90.par", "inverse_dynamics")[1].program).symbols
    assert symbols["ww3_xy"] == r"\overline{\omega_{3x}\,\omega_{3y}}"
    assert symbols["ww3_xx"] == r"\overline{\omega_{3x}^{2}}"


@pytest.mark.parametrize(
    ("value", "printed"),
    [
        (0, "0"),
        (-2, "2"),
        (Fraction(1, 2), "0.5"),
        (Fraction(1, 3), r"\frac{1}{3}"),
        (Fraction("0.0001"), "0.0001"),
        (Fraction("1e-5"), "10^{-5}"),
        (Fraction("1.5e8"), r"1.5 \cdot 10^{8}"),
        (Fraction("0.1") + Fraction("0.2"), "0.3"),
        (123456, "123456"),
        (Fraction(10**9 + 1, 3 * 10**9), "0.3333333336666667"),
    ],
)
def test_numbers_are_short_and_exact(value, printed):
    assert number(value).text == printed
    assert number(value).negative == (value < 0)


@pytest.mark.sampled(30)
@cases
def test_latex_is_balanced_and_plain(name, model):
    text = latex_document(*made(name, model))
    depth = 0
    for brace in re.findall(r"(?<!\\)[{}]", text):
        depth += 1 if brace == "{" else -1
        assert depth >= 0
    assert depth == 0
    assert re.findall(r"\\usepackage(?:\[.*?\])?{(.*?)}", text) == ["inputenc", "amsmath", "geometry"]
    assert sorted(re.findall(r"\\begin{(\w+)}", text)) == sorted(re.findall(r"\\end{(\w+)}", text))


@pytest.mark.sampled(30)
@cases
def test_the_page_stands_alone(name, model):
    text = html_page(*made(name, model))
    page = Page(text)
    assert all(reference.startswith("#") for reference in page.references)
    assert {reference[1:] for reference in page.references} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert not re.search(r"https?:|url\(|@import|<script[^>]+src|<img|<link", text)


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "model"), [("odd", "direct_dynamics"), ("rx90.par", "inertia_matrix")])
def test_pages_are_repeatable(name, model):
    for page in (latex_document, html_page):
        text = page(*made(name, model))
        assert text == page(*made.__wrapped__(name, model))


def test_joints_that_follow_others_are_named_so():
    found, function = made("linkage.toml", "coupling_matrix")
    text = latex_document(found, function)
    for name, kind in (("rotor", "coupled"), ("forearm", "passive, given by a loop, $q_{3}$ in rad"), ("pin", "cut")):
        assert rf"\makebox[45mm][l]{{{name}}}{kind}\par" in text
    assert "docs/loop\\_equations.md" in text and "closed chains" not in latex_document(*made("odd", "inertia_matrix"))
    assert "docs/loop_equations.md" in html_page(found, function)


def test_text_of_the_user_is_escaped():
    found, function = made("odd", "direct_dynamics")
    assert "m&lt;&amp;&gt;" in html_page(found, function)
    assert r"m\textless{}\&\textgreater{}" in latex_document(found, function)
    assert "long_joint_name" in "".join(Page(html_page(found, function)).text)
    assert r"long\_joint\_name" in latex_document(found, function)


@pytest.mark.thorough
def test_bytes_do_not_depend_on_the_hash_seed():
    code = (
        "import hashlib, sys; sys.path.insert(0, sys.argv[1]);"
        "from tests.pages.test_equations import *; found = made('odd', 'direct_dynamics');"
        "print(hashlib.sha256((latex_document(*found) + html_page(*found)).encode()).hexdigest())"
    )
    root = str(EXAMPLES.parent)
    runs = {
        subprocess.run(
            [sys.executable, "-c", code, root], env={"PYTHONHASHSEED": seed}, capture_output=True, check=True, cwd=root
        ).stdout
        for seed in ("1", "2")
    }
    assert len(runs) == 1


def test_mathml_of_every_symbol_of_the_table():
    for row in INTERMEDIATES:
        Page(mathml(row.symbol()) + mathml(row.symbol("12", part="ab")) + mathml(row.definition))


def test_mathml_breaks_long_sums_between_terms():
    assert list(pieces(r"a - \frac{b + c}{d} + 2\,(e - f)")) == [
        mathml(part) for part in ("a", r"- \frac{b + c}{d}", r"+ 2\,(e", "- f)")
    ]


def test_mathml_refuses_what_it_does_not_know():
    for latex in (r"\unknown{a}", "a_b", "{a", "a}"):
        with pytest.raises(ValueError, match="not expected"):
            mathml(latex)


def generic_chain(count):
    """Motors in a row, a parameter and an inertia each."""
    angles = ("0", "pi/2", "-pi/2")
    rows, numbers = [], range(1, count + 1)
    for j in numbers:
        before = f'"j{j - 1}"' if j > 1 else 0
        rows.append(
            f'{{ name = "j{j}", antecedent = {before}, kind = "motor", sigma = 0, theta = "t{j}",'
            f' alpha = "{angles[j % 3]}", d = "D{j}", r = 0.1 }}'
        )
    bodies = [f"j{j} = {{ mass = 1, center_of_mass = [0.1, 0.2, 0.3], inertia = [1, 2, 3] }}" for j in numbers]
    parameters = [f"D{j} = {{}}" for j in numbers]
    lines = ['name = "chain"', f"joints = [{', '.join(rows)}]", "[parameters]", *parameters, "[bodies]", *bodies]
    text = "\n".join(lines)
    return toml.read(text, "chain.toml")


@pytest.mark.thorough
def test_pages_of_a_twenty_joint_chain_take_seconds_at_most():
    """Counted in function calls, some millions a second; the inertia matrix is quadratic in the joints."""

    def pages(whole):
        for model in ("direct_dynamics", "inertia_matrix"):
            found = package(whole, [trace(whole, model)], ())
            html_page(found, found.functions[0])
            latex_document(found, found.functions[0])

    pages(generic_chain(2))
    few, many = (calls_of(lambda n=n: pages(generic_chain(n))) for n in (10, 20))
    assert many < 4.1 * few and many < 9_000_000


def test_without_latex_the_message_says_what_works(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(InputError, match=r"no LaTeX is installed .*: use --format latex or html"):
        pdf("", tmp_path / "a.pdf")
    assert not list(tmp_path.iterdir())


needs_latex = pytest.mark.skipif(not shutil.which("pdflatex"), reason="pdflatex is not installed")


@needs_latex
def test_a_document_that_fails_leaves_nothing(tmp_path):
    with pytest.raises(InputError, match=r"failed .*Undefined control sequence.*: use --format latex or html"):
        pdf(r"\documentclass{article}\begin{document}\nonsense\end{document}", tmp_path / "a.pdf")
    assert not list(tmp_path.iterdir())


@needs_latex
@pytest.mark.parametrize(("name", "model"), CASES[:6])
def test_documents_compile_until_page_numbers_are_right(name, model, tmp_path, monkeypatch):
    tex = latex_document(*made(name, model))
    first = pdf(tex, tmp_path / "a.pdf").read_bytes()
    assert first.startswith(b"%PDF")
    options, runs = ENGINES["pdflatex"]
    monkeypatch.setitem(ENGINES, "pdflatex", (options, runs + 1))
    assert first == pdf(tex, tmp_path / "b.pdf").read_bytes()


SEVERAL = ("inertia_matrix", "bias_forces", "inverse_dynamics")


@pytest.mark.thorough
def test_several_models_are_on_one_page(tmp_path):
    """Each with its own summary and places; links of a model lead to its own lines."""
    alone = [se.equations("examples/planar_2r.toml", name) for name in SEVERAL]
    together = se.equations("examples/planar_2r.toml", SEVERAL)
    assert together.models == SEVERAL and together.headline == f"Equations of planar_2r: {', '.join(SEVERAL)}"
    page = Page(html_page(together.package, *together.functions))
    assert {reference[1:] for reference in page.references} <= set(page.ids)
    assert len(page.ids) == len(set(page.ids))
    assert sorted(set(page.ids)) == sorted(
        [
            f"{name}-{place}"
            for name, one in zip(SEVERAL, alone, strict=True)
            for place in Page(html_page(one.package, *one.functions)).ids
        ]
        + [f"{name}-model" for name in SEVERAL]
    )
    for one in alone:
        assert all(line in together.latex for line in one.latex.splitlines() if line.startswith(r"\eqline"))
    assert together.latex.count(r"\section{Symbols}") == 3
    file = tmp_path / "eq.html"
    flags = [word for name in SEVERAL for word in ("--model", name)]
    run("equations", "examples/planar_2r.toml", *flags, "--out", file)
    assert file.read_text() == together.html


def test_short_matrices_are_written_whole_with_their_cost_below():
    """A(q) and H(q, qd) of two links, and what the steps below take."""
    for name, whole in (("inertia_matrix", "A"), ("bias_forces", "H")):
        latex = se.equations("examples/planar_2r.toml", name).latex
        written = latex.partition(r"\section{Written out}")[2].partition(r"\section")[0]
        lines = [line for line in written.splitlines() if line]
        assert lines[-2].startswith(rf"\eqline{{{whole}}}{{\begin{{pmatrix}}")
        assert lines[-1].startswith(r"\medskip Computed by the equations below: ")


@pytest.mark.parametrize("latex", NAMED.values())
def test_mathml_of_every_function_of_equations(latex):
    Page(mathml(f"{latex}(q_{{1}}, q_{{2}})"))
