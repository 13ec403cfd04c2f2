"""The commands in sections, each with its module and its line of help, without importing any of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from inspect import cleandoc
from typing import Any, NamedTuple

import click


class Listed(NamedTuple):
    """A command: its module in this package, and the first line of its help."""

    module: str
    line: str

    def short(self, limit: int) -> str:
        """Return the line, cut where it is longer than a limit."""
        return click.Command(None, help=self.line).get_short_help_str(limit)


SECTIONS: Mapping[str, Mapping[str, Listed]] = {
    "Files": {
        "new": Listed("formats", "Write NAME.toml, a commented machine to start from."),
        "flexible": Listed("flexible", "Reduce a finite-element body to modes, or show one."),
        "formats": Listed("formats", "Print the reference of all file formats."),
        "schema": Listed("formats", "Print the JSON Schema of machine or scene files."),
    },
    "Models and code": {
        "show": Listed("machine", "Print the parameters of MACHINE and its base parameters."),
        "view": Listed("pages", "Write a page that shows MACHINE and moves it."),
        "live": Listed("pages", "Show MACHINE on a page that follows its file."),
        "convert": Listed("machine", "Convert MACHINE to the format of FILE."),
        "models": Listed("machine", "List the models: arguments, results, shapes, units."),
        "evaluate": Listed("poses", "Evaluate models of MACHINE at a position."),
        "ik": Listed("poses", "Find the joint positions at which a frame has a pose."),
        "equations": Listed("code", "Write the equations of models as LaTeX, HTML or PDF."),
        "singularities": Listed("poses", "Find where a frame loses a direction of motion."),
        "generate": Listed("code", "Generate code for the models of MACHINE."),
        "report": Listed("pages", "Write one page about MACHINE, to read and to print."),
    },
    "Verification": {
        "check": Listed("code", "Compare the generated code with 50-digit references."),
        "benchmark": Listed("benchmark", "Measure speed and accuracy, recommend the fastest build."),
    },
    "Vibration": {
        "linearize": Listed("vibration", "Linearize MACHINE about an equilibrium or a state."),
        "modes": Listed("vibration", "Compute natural frequencies, mode shapes, sensitivities."),
        "response": Listed("vibration", "Compute frequency responses, poles and zeros."),
        "stiffness": Listed("poses", "Compute the stiffness of a frame and what limits it."),
        "compare": Listed("vibration", "Compare the full model with reduced and rigid models."),
    },
    "Simulation": {
        "simulate": Listed("simulation", "Simulate the motions of a scene with a measured error."),
        "reduce": Listed("simulation", "Find the cheapest models within a tolerance at the tool."),
        "ladder": Listed("simulation", "Choose springs, method and step that a motion requires."),
    },
    "Variants": {"sweep": Listed("sweep", "Sweep parameters and positions over grids or samples.")},
    "Control": {
        "control": Listed("control", "Compute margins and largest gains of drives."),
        "tune": Listed("control", "Find the gains of drives, and what limits them."),
        "lobes": Listed("control", "Compute the stable depth of cut by spindle speed."),
        "feed-forward": Listed("vibration", "Compute torques that make the load follow a trajectory."),
    },
    "Identification": {
        "excite": Listed("identification", "Design an exciting trajectory for identification."),
        "identify": Listed("identification", "Estimate dynamic parameters from measurements."),
        "update": Listed("identification", "Estimate springs and dampers from vibration tests."),
    },
}
FORMER: Mapping[str, tuple[str, ...]] = {"trade": ("benchmark",), "certify": ("check", "--proven")}
"""Commands by the names that they had in the last version."""
LISTED: Mapping[str, Listed] = {name: one for section in SECTIONS.values() for name, one in section.items()}


class ListedCommands(Mapping[str, click.Command]):
    """The commands by name; the module of a command is imported on first use."""

    def __getitem__(self, name: str) -> click.Command:
        module = import_module(f"symoro_elastic.cli.{LISTED[name].module}")
        command: click.Command = getattr(module, name.replace("-", "_"))
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(LISTED)

    def __len__(self) -> int:
        return len(LISTED)


def command(name: str, more: str = "") -> Callable[[Callable[..., Any]], click.Command]:
    """Return a decorator that makes a command of a function.

    Its help is the line that lists it, then `more` or, without it, the docstring of the function.
    """

    def decorate(function: Callable[..., Any]) -> click.Command:
        from symoro_elastic.cli.help import HeadedCommand

        text = more or cleandoc(function.__doc__ or "")
        return click.command(name, cls=HeadedCommand, help=f"{LISTED[name].line}\n\n{text}")(function)

    return decorate
