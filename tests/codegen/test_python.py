"""The target python, and functions of backend c: the bits of C, arguments of all kinds, nothing left behind."""

from __future__ import annotations

import gc
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import symoro_elastic as se
from symoro_elastic.codegen import extension
from symoro_elastic.codegen.c.calls import called_functions
from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.extension import extension_functions
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.codegen.targets.python import ARRAYS, AXES, render_calls, render_python
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import fill_folder
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.verification.implementations import import_package
from symoro_elastic.quantities.time_steps import TimeStep
from tests.codegen.backends.compared import machine
from tests.generated_code import ALL_MODELS, COMPILERS
from tests.references.random_machines import chain

FLAGS = ("-O1", "-ffp-contract=off")
MODELS = {
    "planar_2r.toml": (*ALL_MODELS, "regressor", "direct_dynamics_derivatives", "linearization"),
    "two_axis.toml": ("direct_dynamics", "inverse_dynamics", "inertia_matrix"),
    "puma560.par": ("inverse_dynamics", "inverse_geometric_model"),
    "without_closed_form": ("direct_dynamics", "assemble"),
    "floating_arm.toml": ("direct_dynamics", "geometric_model"),
}
STEPS = {
    "planar_2r.toml": (TimeStep.W3, TimeStep.RODAS4, TimeStep.RK4, TimeStep.MIDPOINT),
    "sr400.par": (TimeStep.W3,),
    "floating_arm.toml": (TimeStep.W3,),
    "two_axis.toml": (TimeStep.W3,),
}
STRIDED = np.arange(12.0).reshape(6, 2) / 7

Array = np.ndarray[Any, Any]


class Loaded:
    """Functions of a package: compiled for Python, on numpy, and in C through ctypes."""

    def __init__(self, package: Package, folder: Path) -> None:
        self.package = package
        self.numpy = import_package(render_numpy(package), folder / "numpy")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(extension, "FLAGS", FLAGS)
            self.compiled = extension_functions(package, folder / "extension", vars(self.numpy))
        library = compile_library(render_c_batch(package), folder / "c", flags=FLAGS)
        self.by_ctypes = CompiledPackage(package, library)
        self.inputs = {called.name: called.inputs for called in called_functions(package)}

    def c(self, name: str, *values: Any) -> tuple[Array, ...]:
        names = [array.name for array in self.inputs[name]]
        return tuple(self.by_ctypes.call(name, **dict(zip(names, values, strict=False))).values())


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> Any:
    @cache
    def load(example: str, with_steps: bool = False) -> Loaded:
        models = ("direct_dynamics",) if with_steps else MODELS[example]
        scene = Scene(models, steps=STEPS[example] if with_steps else ())
        return Loaded(programs(machine(example), scene).package, tmp_path_factory.mktemp("python"))

    return load


def drawn(of: Loaded, name: str, states: tuple[int, ...], seed: int = 0) -> list[Array]:
    """Inputs but p, different at each state; rotations and placements are of no matter here."""
    rng = np.random.default_rng(seed)
    return [rng.uniform(-1.0, 1.0, (*states, *array.shape)) for array in of.inputs[name][:-1]]


def results_of(found: Any) -> tuple[Array, ...]:
    return found if isinstance(found, tuple) else (found,)


def same(found: Any, expected: Any) -> bool:
    pairs = zip(results_of(found), results_of(expected), strict=True)
    return all(x.dtype == y.dtype and x.shape == y.shape and np.array_equal(x, y, True) for x, y in pairs)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("example", MODELS)
def test_models_have_the_bits_of_c(loaded: Any, example: str) -> None:
    """One state, few, and so many that vectors compute them in blocks; p for each state, too."""
    of = loaded(example)
    rng = np.random.default_rng(1)
    p = np.nan_to_num(of.numpy.DEFAULTS, nan=0.7) * rng.uniform(0.9, 1.1, len(of.numpy.DEFAULTS))
    assert {function.name for function in of.package.functions} == of.compiled.keys()
    for name, function in of.compiled.items():
        for states in ((), (3,), (2, 80)):
            values = drawn(of, name, states)
            assert same(function(*values), of.c(name, *values)), name
            assert same(function(*values, p), of.c(name, *values, p)), name
        values, sets = drawn(of, name, (20,)), np.stack([p] * 20) * rng.uniform(0.9, 1.1, (20, 1))
        assert same(function(*values, sets), of.c(name, *values, sets)), name


