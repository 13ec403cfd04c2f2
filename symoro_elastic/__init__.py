"""Symbolic models of robots and machine tools with elastic joints, as numpy and C code.

A machine is a tree of bodies on revolute, prismatic and fixed joints that are driven by motors, elastic or passive,
with couplings and closed loops, described by the geometric parameters of Khalil and Kleinfinger. The recursions of
Khalil and Gautier, *Modeling of high speed machines using robotics formulation*, run on the symbols of its table; what
remains is pruned, scheduled and written as functions without dependencies, or as equations.

>>> import symoro_elastic as se
>>> machine = se.read("examples/two_axis.toml")
>>> machine
<Machine two_axis: 12 coordinates, 2 motors, 10 springs, 13 rows>
>>> model = se.load(machine, "inverse_dynamics")
>>> tau, qdd = model.inverse_dynamics([0.0] * 12, [0.0] * 12, [1.0, 0.0])
>>> print(tau)
[30.  0.]

Machines and scenes are given as files, as tables (dictionaries and lists as in the files), or as objects already read.
Results have a short `repr`, tables in notebooks, `arrays()`, `frame()` and `as_json()`. Errors that you can fix are
`InputError`, in one line.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from symoro_elastic.api.drawings import picture, view
    from symoro_elastic.api.loaded import load
    from symoro_elastic.api.machines import MachineWarning, new, read, write
    from symoro_elastic.api.measured import excite, identify
    from symoro_elastic.api.models import check, equations, generate, trade
    from symoro_elastic.api.motions import ladder, simulate
    from symoro_elastic.api.pages import report
    from symoro_elastic.api.sweeps import sweep
    from symoro_elastic.api.vibrations import compare, feed_forward, linearize, modes, response
    from symoro_elastic.errors import InputError

__version__ = "0.1.0"

__all__ = [
    "InputError",
    "MachineWarning",
    "check",
    "compare",
    "equations",
    "excite",
    "feed_forward",
    "generate",
    "identify",
    "ladder",
    "linearize",
    "load",
    "modes",
    "new",
    "picture",
    "read",
    "report",
    "response",
    "simulate",
    "sweep",
    "trade",
    "view",
    "write",
]

_ROOMS = {
    "drawings": ("picture", "view"),
    "loaded": ("load",),
    "machines": ("MachineWarning", "new", "read", "write"),
    "measured": ("excite", "identify"),
    "models": ("check", "equations", "generate", "trade"),
    "motions": ("ladder", "simulate"),
    "pages": ("report",),
    "sweeps": ("sweep",),
    "vibrations": ("compare", "feed_forward", "linearize", "modes", "response"),
}
_MODULES = {name: module for module, names in _ROOMS.items() for name in names}


def __getattr__(name: str) -> Any:
    """Return a public function, imported when it is first asked for."""
    if name == "InputError":
        found: Any = import_module("symoro_elastic.errors").InputError
    elif name in _MODULES:
        found = getattr(import_module(f"symoro_elastic.api.{_MODULES[name]}"), name)
        if not isinstance(found, type):
            found = import_module("symoro_elastic.api.arguments").with_arguments(found)
    else:
        raise AttributeError(f"module 'symoro_elastic' has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    """Return the public names."""
    return [*__all__, "__version__"]
