"""Generated numpy: one text for floats and for stacks; blocks, broadcasting, precisions, aliasing, NaN."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.scene import Scene
from tests.compiled_models import FIVE, Array, Built, built
from tests.generated_code import ALL_MODELS, imported, rendered
from tests.golden import GENERATED, ROOT
from tests.references.random_machines import chain, random_machine

pytestmark = pytest.mark.sampled(5)

STATES = ("q", "qd", "tau", "qdd_motor", "qdd")
# The functions of numpy, for a program carried out plainly on whole arrays.
ON_ARRAYS = SimpleNamespace(sin=np.sin, cos=np.cos, sqrt=np.sqrt, sign=np.sign, atan2=np.arctan2)


@cache
def two_r() -> ModuleType:
    return imported(GENERATED / "planar_2r")


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """Friction, wrenches, a moving base, every number a parameter."""
    return built(random_machine(2, joints=5, symbolic=True, moving_base=True), tmp_path_factory.mktemp("tree"))


def support(module: ModuleType, name: str) -> Any:
    return sys.modules.get(f"{module.__name__}.{name}") or getattr(module, name)


def tuple_of(results: Any) -> tuple[Array, ...]:
    return results if isinstance(results, tuple) else (results,)


def drawn(sizes: Sequence[int], lead: tuple[int, ...], seed: int = 0) -> list[Array]:
    rng = np.random.default_rng(seed)
    return [rng.uniform(-2.0, 2.0, (*lead, size)) for size in sizes]


def model_of(module: ModuleType, name: str) -> Any:
    return support(module, f"_{name}").model


def sizes_of(model: Any) -> list[int]:
    return [*model.sizes.values()][:-1]


def plainly(model: Any, states: Sequence[Array], p: Array) -> list[Array]:
    """The program on whole arrays, an array for each variable; rows of states, any p; constants of one p on floats."""
    columns = [np.ascontiguousarray(x.T) for x in states]
    floats = support(two_r(), "_runtime").Floats
    once = (floats, p.tolist()) if p.ndim == 1 else (ON_ARRAYS, np.ascontiguousarray(p.T))
    with np.errstate(all="ignore"):
        entries = model.program(ON_ARRAYS, *columns, model.constants(*once))
    count = len(states[0]) if states else 1
    return [
        np.stack([np.broadcast_to(x, count) for x in values], axis=-1).reshape(count, *shape)
        for values, shape in zip(entries, model.shapes, strict=True)
    ]


def same_bits(found: Array, wanted: Array) -> bool:
    return found.dtype == wanted.dtype and found.shape == wanted.shape and bool(np.array_equal(found, wanted, True))


def near(found: Array, wanted: Array, bound: float) -> bool:
    """Each state within a bound of its largest entry."""
    count = len(found)
    error, scale = (np.abs(x).reshape(count, -1).max(axis=1, initial=0) for x in (found - wanted, wanted))
    return bool((error <= bound * np.maximum(scale, 1.0)).all())


# One text, two ways to carry it out


@pytest.mark.parametrize("name", FIVE)
def test_many_few_and_single_states_agree_with_c(tree: Built, name: str) -> None:
    """Buffers give the bits of plain arrays; floats and C differ from them by numpy's sines alone."""
    model = model_of(tree.module, name)
    states = drawn(sizes_of(model), (101,))
    names = [key for key in STATES if key in model.sizes]
    many = tuple_of(getattr(tree.module, name)(*states))
    few = tuple_of(getattr(tree.module, name)(*(x[:5] for x in states)))
    singles = [tuple_of(getattr(tree.module, name)(*(x[k] for x in states))) for k in range(101)]
    in_c = tree.c(name, **dict(zip(names, states, strict=True)))
    for k, (found, plain) in enumerate(zip(many, plainly(model, states, tree.module.DEFAULTS), strict=True)):
        alone = np.stack([single[k] for single in singles])
        assert same_bits(found, plain)
        assert same_bits(few[k], alone[:5])
        assert near(alone, in_c[k], 1e-13) and near(found, alone, 1e-13)


