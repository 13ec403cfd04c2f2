"""Arguments that a function has not: the message names the function, the argument, and what may be meant."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path

import pytest

import symoro_elastic as se

FUNCTIONS = [name for name in se.__all__ if not isinstance(getattr(se, name), type)]
MACHINE = Path(__file__).parents[2] / "examples" / "planar_2r.toml"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_unknown_argument_is_named(name: str) -> None:
    function = getattr(se, name)
    with pytest.raises(TypeError, match=rf"^{name}\(\) got an unexpected keyword argument 'nonsense'"):
        function(MACHINE, nonsense=1)
    known = list(inspect.signature(function).parameters)[-1]
    with pytest.raises(TypeError, match=rf"^{name}\(\) got .*'{known}_'; did you mean '{known}'\?$"):
        function(MACHINE, **{f"{known}_": 1})
    with pytest.raises(TypeError, match=rf"^{name}\(\) is called without "):
        function()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_too_many_arguments_are_given_by_name(name: str) -> None:
    function = getattr(se, name)
    rows = inspect.signature(function).parameters.values()
    if any(row.kind is row.VAR_POSITIONAL for row in rows):
        return  # models, as many as there are
    placed = ", ".join(row.name for row in rows if row.kind is row.POSITIONAL_OR_KEYWORD)
    with pytest.raises(TypeError, match=rf"^{name}\(\) accepts {placed} by place, but got 20 arguments"):
        function(*range(20))


def test_what_may_be_meant() -> None:
    with pytest.raises(TypeError, match=r"^benchmark\(\) got .*'quick': write effort='quick'$"):
        se.benchmark(MACHINE, quick=True)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"^response\(\) got .*'frequency'; did you mean 'frequencies'\?$"):
        se.response(MACHINE, frequency=1.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"^certify\(\) accepts models by place or by name, not both$"):
        se.certify(MACHINE, "inverse_dynamics", models=["bias_forces"])  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"'base': give it to read, as in generate\(read\(machine, base=\.\.\.\)\)$"):
        se.generate(MACHINE, base=True)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"^identify\(\) is called without records$"):
        se.identify(MACHINE)  # type: ignore[call-arg]
    with pytest.raises(se.InputError, match="point: dict is not an operating point: numbers by name are over="):
        se.sweep(MACHINE, {"m2": [1, 2]})  # type: ignore[arg-type]


@pytest.mark.parametrize("models", ["inertia_matrix", ["inertia_matrix", "bias_forces"]])
def test_models_may_be_given_by_name(models: str | list[str]) -> None:
    named = se.load(MACHINE, models=models)  # type: ignore[call-arg]
    placed = se.load(MACHINE, *([models] if isinstance(models, str) else models))
    for name in [models] if isinstance(models, str) else models:
        assert callable(getattr(named, name)) and getattr(named, name).__doc__ == getattr(placed, name).__doc__


OTHER = {"str": ["x"], "int": "x", "float": "x", "bool": [1, 2]}
"""A value of another type for each that annotations name."""
NEEDED = {
    "identify": {"records": "log.csv"},
    "ik": {"position": (0.1, 0.2, 0.3)},
    "lobes": {"direction": "tool.x", "cutting": 1e9},
    "update": {"tests": "tests.toml"},
    "write": {"path": "machine.toml"},
    "excite": {"position": 1.0, "velocity": 1.0, "acceleration": 1.0},
}


def plain_arguments() -> Iterator[tuple[str, str, str]]:
    for name in FUNCTIONS:
        _, *rows = inspect.signature(getattr(se, name)).parameters.values()
        for row in rows:
            kinds = str(row.annotation).split(" | ")
            if row.kind is not row.VAR_POSITIONAL and {*kinds} <= {*OTHER, "Path", "None"} and kinds[0] in OTHER:
                yield name, row.name, kinds[0]


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("name", "argument", "kind"), list(plain_arguments()))
def test_values_of_other_types_are_named(name: str, argument: str, kind: str) -> None:
    """A list where one name is meant, a text where a number is: one line, as for every wrong value."""
    given = {**NEEDED.get(name, {}), argument: OTHER[kind]}
    with pytest.raises(se.InputError, match=rf"{argument}: .* is not "):
        getattr(se, name)(MACHINE, **given)
