"""Functional Mock-up Units: machines as components of other simulators, by FMI 2.0 and 3.0."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

VERSIONS = (2, 3)


@dataclass(frozen=True)
class Options:
    """Version of FMI, 2 or 3; positions of motors at the start, rad or m by joint; whether drives are omitted."""

    version: int = VERSIONS[0]
    at: Mapping[str, float] = field(default_factory=dict)
    by_torque: bool = False