@pytest.mark.thorough
@pytest.mark.sampled(2)
@pytest.mark.parametrize("example", ["two_axis.toml", "puma560.par"])
def test_every_model_on_buffers_is_the_plain_program(example: str, tmp_path: Path) -> None:
    """Also those without states, with roots and arcs, with results that are arguments or constants."""
    machine, _ = read_machine(ROOT / "examples" / example)
    models = (*ALL_MODELS, *(["inverse_geometric_model"] if example == "puma560.par" else []))
    for file, text in rendered(machine, Scene(models), ("numpy",)).items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    module = imported(tmp_path)
    (p,) = drawn([len(module.PARAMETERS)], ())
    for name in models:
        model = model_of(module, name)
        states = drawn(sizes_of(model), (40,))
        if "T" in model.sizes:
            states = [module.geometric_model(*drawn(sizes_of(module._geometric_model.model), (40,)), p)[:, -1]]
            states = [pose.reshape(40, -1) for pose in states]
        found = tuple_of(getattr(module, name)(*states, p))
        for one, wanted in zip(found, plainly(model, states, p), strict=True):
            assert same_bits(one if states else one[None], wanted), name


def test_steps_share_buffers() -> None:
    """Far fewer buffers than steps; no step writes to a register that a later one still reads."""
    for folder in ("rx90", "two_axis"):
        steps = model_of(imported(GENERATED / folder), "direct_dynamics").steps
        assert 4 * steps.buffers < len(steps.steps)


def test_a_block_is_no_longer_than_the_cache_allows() -> None:
    buffers = support(two_r(), "_runtime")
    steps = model_of(two_r(), "direct_dynamics").steps
    double, single = np.dtype(np.float64), np.dtype(np.float32)
    assert steps.block_length(10**6, double) <= 2048 and 2048 < steps.block_length(10**6, single) <= 4096
    assert [steps.block_length(count, double) for count in (1, 2048, 2049)] == [1, 2048, 1025]
    large = SimpleNamespace(buffers=10**5)
    assert buffers.Steps.block_length(large, 10**6, double) <= 256


def test_calls_of_one_shape_use_the_same_buffers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a few shapes, and only where the buffers are not large."""
    module, (p,) = two_r(), drawn([len(two_r().PARAMETERS)], ())
    steps, buffers = model_of(module, "direct_dynamics").steps, support(module, "_runtime")
    steps.kept.clear()
    for count in (30, 30, 40, 30):
        module.direct_dynamics(*drawn([2, 2, 2], (count,)), p)
    assert [len(idle) for idle in steps.kept.values()] == [1, 1]
    for count in range(30, 50):
        module.direct_dynamics(*drawn([2, 2, 2], (count,)), p)
    assert 0 < len(steps.kept) <= buffers.KINDS
    steps.kept.clear()
    monkeypatch.setattr(buffers, "KEPT", 0)
    module.direct_dynamics(*drawn([2, 2, 2], (30,)), p)
    assert not any(steps.kept.values())


def test_parameter_sets_do_not_stay_in_the_buffers() -> None:
    module, states = two_r(), drawn([2, 2, 2], (30,))
    for seed in range(3):
        p = drawn([len(module.PARAMETERS)], (), seed)[0] + 3.0
        (wanted,) = plainly(model_of(module, "direct_dynamics"), states, p)
        assert same_bits(module.direct_dynamics(*states, p), wanted)


# Blocks and axes


@pytest.fixture
def blocks_of_eight(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The 2R arm, all stacks on buffers, eight states at a time."""
    runtime = support(two_r(), "_runtime")
    monkeypatch.setattr(runtime, "FEW", 0)
    monkeypatch.setattr(runtime, "SHORTEST", 64)
    monkeypatch.setattr(runtime, "LONGEST", 64)
    return two_r()


def test_no_state_is_lost_at_the_end_of_a_block(blocks_of_eight: ModuleType) -> None:
    module, states = blocks_of_eight, drawn([2, 2, 2], (30,))
    whole = plainly(model_of(module, "inverse_dynamics"), states, module.DEFAULTS)
    for count in range(30):
        for found, wanted in zip(module.inverse_dynamics(*(x[:count] for x in states)), whole, strict=True):
            assert same_bits(found, wanted[:count])