@pytest.mark.sampled(4)
@pytest.mark.parametrize("example", STEPS)
def test_time_steps_are_those_of_numpy(loaded: Any, example: str) -> None:
    """Many states have the bits of one; numpy has other sines and another order of sums."""
    of = loaded(example, with_steps=True)
    steps = [name for name in of.compiled if name.startswith("step_")]
    assert steps == [name for name in vars(of.numpy) if name.startswith("step_")]
    p = np.nan_to_num(of.numpy.DEFAULTS, nan=0.7)
    for name in steps:
        values = [
            1e-3 if array.name == "h" else x for array, x in zip(of.inputs[name], drawn(of, name, (20,)), strict=False)
        ]
        found, expected = (results_of(f(*values, p)) for f in (of.compiled[name], getattr(of.numpy, name)))
        lengths = np.linspace(1e-3, 2e-3, 20)
        with_lengths = results_of(of.compiled[name](*(lengths if type(x) is float else x for x in values), p))
        for k in (0, 19):
            state = [x if type(x) is float else x[k] for x in values]
            alone = results_of(of.compiled[name](*state, p))
            other = results_of(of.compiled[name](*(lengths[k] if type(x) is float else x for x in state), p))
            assert same(alone, tuple(x[k] for x in found)) and same(other, tuple(x[k] for x in with_lengths)), name
        for x, y in zip(found, expected, strict=True):
            scale = max(1.0, float(np.abs(y).max(initial=0.0)))
            assert np.abs(x - y).max(initial=0.0) <= 1e-9 * scale, name


