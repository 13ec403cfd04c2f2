"""Files of two runs together are an error of the compiler or of the import, whichever file is of the other run."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

import symoro_elastic as se
from symoro_elastic.codegen.templates import DIGEST
from symoro_elastic.foundation.output_files import fill_folder
from tests.examples import EXAMPLES
from tests.generated_code import imported

NAME = "planar_2r"
SOURCES = {
    "planar_2r.c": ("planar_2r.h",),
    "planar_2r_batch.c": ("planar_2r.h", "planar_2r_batch.h"),
    "planar_2r_mex.c": ("planar_2r.h",),
    "planar_2r_fixed.c": ("planar_2r_fixed.h",),
    "planar_2r.cu": ("planar_2r.cuh",),
}
"""Sources, and the headers that they include."""
PAIRS = [(source, header) for source, headers in SOURCES.items() for header in headers]
STUBS = {"mex.h": "", "cuda_runtime.h": ""}
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc")


@pytest.fixture(scope="module", name="runs")
def _runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Mapping[str, str], Mapping[str, str]]:
    """Files of two machines that differ in the length of a link."""
    return generated(tmp_path_factory.mktemp("first"), 0.4), generated(tmp_path_factory.mktemp("second"), 0.5)


def generated(folder: Path, length: float) -> dict[str, str]:
    text = (EXAMPLES / f"{NAME}.toml").read_text(encoding="utf-8").replace("value = 0.4,", f"value = {length},")
    machine = folder / f"{NAME}.toml"
    machine.write_text(text, encoding="utf-8")
    for target in (["numpy", "c", "c-batch", "matlab", "cuda"], ["c-fixed"]):
        se.generate(machine, "inverse_dynamics", targets=target, out=folder / target[0])
    made = [path for path in folder.rglob("*") if path.is_file() and path.suffix not in (".toml", ".json")]
    return {path.name: path.read_text(encoding="utf-8") for path in made}


def complaints(folder: Path, source: str) -> str:
    """The errors of the preprocessor about a source."""
    command = ["gcc", "-E", "-x", "c", "-I.", source, "-o", "/dev/null"]
    said = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False).stderr
    return "\n".join(line for line in said.splitlines() if "error:" in line)


@needs_gcc
@pytest.mark.parametrize(("source", "header"), PAIRS)
def test_no_source_is_compiled_with_the_header_of_another_run(
    source: str, header: str, runs: tuple[Mapping[str, str], Mapping[str, str]], tmp_path: Path
) -> None:
    first, second = runs
    files = STUBS | {name: first[name] for name in (source, *SOURCES[source])}
    fill_folder(tmp_path, files)
    assert not complaints(tmp_path, source)
    for replaced in (source, header):
        fill_folder(tmp_path, files | {replaced: second[replaced]})
        assert f'#error "{header} is of another run: generate all files again"' in complaints(tmp_path, source)


def test_no_module_is_imported_with_those_of_another_run(
    runs: tuple[Mapping[str, str], Mapping[str, str]], tmp_path: Path
) -> None:
    first, second = ({name: run[name] for name in run if name.endswith(".py")} for run in runs)
    assert len(first) == 3
    fill_folder(tmp_path / "first", first)
    imported(tmp_path / "first")
    for name in first:
        folder = tmp_path / Path(name).stem
        fill_folder(folder, first | {name: second[name]})
        with pytest.raises(ImportError, match="is of another run of symoro-elastic: generate all files again"):
            imported(folder)


def test_every_digest_is_in_its_place(runs: tuple[Mapping[str, str], Mapping[str, str]]) -> None:
    """Of each of the targets, by which texts are told apart that are otherwise the same."""
    first, second = runs
    assert not any(DIGEST[0] in text for text in first.values())
    digests = {name: set(re.findall(r"_DIGEST (?:!?=+ )?(\d{9})\b", text)) for name, text in first.items()}
    for name in (*SOURCES, "planar_2r.h", "__init__.py", "_runtime.py"):
        assert digests[name], name
        assert not digests[name] & {*re.findall(r"\d{9}", second[name])}, name
