"""`sweep`: files, plots, descriptions, and what it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

import symoro_elastic as se
from symoro_elastic.formats import write_machine
from tests.analysis.sweeps.machines import SLIDE, hertz
from tests.command_line import ended, refused, run

DESCRIPTION = """
of = "response"
inputs = ["load.fz"]
outputs = ["load.z"]
frequencies = [5, 10.0]
hold = ["all"]
results = ["*: at *"]
[over]
m = [1, 2.0]
"load.k" = "1e4:1e5:2,log"
"""


@pytest.fixture(autouse=True)
def _machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_machine(se.read(SLIDE), "slide.toml")


@pytest.mark.thorough
def test_tables_files_and_plots(tmp_path: Path) -> None:
    over = ("sweep", "slide.toml", "--over", "m=1,2,4", "--hold", "all", "--result", "frequency_*")
    said = run(*over, "--out", "a.csv", "--plots", "one").stdout
    assert "Sweep of slide: modes at 3 points of m" in said and "frequency_1, Hz" in said and "wrote a.csv" in said
    with open("a.csv") as stream:
        head, *rows = csv.reader(stream)
    assert head == ["m [kg]", "frequency_1 [Hz]", "reason"]
    assert [float(row[1]) for row in rows] == pytest.approx([hertz(m) for m in (1, 2, 4)], rel=1e-14)
    run(*over, "--over", "load.k=1e4:1e5:3", "--plots", "two")
    run(*over[:2], "--over", "m=1:2", "--samples", "8", "--hold", "all", "--plots", "many")
    assert [path.name for folder in ("one", "two", "many") for path in sorted(Path(folder).iterdir())] == [
        "frequency_1_over_m.png",
        "frequency_1_over_m_and_load_k.png",
        "influence.png",
    ]


def test_a_file_describes_a_sweep_and_options_go_before() -> None:
    Path("sweep.toml").write_text(DESCRIPTION)
    found = json.loads(run("sweep", "slide.toml", "--sweep", "sweep.toml", "--json").stdout)
    assert list(found["figures"]) == ["load.z / load.fz: at 5 Hz", "load.z / load.fz: at 10 Hz"]
    assert found["lengths"] == [2, 2] and found["quantities"]["m"] == [1.0, 1.0, 2.0, 2.0]
    assert found["quantities"]["load.k"] == pytest.approx([1e4, 1e5, 1e4, 1e5])
    other = run("sweep", "slide.toml", "--sweep", "sweep.toml", "--over", "m=3", "--frequency", "7", "--json").stdout
    found = json.loads(other)
    assert found["quantities"]["m"] == [3.0, 3.0] and list(found["figures"]) == ["load.z / load.fz: at 7 Hz"]


def test_points_without_result_are_counted_and_null_in_json() -> None:
    found = json.loads(run("sweep", "slide.toml", "--over", "load.k=-1,1e4", "--hold", "all", "--json").stdout)
    assert found["failed"] == {"0": "load.k is negative: -1"} and found["figures"]["frequency_1"][0] is None
    said = run("sweep", "slide.toml", "--over", "load.k=-1,1e4", "--hold", "all").stdout
    assert "1 of 2 points have no result:" in said and "1 times load.k is negative: -1" in said


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("of = 3", "sweep.toml: of: must be a text"),
        ('over = { m = "(1.0, nan)" }', "sweep.toml: over, m: 'm=(1.0, nan)'"),
        ("over = { m = [1.0, nan] }", "sweep.toml: over, m: nan is not finite"),
        ('over = { m = "1,2" }\nfrequencies = [inf]', "sweep.toml: frequencies: inf is not finite"),
        ('over = { m = ["a"] }', "sweep.toml: over, m: must be a number"),
        ("over = { m = [nan] }", "nan is not finite"),
        ("over = { m = [] }", "a grid needs at least one value"),
        ("over = { m = true }", "must be a number"),
        ("overs = 3", "did you mean 'over'?"),
        ("samples = 2.5", "must be a whole number"),
        ("of = \"modes", "not TOML"),
    ],
)  # fmt: skip
def test_descriptions_that_are_none(text: str, said: str) -> None:
    Path("sweep.toml").write_text(text)
    assert said in refused("sweep", "slide.toml", "--sweep", "sweep.toml")


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--over m", "'m' is not NAME=VALUES"),
        ("--over m=", "is not NAME=VALUES"),
        ("--over m=1,2 --over m=3", "m is given twice: keep one"),
        ("--over m=1 --workers -1", "--workers: -1"),
        ("--over m=1 --samples 3.5", "--samples: '3.5' is not a whole number"),
        ("--over m=1 --out a.txt", "--out: unknown format '.txt'"),
        ("--over m=1 --scheduler somewhere", "--scheduler: 'somewhere' is not an address"),
        ("", "--over: nothing to sweep"),
    ],
)
def test_options_that_are_refused(options: str, said: str, tmp_path: Path) -> None:
    before = sorted(tmp_path.iterdir())
    assert said in refused("sweep", "slide.toml", *options.split())
    assert sorted(tmp_path.iterdir()) == before


def test_an_interrupted_sweep_says_where_its_points_are(monkeypatch: pytest.MonkeyPatch) -> None:
    from symoro_elastic.api import swept

    compute, calls = swept.SweptModes.__call__, []

    def interrupted(self: swept.SweptModes, values: dict[str, float], positions: dict[str, float]) -> dict[str, float]:
        calls.append(values)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return compute(self, values, positions)

    monkeypatch.setattr(swept.SweptModes, "__call__", interrupted)
    over = ("sweep", "slide.toml", "--over", "m=1,2,3,4", "--hold", "all", "--out", "a.csv")
    found = ended(*over)
    assert found.code == 130 and "note: interrupted, a.csv.journal keeps what was computed" in found.err
    assert not Path("a.csv").exists() and len(Path("a.csv.journal").read_text().splitlines()) == 3
    found = ended(*over)
    assert found.code == 0 and "note: 2 of 4 points were computed before and are kept" in found.err
    assert len(calls) == 5 and Path("a.csv").exists() and not Path("a.csv.journal").exists()
    calls[:] = [{}, {}]
    found = ended(*over[:-1], "b.csv")
    assert "note: interrupted, nothing was written" in found.err and not Path("b.csv.journal").exists()
