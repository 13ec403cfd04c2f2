"""Formats of robots as links and joints, each read through its description; imported when a file is read."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING

from symoro_elastic.formats.files import UTF_8, WESTERN
from symoro_elastic.formats.format import Format
from symoro_elastic.machine import format_names
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.format_names import FormatName
from symoro_elastic.machine.machine import Machine

if TYPE_CHECKING:
    from symoro_elastic.formats.robots.robot import Description


def _describe(module: str, text: str, source: str) -> Description:
    """The robot in a text, read by the function `describe` of a module of this folder."""
    describe: Callable[[str, str], Description] = import_module(f"{__package__}.{module}").describe
    return describe(text, source)


def _read(module: str, text: str, source: str) -> DescribedMachine:
    """The machine with the exact table of the robot in a text."""
    from symoro_elastic.formats.robots.modified_dh import machine_of

    return machine_of(_describe(module, text, source), source)


def _write(module: str, machine: Machine) -> str:
    """The text of a machine, written by the function `write` of a module of this folder."""
    write: Callable[[Machine], str] = import_module(f"{__package__}.{module}").write
    return write(machine)


def _format(named: FormatName, module: str, write: Callable[[Machine], str] | None = None) -> Format:
    describe, read = partial(_describe, module), partial(_read, module)
    return Format(named, read, write, (UTF_8, WESTERN), describe)


URDF = _format(format_names.URDF, "urdf", partial(_write, "urdf_writing"))
MJCF = _format(format_names.MJCF, "mjcf", partial(_write, "mjcf_writing"))
DISTAL = _format(format_names.DISTAL, "standard_dh")