KINDS = {
    "rows of a wider array": lambda x: np.repeat(x, 2, axis=-1)[..., ::2],
    "by columns": np.asfortranarray,
    "reversed": lambda x: x[..., ::-1].copy()[..., ::-1],
    "of the other byte order": lambda x: x.astype(x.dtype.newbyteorder()),
    "unaligned": lambda x: np.frombuffer(b"x" + x.tobytes(), dtype=np.uint8)[1:].view(float).reshape(x.shape),
    "read-only": lambda x: np.lib.stride_tricks.as_strided(x, writeable=False),
    "single precision": lambda x: x.astype(np.float32),
    "extended precision": lambda x: x.astype(np.longdouble),
    "lists": lambda x: x.tolist(),
    "tuples of numpy's numbers": lambda x: tuple(x) if x.ndim == 1 else tuple(map(tuple, x.tolist())),
    "objects": lambda x: x.astype(object),
    "of a subclass": lambda x: x.view(np.recarray),
    "unmasked": lambda x: np.ma.array(x, mask=np.zeros(x.shape, bool)),
    "with a dtype of its own": lambda x: x.astype(np.dtype("f8", metadata={"unit": "rad"})),
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("states", [(), (30,)])
def test_arrays_of_any_kind_are_read(loaded: Any, kind: str, states: tuple[int, ...]) -> None:
    of = loaded("planar_2r.toml")
    values = [x.astype(np.float32).astype(float) for x in drawn(of, "inverse_dynamics", states)]
    expected = of.c("inverse_dynamics", *values)
    before = [x.copy() for x in values]
    assert same(of.compiled["inverse_dynamics"](*map(KINDS[kind], values)), expected)
    assert same(of.compiled["inverse_dynamics"](values[0], KINDS[kind](values[1]), qdd_motor=values[2]), expected)
    assert all(np.array_equal(x, y) for x, y in zip(values, before, strict=True))


def test_whole_numbers_and_truths_are_numbers(loaded: Any) -> None:
    of = loaded("planar_2r.toml")
    expected = of.c("inverse_dynamics", [1.0, 2.0], [0.0, 1.0], [3.0, 0.0])
    given_ = ([1, 2], np.array([False, True]), np.array([3, 0], np.int8))
    assert same(of.compiled["inverse_dynamics"](*given_), expected)
    assert same(of.compiled["inverse_dynamics"]((1, np.float64(2)), [False, True], np.array([3, 0], "u8")), expected)


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_axes_of_states_broadcast_as_in_numpy(loaded: Any, data: st.DataObject) -> None:
    of = loaded("planar_2r.toml")
    shapes = data.draw(arrays.mutually_broadcastable_shapes(num_shapes=4, max_dims=3, max_side=9, min_side=0))
    rng = np.random.default_rng(len(shapes.result_shape))
    values = [
        rng.uniform(-1, 1, (*lead, x.entries))
        for lead, x in zip(shapes.input_shapes, of.inputs["direct_dynamics"], strict=True)
    ]
    found = of.compiled["direct_dynamics"](*values)
    assert found.shape == (*shapes.result_shape, 2) and same(found, of.c("direct_dynamics", *values))


def test_matrices_stand_for_rows(loaded: Any) -> None:
    of = loaded("puma560.par")
    T = np.stack([np.eye(4)] * 10) + 1e-3
    function = of.compiled["inverse_geometric_model"]
    assert same(function(T), function(T.reshape(10, 16))) and same(function(T[0]), function(T[0].ravel()))
    with pytest.raises(ValueError, match=r"^T has shape \(3, 4\): \(\.\.\., 16\) is expected$"):
        function(T[0, :3])


WRONG: tuple[tuple[tuple[Any, ...], dict[str, Any]], ...] = (
    (([1.0, 2.0],), {}),
    (([0.0] * 2,) * 5, {}),
    (([0.0] * 2,) * 2, {"qdd_motor": [0.0] * 2, "v": 1}),
    (([0.0] * 2,) * 3, {"q": [0.0] * 2}),
    (([0.0] * 2,) * 3, {"p": np.zeros(8)}),
    (([0.0] * 3, [0.0] * 2, [0.0] * 2), {}),
    ((0.0, [0.0] * 2, [0.0] * 2), {}),
    ((np.zeros((2, 3)), [0.0] * 2, [0.0] * 2), {}),
    ((np.zeros((3, 2)), np.zeros((4, 2)), [0.0] * 2), {}),
    (([1j, 0.0], [0.0] * 2, [0.0] * 2), {}),
)


@pytest.mark.parametrize(("values", "named"), WRONG)
def test_wrong_calls_are_refused_as_by_numpy(loaded: Any, values: tuple[Any, ...], named: dict[str, Any]) -> None:
    """The same class; the same sentence where shapes or numbers are wrong, as Python's own sentences differ."""
    of, said = loaded("planar_2r.toml"), []
    for function in (of.compiled["inverse_dynamics"], of.numpy.inverse_dynamics):
        with pytest.raises((TypeError, ValueError)) as error:
            function(*values, **named)
        said.append((error.type, str(error.value)))
    assert said[0][0] is said[1][0]
    assert said[0] == said[1] or "argument" in said[1][1]


@pytest.mark.parametrize(
    ("value", "what"),
    [("ab", "text"), (None, "None"), (np.array(["a", "b"]), "text"), (np.zeros(2, "M8[s]"), "dates"),
     (np.ma.array([1.0, 2.0], mask=[0, 1]), "masked ones"), ([0.0, 1j], "complex ones"), ([0.0, "x"], "text")],
)  # fmt: skip
def test_what_is_no_real_number_is_refused(loaded: Any, value: Any, what: str) -> None:
    function = loaded("planar_2r.toml").compiled["inverse_dynamics"]
    with pytest.raises(TypeError, match=f"^arguments are real numbers, not {what}$"):
        function([0.0, 0.0], value, qdd_motor=[0.0, 0.0])
    with pytest.raises(TypeError, match=f"^arguments are real numbers, not {what}$"):
        function([0.0, 0.0], [0.0, 0.0], [0.0, 0.0], p=value)


# Results in arrays of the user


@pytest.mark.parametrize("states", [(), (3,), (40,)])
def test_results_are_written_to_arrays_that_are_given(loaded: Any, states: tuple[int, ...]) -> None:
    of = loaded("planar_2r.toml")
    values = drawn(of, "inverse_dynamics", states)
    expected = of.c("inverse_dynamics", *values)
    wide = np.full((*states, 4), np.nan)
    for out in (
        tuple(np.full_like(x, np.nan) for x in expected),
        (wide[..., :2], wide[..., 2:]),
        (wide[..., ::2], wide[..., 1::2]),
        tuple(np.asfortranarray(x) for x in expected),
    ):
        returned = of.compiled["inverse_dynamics"](*values, out=out)
        assert returned is out and same(out, expected)
    A = np.empty((*states, 2, 2))
    assert of.compiled["inertia_matrix"](values[0], out=A) is A and same(A, of.c("inertia_matrix", values[0]))
    assert same(of.compiled["inertia_matrix"](values[0], out=None), A)


@pytest.mark.parametrize("count", [1, 5, 200])
def test_results_may_take_the_place_of_arguments(loaded: Any, count: int) -> None:
    """In place, and in rows that are shifted against them."""
    of = loaded("planar_2r.toml")
    values = drawn(of, "direct_dynamics", (count,))
    expected = of.c("direct_dynamics", *values)
    for k in range(3):
        again = [x.copy() for x in values]
        of.compiled["direct_dynamics"](*again, out=again[k])
        assert same(again[k], expected)
        shared = np.zeros((count + 1, 2))
        shared[:-1] = values[k]
        again = [x if i != k else shared[:-1] for i, x in enumerate(values)]
        of.compiled["direct_dynamics"](*again, out=shared[1:])
        assert same(shared[1:], expected)


def fixed(x: Array) -> Array:
    x.flags.writeable = False
    return x


@pytest.mark.parametrize(
    ("out", "error", "what"),
    [
        (np.empty(2), TypeError, "out is a tuple of 2 arrays"),
        ((np.empty(2),), TypeError, "out is a tuple of 2 arrays"),
        ([np.empty(2), np.empty(2)], TypeError, "out is a tuple of 2 arrays"),
        ((np.empty(2), [0.0, 0.0]), TypeError, "out is an array of float64 for each result"),
        ((np.empty(2), np.empty(2, "f4")), TypeError, "out is an array of float64 for each result"),
        ((np.zeros(2), np.empty(3)), ValueError, r"out has shape \(3,\): a writeable array of shape \(2,\) is"),
        ((np.zeros(2), np.empty((1, 2))), ValueError, r"out has shape \(1, 2\): "),
        ((np.zeros(2), fixed(np.empty(2))), ValueError, r"out has shape \(2,\) and is read-only: "),
    ],
)  # fmt: skip
def test_other_arrays_for_results_are_refused(loaded: Any, out: Any, error: type[Exception], what: str) -> None:
    function = loaded("planar_2r.toml").compiled["inverse_dynamics"]
    first = out[0].copy()
    with pytest.raises(error, match=f"^{what}"):
        function([0.1, 0.2], [0.1, 0.2], [0.1, 0.2], out=out)
    assert np.array_equal(out[0], first, True)


# What a call costs, and leaves behind


def calls_of(of: Loaded) -> Iterator[Any]:
    function, (q, qd, a) = of.compiled["inverse_dynamics"], drawn(of, "inverse_dynamics", (30,))
    out = np.empty((30, 2)), np.empty((30, 2))
    for values, named in (
        ((q[0], qd[0], a[0]), {}),
        ((q, qd, a), {}),
        ((q, qd), {"qdd_motor": a[0], "out": out}),
        ((q[:, ::-1], qd.astype("f4"), [0.0, 1.0]), {}),
        ((q[:, None], qd[:4], a[0]), {}),
        ((q, qd, a), {"out": (q, qd)}),
        *(((q[0], *values[1:]) if values[1:] else values, named) for values, named in WRONG),
    ):
        yield lambda values=values, named=named: function(*values, **named)


def test_calls_leave_nothing_behind(loaded: Any) -> None:
    """Neither memory nor references, of calls that succeed and of those that are refused.

    A leak counts in each of several rounds; what else a process does in the meantime (its workers, caches), in some.
    """
    of, counts = loaded("planar_2r.toml"), []
    held = [np.dtype(float), of.numpy.DEFAULTS, of.compiled["inverse_dynamics"], None]
    calls = [*calls_of(of)]
    for times in (20, 100, 100, 100, 100):
        for call in calls * times:
            with suppress(TypeError, ValueError):
                call()
        gc.collect()
        counts.append([sys.getallocatedblocks(), *map(sys.getrefcount, held)])
    growths = np.diff(counts[1:], axis=0)
    assert (growths.min(axis=0) < 50).all() and (growths.max(axis=0) > -50).all(), growths


def test_plain_calls_run_no_python(loaded: Any) -> None:
    """No function of Python is called for arrays and lists of numbers, at one state or many."""
    of, seen = loaded("planar_2r.toml"), []
    function, (q, qd, a) = of.compiled["inverse_dynamics"], drawn(of, "inverse_dynamics", (30,))
    out, x = (np.empty((30, 2)), np.empty((30, 2))), (q[0], qd[0].tolist(), a[0].astype("f4"))
    sys.setprofile(lambda frame, event, _: seen.append(frame.f_code.co_name) if event == "call" else None)
    function(*x)
    function(q, qd, a)
    function(q[::2], qd[1::2], qdd_motor=a[0], out=None)
    function(q, qd, a, out=out)
    sys.setprofile(None)
    assert seen == []


def test_threads_call_at_the_same_time(loaded: Any) -> None:
    of = loaded("planar_2r.toml")
    function, values = of.compiled["inverse_dynamics"], drawn(of, "inverse_dynamics", (4000,))
    expected = of.c("inverse_dynamics", *values)
    out = tuple(np.empty((4000, 2)) for _ in range(2))

    def part(k: int) -> None:
        piece = slice(100 * k, 100 * (k + 1))
        function(*(x[piece] for x in values), out=tuple(x[piece] for x in out))

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(part, range(40)))
    assert same(out, expected)


