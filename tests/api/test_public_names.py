"""What `import symoro_elastic` offers."""

from __future__ import annotations

import inspect
import subprocess
import sys

import pytest

import symoro_elastic
from symoro_elastic.api.checked_calls import argument, with_arguments
from symoro_elastic.cli import cli
from symoro_elastic.foundation.errors import InputError

FUNCTIONS = [name for name in symoro_elastic.__all__ if inspect.isfunction(getattr(symoro_elastic, name))]


def test_importing_loads_nothing() -> None:
    """Modules are counted, not seconds."""
    code = "import sys; before = set(sys.modules); import symoro_elastic; print(*sorted(set(sys.modules) - before))"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    version = {"symoro_elastic", "symoro_elastic.foundation", "symoro_elastic.foundation.version"}
    assert {m for m in ran.stdout.split() if m.split(".")[0] not in sys.stdlib_module_names} == version


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_are_described(name: str) -> None:
    function = getattr(symoro_elastic, name)
    first = inspect.getdoc(function).partition("\n")[0]  # type: ignore[union-attr]
    assert first.endswith(".")
    assert first.split()[0] in {"Return", "Write", "Compare", "Measure"}
    assert all(p.annotation is not inspect.Parameter.empty for p in inspect.signature(function).parameters.values())
    if name in ("read", "load", "linearize", "simulate", "feed_forward", "excite", "identify", "generate"):
        described = inspect.getdoc(function)
        assert "Parameters\n----------" in described  # type: ignore[operator]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_results_have_public_names_for_annotations(name: str) -> None:
    returned = str(inspect.signature(getattr(symoro_elastic, name)).return_annotation).split(" | ")
    assert {*returned} <= {*symoro_elastic.__all__, "Path"}


def test_commands_have_functions_of_their_names() -> None:
    """All but those that only print, convert or draw; `tune` is `control(tune=True)`."""
    commands = {name.replace("-", "_") for name in cli.commands}
    printed = {"show", "models", "formats", "schema", "convert", "view", "live", "report", "tune"}
    assert commands - printed <= set(symoro_elastic.__all__)


def test_names_are_not_those_of_rooms() -> None:
    """A room of the same name would take the place of the function when it is imported."""
    import pkgutil

    assert not {module.name for module in pkgutil.iter_modules(symoro_elastic.__path__)} & set(FUNCTIONS)


def test_unknown_names_are_no_attributes() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nope'"):
        _ = symoro_elastic.nope
    assert set(symoro_elastic.__all__) <= set(dir(symoro_elastic))


def test_messages_name_arguments_in_the_place_of_options() -> None:
    def wrong(rates: object, as_given: bool) -> None:
        raise InputError("symoro-elastic", "--rate", "an equilibrium is at rest: add --as-given, not --nothing")

    with pytest.raises(InputError) as refused:
        with_arguments(wrong)(None, True)
    assert str(refused.value) == "symoro_elastic: rates: an equilibrium is at rest: add as_given, not --nothing"
    assert argument("--hold", {"hold"}) == "hold"


def test_messages_about_files_stay() -> None:
    def wrong() -> None:
        raise InputError("mine.toml", "joint 2, --at", "what")

    with pytest.raises(InputError, match=r"^mine\.toml: joint 2, --at: what$"):
        with_arguments(wrong)()