@pytest.mark.parametrize(
    ("leads", "lead"),
    [
        (((5, 1), (4,), (), (3, 1, 1)), (3, 5, 4)),
        (((1, 4), (5, 1), (5, 4), ()), (5, 4)),
        (((), (), (), (25,)), (25,)),
        (((1,), (1, 1), (), (1,)), (1, 1)),
        (((6, 0), (0,), (6, 1), ()), (6, 0)),
    ],
)
def test_leading_axes_broadcast(blocks_of_eight: ModuleType, leads: Sequence[Any], lead: tuple[int, ...]) -> None:
    """States and parameter sets, stacked in any way: each result is that of its own state and set."""
    module = blocks_of_eight
    sizes = [2, 2, 2, len(module.PARAMETERS)]
    arrays = [drawn([size], one, k)[0] + 3.0 for k, (size, one) in enumerate(zip(sizes, leads, strict=True))]
    spread = [np.broadcast_to(x, (*lead, x.shape[-1])).reshape(-1, size) for x, size in zip(arrays, sizes, strict=True)]
    found = module.direct_dynamics(*arrays)
    (wanted,) = plainly(model_of(module, "direct_dynamics"), spread[:3], spread[3])
    assert same_bits(found, wanted.reshape((*lead, 2)))


def test_few_states_take_their_own_parameters() -> None:
    module = two_r()
    states, (p,) = drawn([2, 2, 2], (4,)), drawn([len(module.PARAMETERS)], (4,), 1)
    (wanted,) = plainly(model_of(module, "direct_dynamics"), states, p + 3.0)
    assert near(module.direct_dynamics(*states, p + 3.0), wanted, 1e-13)


def test_shapes_are_checked_before_anything_is_computed() -> None:
    direct, zeros = two_r().direct_dynamics, np.zeros
    with pytest.raises(ValueError, match=r"^qd has shape \(50, 3\): \(\.\.\., 2\) is expected$"):
        direct(zeros((50, 2)), zeros((50, 3)), zeros(2))
    with pytest.raises(ValueError, match=r"^p has shape \(1,\): \(\.\.\., \d+\) is expected$"):
        direct(zeros(2), zeros(2), zeros(2), [1.0])
    with pytest.raises(ValueError, match="broadcast"):
        direct(zeros((50, 2)), zeros((51, 2)), zeros(2))


# What goes in and comes out


Arrange = Callable[[Array], Array]
ARRANGED: dict[str, Arrange] = {
    "every other": lambda x: np.repeat(x, 2, axis=0)[::2],
    "backwards": lambda x: x[::-1].copy()[::-1],
    "by column": np.asfortranarray,
    "big-endian": lambda x: x.astype(">f8"),
    "a list": lambda x: x.tolist(),
}


@pytest.mark.parametrize("arranged", ARRANGED.values(), ids=ARRANGED)
@pytest.mark.parametrize("count", [3, 100])
def test_arrays_may_lie_in_memory_as_they_like(arranged: Arrange, count: int) -> None:
    states = drawn([2, 2, 2], (count,))
    assert same_bits(two_r().direct_dynamics(*map(arranged, states)), two_r().direct_dynamics(*states))