def test_functions_describe_themselves(loaded: Any) -> None:
    of = loaded("planar_2r.toml")
    function = of.compiled["inverse_dynamics"]
    assert [*signature(function).parameters] == ["q", "qd", "qdd_motor", "p", "out"]
    assert function.__name__ == "inverse_dynamics" and function.__doc__ == of.numpy.inverse_dynamics.__doc__


# The package


@cache
def packaged() -> Package:
    return programs(machine("planar_2r.toml"), Scene(("inverse_dynamics", "regressor"), steps=("rk4",))).package


def built(folder: Path) -> Path:
    """The package, compiled as its pyproject.toml says, in a folder for imports."""
    fill(folder, render_python(packaged()))
    (module,) = tomllib.loads((folder / "pyproject.toml").read_text())["tool"]["setuptools"]["ext-modules"]
    macros = [f"-D{name}={value}" for name, value in module["define-macros"]]
    command = ["gcc", *module["extra-compile-args"], *macros, "-fPIC", "-shared", f"-I{sysconfig.get_path('include')}"]
    made = Path(*module["name"].split(".")).with_suffix(sysconfig.get_config_var("EXT_SUFFIX"))
    subprocess.run([*command, *module["sources"], "-lm", "-o", made], cwd=folder, check=True)
    assert all((folder / name).is_file() for name in module["depends"])
    return folder


