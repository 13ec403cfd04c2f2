"""Headers of Pinocchio and of Eigen, where their wheels or the system keep them."""

from __future__ import annotations

import importlib.util
from pathlib import Path

SYSTEM = Path("/usr/include/eigen3")


def shipped() -> Path:
    """Those in the wheels of Pinocchio."""
    found = importlib.util.find_spec("cmeel")
    assert found and found.submodule_search_locations
    return Path(next(iter(found.submodule_search_locations))).parent / "cmeel.prefix" / "include"


def eigen() -> Path | None:
    """Those of Eigen; None where there are none."""
    return next((place for place in (shipped() / "eigen3", SYSTEM) if (place / "Eigen" / "Core").is_file()), None)
