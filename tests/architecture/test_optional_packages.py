"""Packages that only some commands need: missing, or installed and broken."""

from __future__ import annotations

import pytest

from symoro_elastic.foundation import packages
from symoro_elastic.foundation.errors import InputError

MISSING = ModuleNotFoundError("No module named 'scipy'", name="scipy")
BROKEN = ImportError("libopenblas.so: failed to map segment from shared object")
OTHER = ModuleNotFoundError("No module named 'numpy.core'", name="numpy.core")


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MISSING, r"scipy: identification needs scipy: pip install 'symoro-elastic\[identify\]'"),
        (BROKEN, "scipy: scipy is installed, but cannot be loaded: libopenblas.so: failed to map"),
        (OTHER, "scipy: scipy is installed, but cannot be loaded: No module named 'numpy.core'"),
    ],
)
def test_what_is_missing_is_told_from_what_is_broken(
    error: ImportError, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(_: str) -> None:
        raise error

    monkeypatch.setattr(packages, "import_module", fails)
    with pytest.raises(InputError, match=said):
        packages.for_identification("scipy.optimize")