def fill(folder: Path, files: dict[str, str]) -> None:
    for name in files:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
    fill_folder(folder, files)


SCRIPT = """
import sys
import numpy as np
import planar_2r as m
assert "symoro_elastic" not in sys.modules
tau, qdd = m.inverse_dynamics([0.1, 0.2], [0.3, 0.4], qdd_motor=(1, 2))
q, qd = m.step_rk4(np.zeros((3, 2)), 0.01, np.zeros((50, 2)), [0.0, 0.0], out=(np.empty((50, 2)), np.empty((50, 2))))
assert q.shape == (50, 2) and m.parameters(m1=2.0)[m.PARAMETERS.index("m1")] == 2.0
try:
    m.inverse_dynamics("ab", [0, 0], [0, 0])
except TypeError as error:
    print(error)
print(*tau, *m.JOINTS, m.inverse_dynamics.__module__, m.COLUMNS["regressor"][0])
"""


@pytest.mark.skipif(not shutil.which("gcc"), reason="gcc")
def test_a_fresh_process_imports_the_package(tmp_path: Path) -> None:
    command = [sys.executable, "-W", "error", "-c", SCRIPT]
    ran = subprocess.run(command, cwd=built(tmp_path), capture_output=True, text=True, check=False)
    numpy = import_package(render_numpy(packaged()), tmp_path / "numpy")
    tau, _ = numpy.inverse_dynamics([0.1, 0.2], [0.3, 0.4], [1.0, 2.0])
    words = " ".join(map(str, (*tau, *numpy.JOINTS, "planar_2r", numpy.COLUMNS["regressor"][0])))
    assert ran.stdout.splitlines() == ["arguments are real numbers, not text", words], ran.stderr