@pytest.mark.parametrize("lead", [(), (5,), (100,)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_arguments_are_read_only_and_results_new(lead: tuple[int, ...], dtype: type) -> None:
    """An array may serve as several arguments; results share memory with nothing, and later calls leave them alone."""
    x = np.asarray(drawn([2], lead)[0], dtype)
    x.flags.writeable = False
    kept = x.copy()
    first = two_r().inverse_dynamics(x, x, x)
    before = [result.copy() for result in first]
    second = two_r().inverse_dynamics(x.copy(), x.copy(), x.copy())
    two_r().inverse_dynamics(-x, x, x)
    assert same_bits(x, kept)
    for k, result in enumerate(first):
        assert same_bits(result, before[k]) and same_bits(result, second[k])
        assert result.flags.writeable and result.flags.c_contiguous and result.dtype == dtype
        assert not any(np.shares_memory(result, other) for other in (x, *second, first[1 - k]))


def test_integers_and_mixed_precisions_are_doubles() -> None:
    direct, q = two_r().direct_dynamics, np.ones((30, 2))
    assert direct(q.astype(np.float32), q, q.astype(np.float32)).dtype == np.float64
    assert same_bits(direct(q.astype(int), q.astype(int), [1, 1]), direct(q, q, [1.0, 1.0]))


def test_single_precision_stays_single() -> None:
    """Results in float32, as near to the doubles as roundings of that size explain."""
    rx90 = imported(GENERATED / "rx90")
    states = [x.astype(np.float32) for x in drawn([6, 6, 6], (300,))]
    (p,) = drawn([len(rx90.PARAMETERS)], ())
    p = p.astype(np.float32)
    doubles = rx90.inverse_dynamics(*(x.astype(float) for x in states), p)
    for found, wanted in zip(rx90.inverse_dynamics(*states, p), doubles, strict=True):
        assert found.dtype == np.float32 and near(found, wanted, 100 * 2.0**-24)
    few = rx90.inverse_dynamics(*(x[:3] for x in states), p)
    assert all(same_bits(x, y[:3].astype(np.float32)) for x, y in zip(few, doubles, strict=True))


# What is not a number


@pytest.mark.parametrize("count", [3, 100])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_state_that_is_no_number_leaves_the_others_alone(count: int, bad: float) -> None:
    states = drawn([2, 2, 2], (count,))
    good = two_r().direct_dynamics(*states)
    states[0][1, 1] = bad
    with np.errstate(all="raise"):
        found = two_r().direct_dynamics(*states)
    assert np.isnan(found[1]).all()
    others = np.arange(count) != 1
    assert near(found[others], good[others], 1e-13)
    assert count < 25 or same_bits(found[others], good[others])


@pytest.mark.parametrize("lead", [(), (3,), (100,)])
def test_a_division_by_zero_is_no_trap(lead: tuple[int, ...]) -> None:
    """Without any mass, floats raise: the same result comes from buffers, without a warning."""
    with np.errstate(all="raise"):
        found = two_r().direct_dynamics(*drawn([2, 2, 2], lead), np.zeros(len(two_r().PARAMETERS)))
    assert found.shape == (*lead, 2) and not np.isfinite(found).any()


def test_calls_at_the_same_time_do_not_meet() -> None:
    rx90 = imported(GENERATED / "rx90")
    (p,) = drawn([len(rx90.PARAMETERS)], ())
    stacks = [drawn([6, 6, 6], (3000,), seed) for seed in range(4)]
    wanted = [rx90.inverse_dynamics(*states, p)[0] for states in stacks]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda k: rx90.inverse_dynamics(*stacks[k % 4], p)[0], range(16)))
    assert all(same_bits(one, wanted[k % 4]) for k, one in enumerate(found))


def test_only_placements_may_be_matrices(tmp_path: Path) -> None:
    """16 joint variables as 4 x 4 are a mistake."""
    for file, text in rendered(chain(16), Scene(("bias_forces",)), ["numpy"]).items():
        (tmp_path / file).write_text(text)
    module = imported(tmp_path)
    with pytest.raises(ValueError, match=r"q has shape \(4, 4\): \(\.\.\., 16\) is expected"):
        module.bias_forces(np.zeros((4, 4)), np.zeros(16), np.ones(len(module.PARAMETERS)))


@pytest.mark.parametrize("count", [1, 3, 100])
@pytest.mark.parametrize("which", range(4))
def test_complex_arguments_are_refused(which: int, count: int) -> None:
    """A derivative by complex steps would be zero without a word."""
    given: list[Any] = [*drawn((2, 2, 2), (count,) if count > 1 else ()), two_r().DEFAULTS]
    two_r().inverse_dynamics(*given[:3], p=given[3])
    given[which] = given[which] + 1e-20j
    with pytest.raises(TypeError, match="real numbers"):
        two_r().inverse_dynamics(*given[:3], p=given[3])


def test_masks_are_not_looked_at() -> None:
    q, qd, qdd = drawn((2, 2, 2), (30,))
    masked = np.ma.masked_array(q, mask=q > 0)
    tau, _ = two_r().inverse_dynamics(masked, qd, qdd)
    assert type(tau) is np.ndarray and np.array_equal(tau, two_r().inverse_dynamics(q, qd, qdd)[0])
    assert "masks" in str(two_r().__doc__)
