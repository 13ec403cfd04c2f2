"""Arguments that a function has not: the message names the function, the argument, and what may be meant."""

from __future__ import annotations

import inspect
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
    with pytest.raises(TypeError, match=rf"^{name}\(\) takes {placed} by place, but got 20 arguments"):
        function(*range(20))


def test_what_may_be_meant() -> None:
    with pytest.raises(TypeError, match=r"^trade\(\) got .*'quick': write effort='quick'$"):
        se.trade(MACHINE, quick=True)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"^response\(\) got .*'frequency'; did you mean 'frequencies'\?$"):
        se.response(MACHINE, frequency=1.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"^identify\(\) is called without records$"):
        se.identify(MACHINE)  # type: ignore[call-arg]
    with pytest.raises(se.InputError, match="point: dict is no operating point: give other arguments by name"):
        se.sweep(MACHINE, {"m2": [1, 2]})  # type: ignore[arg-type]
