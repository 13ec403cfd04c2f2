"""Names given to functions: one, several, or a list of them; what is none is refused in one line."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import symoro_elastic as se
from tests.command_line import EXAMPLES

TWO_R, TWO_AXIS = EXAMPLES / "planar_2r.toml", EXAMPLES / "two_axis.toml"


def test_models_are_given_one_by_one_or_as_a_list() -> None:
    one, other = (
        se.load(TWO_R, "inverse_dynamics", "inertia_matrix"),
        se.load(TWO_R, ["inverse_dynamics", "inertia_matrix"]),
    )
    assert repr(one) == repr(other)


@pytest.mark.parametrize(
    ("call", "what"),
    [
        (lambda: se.load(TWO_R, 3), "models: 3 is not a name"),
        (
            lambda: se.load(TWO_R, "inertia_matrix", ["inverse_dynamics"]),
            r"models: \['inverse_dynamics'\] is not a name",
        ),
        (lambda: se.check(TWO_R, ["inertia_matrix", None]), "models: None is not a name"),
        (lambda: se.equations(TWO_R, [b"inertia_matrix"]), "is not a name"),
        (lambda: se.modes(TWO_AXIS, hold=[1]), "hold: 1 is not a name"),
        (lambda: se.response(TWO_AXIS, inputs=("tool.fx", 2), outputs=["tool.x"]), "inputs: 2 is not a name"),
    ],
)
def test_what_is_no_name_is_refused(call: Callable[[], object], what: str) -> None:
    with pytest.raises(se.InputError, match=what):
        call()