TYPED = """
import planar_2r
tau, qdd = planar_2r.inverse_dynamics([0.1, 0.2], [0.3, 0.4], qdd_motor=(1, 2))
q, qd = planar_2r.step_rk4([[0.0, 0.0]] * 3, 0.01, q=[0, 0], qd=[0, 0], out=(tau, qdd))
Y: int = planar_2r.regressor(tau, tau, tau)
names: tuple[str, ...] = planar_2r.JOINTS
"""


@pytest.mark.thorough
def test_stubs_give_types(tmp_path: Path) -> None:
    """All functions are there, and a wrong type is found."""
    pytest.importorskip("mypy")
    fill(tmp_path, render_python(packaged()))
    (tmp_path / "calls.py").write_text(TYPED)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file=", "calls.py"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    (said,) = [line for line in ran.stdout.splitlines() if "error:" in line]
    assert said.startswith('calls.py:5: error: Incompatible types in assignment (expression has type "ndarray')


@pytest.mark.thorough
def test_pip_installs_the_package(tmp_path: Path) -> None:
    # asked in a process of its own, as pip does: another test may have put a copy on this one's path
    version = "import setuptools; assert int(setuptools.__version__.split('.')[0]) >= 75"
    if subprocess.run([sys.executable, "-c", version], capture_output=True, check=False).returncode:
        pytest.skip("setuptools is not installed, or is old")
    fill(tmp_path / "source", render_python(packaged()))
    command = [sys.executable, "-m", "pip", "install", "-q", "--no-build-isolation", "--no-deps", "--no-index"]
    subprocess.run([*command, f"--target={tmp_path / 'there'}", str(tmp_path / "source")], check=True)
    assert {"_calls" in path.name or path.name for path in (tmp_path / "there" / "planar_2r").iterdir()} >= {
        True, "__init__.py", "__init__.pyi", "py.typed",
    }  # fmt: skip
    subprocess.run([sys.executable, "-c", SCRIPT], cwd=tmp_path / "there", check=True)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_compilers_do_not_complain(compiler: str, tmp_path: Path) -> None:
    """Of what a user compiles, but that C forbids tables of functions as CPython wants them."""
    fill(tmp_path, render_python(packaged()))
    strict = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-Wshadow", "-fsyntax-only")
    include = f"-isystem{sysconfig.get_path('include')}"
    for source, pedantic in (("planar_2r_table.c", "-Wpedantic"), ("python_calls.c", "-Wno-pedantic")):
        subprocess.run([compiler, *strict, pedantic, include, source], cwd=tmp_path, check=True)


def test_the_text_is_the_same_each_time() -> None:
    files = render_python(packaged())
    assert files == render_python(packaged())
    assert not [name for name, text in files.items() if str(Path.home()) in text or "/work" in text or "20" in name]
    assert {name: files[name] for name in render_calls()} == render_calls()


def test_names_of_modules_are_refused() -> None:
    from dataclasses import replace

    for name in ("numpy", "math"):
        with pytest.raises(
            InputError, match=rf"--target python, name: '{name}' is the name of a module that Python or"
        ):
            render_python(replace(packaged(), name=name))


@pytest.mark.thorough
def test_the_module_has_room_for_the_arrays_of_all_functions(loaded: Any) -> None:
    packages = [loaded(example).package for example in MODELS]
    packages += [loaded(example, with_steps=True).package for example in STEPS]
    for called in (called for package in packages for called in called_functions(package)):
        assert max(len(called.inputs), len(called.results)) <= ARRAYS - 8
        assert all(len(array.shape) <= AXES for array in (*called.inputs, *called.results))


# Through load


@pytest.mark.thorough
def test_time_steps_are_loaded_in_c() -> None:
    c, numpy = (
        se.load(machine("planar_2r.toml"), "direct_dynamics", steps=["rk4"], backend=name) for name in ("c", "numpy")
    )
    assert c.functions == numpy.functions
    state = [np.ones((3, 2)), 0.01, [0.1, 0.2], [0.3, 0.4]]
    for x, y in zip(c.step_rk4(*state), numpy.step_rk4(*state), strict=True):
        np.testing.assert_allclose(x, y, rtol=1e-12)


def test_without_headers_of_python_ctypes_calls_c(monkeypatch: pytest.MonkeyPatch) -> None:
    extension.calls_module.cache_clear()
    monkeypatch.setattr(sysconfig, "get_path", lambda _: "/nowhere")
    with pytest.warns(se.MachineWarning, match='^backend="c" calls C by ctypes, .*: the headers of Python are missing'):
        model = se.load(machine("planar_2r.toml"), "inverse_dynamics", steps=["rk4"], backend="c")
    monkeypatch.undo()
    extension.calls_module.cache_clear()
    other = se.load(machine("planar_2r.toml"), "inverse_dynamics", steps=["rk4"], backend="c")
    assert model.functions == other.functions
    values = np.random.default_rng(0).uniform(-1, 1, (3, 40, 2))
    assert same(model.inverse_dynamics(*values), other.inverse_dynamics(*values))
    held = model.inverse_dynamics
    model.close()
    with pytest.raises(ValueError, match="the model of planar_2r is closed: load it again"):
        held(*values)


def test_a_loaded_function_is_an_attribute() -> None:
    """It is found without a call of `__getattr__`, which would take longer than the function."""
    model = se.load(machine("planar_2r.toml"), "inverse_dynamics", backend="c")
    assert "inverse_dynamics" in vars(model)


@pytest.mark.thorough
def test_long_chains_are_computed_in_small_blocks(tmp_path: Path) -> None:
    """Results that are larger than a block: states one by one, and vectors, give the same bits."""
    package = programs(chain(7), Scene(("regressor",))).package
    of = Loaded(package, tmp_path)
    p = np.random.default_rng(0).uniform(0.5, 1, len(package.parameters))
    for name, function in of.compiled.items():
        values = drawn(of, name, (100,))
        assert same(function(*values, p), of.c(name, *values, p))


@pytest.mark.thorough
def test_machines_of_one_name_are_apart() -> None:
    """The module that calls them is one; each has the numbers of its own library."""
    first, second = (
        se.load(machine("planar_2r.toml"), "inertia_matrix", backend="c", fold=fold) for fold in ((), "all")
    )
    assert [len(model.PARAMETERS) for model in (first, second)] == [9, 0]
    with pytest.raises(ValueError, match=r"p has shape \(9,\): \(\.\.\., 0\) is expected"):
        second.inertia_matrix([0.1, 0.2], first.DEFAULTS)
    np.testing.assert_allclose(first.inertia_matrix([0.1, 0.2]), second.inertia_matrix([0.1, 0.2]), rtol=1e-14)
