"""Measured figures of the documentation: `python -m tests.benchmarks.figures [--measure RUN ...] [--write]`.

`data/figures.json` has them by name, with the command, the processor and the compilers that gave them. Ratios are times
faster than the fastest build of the peer. A page marks a figure by its name, `9.5<!--6R/inverse/call/AVX2-->`, and a
table made of figures by `<!--table NAME-->` above and `<!--end-->` below. --measure runs commands of `RUNS` and
replaces their figures; --write writes all figures into the pages; without options, what differs is printed.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

from symoro_elastic.codegen.precision import DOUBLE
from tests.benchmarks.contest import COMPILERS, CXX_COMPILERS
from tests.benchmarks.speed import OF_SINES, fastest
from tests.benchmarks.tables import DATA, save_json
from tests.benchmarks.targets import ARM, ARM_7, QUADRUPED, TREE, TWO

ROOT = Path(__file__).parents[2]
FILE = DATA / "figures.json"
MARK = re.compile(r"(\d+(?:\.\d+)?)<!--([\w/.-]+)-->")
BLOCK = re.compile(r"<!--table (\w+)-->\n.*?<!--end-->", re.DOTALL)
RATIO = re.compile(r"\b1/\d+(?:\.\d+)?|\d+(?:\.\d+)?(?:\s+to\s+\d+(?:\.\d+)?)?\s+times\s+(?:faster|slower)")
"""How pages print ratios of times."""
PEERS = re.compile(r"Pinocchio|CasADi|MuJoCo")
MACHINES = {ARM: "6R", ARM_7: "7R", TREE: "29", TWO: "two-axis", QUADRUPED: "quadruped"}
MODELS = {
    "inverse_dynamics": "inverse",
    "direct_dynamics": "direct",
    "inertia_matrix": "matrix",
    "inverse_dynamics_derivatives": "inverse-derivatives",
    "direct_dynamics_derivatives": "direct-derivatives",
}
SR400 = {"direct_dynamics_by_inertia_matrix": "matrix", "direct_dynamics": "recursion"}
Named = dict[str, float]


class Measurement(NamedTuple):
    """A command, the processor that it compiles for, and the named figures in what its --json saves."""

    module: str
    picked: Callable[[Any, str], Named]
    march: str = "native"
    options: tuple[str, ...] = ()

    @property
    def command(self) -> str:
        march = "" if self.march == "native" else f"BENCHMARK_MARCH={self.march} "
        return " ".join([f"{march}python -m tests.benchmarks.{self.module}", *self.options])

    @property
    def instructions(self) -> str:
        """The widest vectors of what it compiles for."""
        has_512 = "avx512f" in Path("/proc/cpuinfo").read_text(encoding="utf-8")
        return "AVX-512" if has_512 and self.march == "native" else "AVX2"


def of_speed(saved: Any, instructions: str) -> Named:
    """Return the fastest call and batch of each row, and a call against C that CasADi generates."""
    named: Named = {}
    for machine, model, rows in by_row(saved["figures"]):
        batches = [row for row in rows if row["contestant"].startswith(f"batch, double, {instructions}, ")]
        calls = [row for row in rows if row["contestant"].startswith("call")]
        casadi = [row["ns"] for row in rows if row["contestant"].startswith("CasADi")]
        named[f"{machine}/{model}/call/{instructions}"] = max(row["ratio"] for row in calls)
        if batches:
            named[f"{machine}/{model}/batch/{instructions}"] = max(row["ratio"] for row in batches)
        if casadi:
            named[f"{machine}/{model}/CasADi/{instructions}"] = min(casadi) / min(row["ns"] for row in calls)
        if instructions == "AVX-512" and model in ("inverse", "direct"):
            named |= {f"{machine}/{model}/{name}": share for name, share in shares(rows, saved["limits_ns"])}
    return named


def shares(rows: list[dict[str, Any]], limits: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Yield per cent of the processor's products and sums that batches reach, without and with those of sines."""
    for width in ("AVX-512", "AVX2"):
        row = fastest({row["contestant"]: row for row in rows}, f"batch, double, {width}")
        operations, sines, ns = (float(row[key]) for key in ("operations", "sines", "ns"))
        for name, more in (("share", 0.0), ("share-sines", sines * OF_SINES[DOUBLE.name])):
            yield f"{name}/{width}", 100 * (operations + more) * limits[f"double, {width}, unfused"] / ns


def of_record(saved: Any, instructions: str) -> Named:
    """Return nanoseconds of a state, by precision and vectors."""
    kinds = {instructions: "the processor's vectors", "AVX2": "AVX2"}
    named = {
        f"record/{precision}/{kind}": saved[f"batch, {precision}, {name}"]
        for precision in ("double", "single", "mixed")
        for kind, name in kinds.items()
    }
    return {**named, "record/double/call": saved["call, double"]}


def of_derivatives(saved: Any, instructions: str) -> Named:
    return {
        f"{machine}/{model}/call/{instructions}": max(r["ratio"] for r in rows if r["contestant"].startswith("call"))
        for machine, model, rows in by_row(saved["figures"])
    }


def of_closed_chains(saved: Any, instructions: str) -> Named:
    named: Named = {}
    for row in saved["times"]:
        name = SR400.get(row["contestant"].removesuffix(", base parameters"))
        if row["machine"] == "sr400" and name:
            key = f"SR400/direct/{name}"
            named[key] = max(row["ratio"], named.get(key, 0))
    return named


def of_problems(saved: Any, _: str) -> Named:
    """Return nanoseconds of ours and of Pinocchio with an error below 1e-12, and their ratio, by problem."""
    named: Named = {}
    for problem, name in PROBLEMS.items():
        rows = [row for row in saved if row["problem"] == problem]
        best = min((row for row in rows if not row["contestant"].startswith("Pinocchio")), key=lambda row: row["ns"])
        start = f"problem/{name}"
        named |= {f"{start}/ratio": best["ratio"], f"{start}/ns": best["ns"]}
        named[f"{start}/Pinocchio-us"] = best["ns"] * best["ratio"] / 1000
    return named


PROBLEMS = {"Andrews' squeezer": "squeezer", "2 four-bars": "four-bars", "governor": "governor"}


def of_python(saved: Any, instructions: str) -> Named:
    """Return nanoseconds of each contestant, and ratios over Pinocchio's binding."""
    named: Named = {}
    for figure in saved["figures"]:
        start = f"{MACHINES[figure['machine']]}/{MODELS[figure['model']]}/python-{figure['states']}"
        named[f"{start}/ratio"] = figure["ratio"]
        for contestant in CONTESTANTS:
            if contestant in figure:
                named[f"{start}/{contestant.split()[-1]}"] = figure[contestant]
    return named


def of_loops(saved: Any, _: str) -> Named:
    """Return microseconds of loops by contestant, and ratios over Pinocchio's binding."""
    return {
        f"loop/{figure['loop'].split()[0].strip(',')}/{contestant.split()[-1]}": figure[contestant]
        for figure in saved["figures"]
        for contestant in (*CONTESTANTS, "ratio")
    }


CONTESTANTS = ("backend c", "by ctypes", "numpy", "Pinocchio")


def by_row(figures: list[dict[str, Any]]) -> Iterator[tuple[str, str, list[dict[str, Any]]]]:
    rows = dict.fromkeys((figure["machine"], figure["model"]) for figure in figures)
    for machine, model in rows:
        chosen = [figure for figure in figures if (figure["machine"], figure["model"]) == (machine, model)]
        yield MACHINES[machine], MODELS[model], chosen


AVX2_MARCH = "x86-64-v3"
RUNS = {
    "speed, AVX2": Measurement("speed", of_speed, AVX2_MARCH),
    "speed, AVX-512": Measurement("speed", of_speed),
    "derivatives, AVX2": Measurement("derivatives", of_derivatives, AVX2_MARCH),
    "derivatives, AVX-512": Measurement("derivatives", of_derivatives),
    "closed_chains": Measurement("closed_chains", of_closed_chains),
    "problems": Measurement("problems", of_problems),
    "python_calls": Measurement("python_calls", of_python, options=("--rounds", "150")),
    "python_loops": Measurement("python_loops", of_loops, options=("--rounds", "60")),
    "record": Measurement("record", of_record),
}
"""Those of AVX-512 need a processor that has it."""


def stored() -> dict[str, Any]:
    saved: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return saved


def figures() -> Named:
    """Return all figures by name, and the least and the largest ratio of calls to the fastest build of Pinocchio."""
    named: Named = {}
    for run in stored().values():
        assert not named.keys() & run["figures"].keys(), "a name belongs to one run"
        named |= run["figures"]
    models = ("inverse", "direct", "matrix")
    calls = [value for name, value in named.items() if re.search(r"/call/", name) and name.split("/")[1] in models]
    python = [value for name, value in named.items() if name.endswith("/python-1/ratio")]
    return named | {
        "call/least": min(calls),
        "call/most": max(calls),
        "python/least": min(python),
        "python/most": max(python),
    }


def measured(named: Named, figure: str) -> list[tuple[str, str]]:
    """Return titles and names of the machines with a figure."""
    return [(title, machine) for title, machine in MACHINES.items() if f"{machine}/{figure}" in named]


def python_table(named: Named) -> str:
    """Return the table of calls from Python, a row for each machine and model."""
    columns = ["python-1/c", "python-1/ctypes", "python-1/numpy", "python-1/Pinocchio", "python-1000/c"]
    head = '| | | `"c"` | ctypes | numpy | Pinocchio | `"c"`, of 1000 states | numpy, of 1000 |\n|' + "---|" * 8
    rows = [head]
    for title, machine in measured(named, "inverse/python-1/c"):
        for model in ("inverse", "direct"):
            cells = [f"{named[f'{machine}/{model}/{column}']:.0f}" for column in (*columns, "python-1000/numpy")]
            rows.append(f"| {title} | {model} | {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


def loops_table(named: Named) -> str:
    """Return the table of loops in Python, a row for each."""
    rows = ['| us | `"c"` | ctypes | numpy | Pinocchio | times faster than Pinocchio |\n|' + "---|" * 6]
    for key, title in LOOPS.items():
        cells = [f"{named[f'loop/{key}/{x}']:.3g}" for x in ("c", "ctypes", "numpy", "Pinocchio", "ratio")]
        rows.append(f"| {title} | {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


LOOPS = {
    "environment": "an environment: PD controller, step, observation",
    "DOP853": "SciPy's DOP853, 0.1 s",
    "128": "predictive control by 128 samples of 20 steps",
}


def calls_table(named: Named) -> str:
    """Return how many times faster calls and batches are, a row for each machine and model."""
    columns = ("call/AVX2", "call/AVX-512", "batch/AVX2", "batch/AVX-512", "CasADi/AVX2", "CasADi/AVX-512")
    head = "call, AVX2 | call, AVX-512 | batch, AVX2 | batch, AVX-512 | CasADi, AVX2 | CasADi, AVX-512"
    rows = [f"| | {head} |\n|---{'|---:' * len(columns)}|"]
    for title, machine in MACHINES.items():
        for model in MODELS.values():
            cells = [named.get(f"{machine}/{model}/{column}", 0) for column in columns]
            if any(cells):
                texts = [f"{value:.{0 if value >= 100 else 1}f}" if value else "" for value in cells]
                rows.append(f"| {title}, {model.replace('-', ' ')} | {' | '.join(texts)} |")
    return "\n".join(rows) + "\n"


def conditions_table(_: Named) -> str:
    """Return the command, the processor and the compilers of each run."""
    rows = ["| command | processor, load | compilers: ours; Pinocchio's |\n|---|---|---|"]
    for run in stored().values():
        compilers = "; ".join(filter(None, (run["compilers"], run["compilers of Pinocchio"])))
        processor = ", ".join(filter(None, (run["processor"], run["instructions"], run["load"], run.get("note"))))
        rows.append(f"| `{run['command']}` | {processor} | {compilers} |")
    return "\n".join(rows) + "\n"


def shares_table(named: Named) -> str:
    """Return the parts of the processor's limit that batches reach, both models in a cell."""
    heads = {f"{name}/{width}": f"{width}{more}" for width in ("AVX-512", "AVX2") for name, more in OF_SHARES.items()}
    rows = [f"| | {' | '.join(heads.values())} |\n|{'---|' * 5}"]
    for title, machine in measured(named, "inverse/share/AVX2"):
        cells = (", ".join(f"{named[f'{machine}/{m}/{key}']:.0f} %" for m in ("inverse", "direct")) for key in heads)
        rows.append(f"| {title}, inverse, direct | {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


OF_SHARES = {"share": "", "share-sines": ", with sines"}


def record_table(named: Named) -> str:
    """Return nanoseconds of a state by precision."""
    precisions = ("double", "single", "mixed")
    rows = [f"| | {' | '.join(precisions)} |\n|{'---|' * 4}"]
    for kind, title in {"AVX-512": "batch, AVX-512", "AVX2": "batch, AVX2", "call": "single calls"}.items():
        values = (named.get(f"record/{precision}/{kind}") for precision in precisions)
        rows.append(f"| {title}, ns a state | {' | '.join(f'{x:.1f}' if x else '' for x in values)} |")
    return "\n".join(rows) + "\n"


TABLES: Mapping[str, Callable[[Named], str]] = {
    "python": python_table,
    "loops": loops_table,
    "calls": calls_table,
    "conditions": conditions_table,
    "shares": shares_table,
    "record": record_table,
}


def pages() -> dict[Path, str]:
    """Return the pages that print figures, with their text."""
    paths = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return {path: path.read_text(encoding="utf-8") for path in paths}


def rewritten(page: str, named: Named) -> str:
    """Return a page with the stored figures, each with as many decimals as it has on the page."""

    def number(mark: re.Match[str]) -> str:
        decimals = len(mark[1].partition(".")[2])
        return f"{named[mark[2]]:.{decimals}f}{mark[0][len(mark[1]) :]}"

    def table(block: re.Match[str]) -> str:
        return f"<!--table {block[1]}-->\n\n{TABLES[block[1]](named)}\n<!--end-->"

    return BLOCK.sub(table, MARK.sub(number, page))


def unmarked(page: str) -> list[str]:
    """Return ratios of times in paragraphs and rows about peers that are not marked by the name of a figure."""
    parts = [part for text in re.split(r"\n\n|\n(?=[|-] )", page) for part in [text] if PEERS.search(text)]
    plain = [re.sub(r"\d+(?:\.\d+)?<!--[^>]*-->", "N", part) for part in parts]
    return [ratio for part in plain for ratio in RATIO.findall(part)]


def measure(names: list[str]) -> None:
    """Run commands one after another, and store their figures and conditions."""
    saved = stored() if FILE.exists() else {}
    for name in names:
        run = RUNS[name]
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "figures.json"
            command = [sys.executable, "-m", f"tests.benchmarks.{run.module}", "--json", str(file), *run.options]
            environment = {**os.environ, "BENCHMARK_MARCH": run.march}
            subprocess.run(command, cwd=ROOT, env=environment, check=True)
            picked = run.picked(json.loads(file.read_text(encoding="utf-8")), run.instructions)
        about = {"command": run.command, "instructions": run.instructions, **conditions()}
        saved[name] = {**about, "figures": {key: float(f"{value:.3g}") for key, value in picked.items()}}
        save_json(FILE, {key: saved[key] for key in RUNS if key in saved})


def conditions() -> dict[str, str]:
    """Return the processor, the compilers and the libraries of this computer, and its load."""
    cpu = re.search(r"^model name\s*: (.*)$", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.MULTILINE)
    peers = {package: package_version(package) for package in ("pin", "casadi", "mujoco", "numpy")}
    return {
        "processor": cpu[1] if cpu else "unknown",
        "compilers": ", ".join(compiler_version(name) for name in COMPILERS),
        "compilers of Pinocchio": ", ".join(map(compiler_version, CXX_COMPILERS)),
        "packages": ", ".join(f"{name} {number}" for name, number in peers.items() if number),
        "load": f"{os.getloadavg()[1]:.1f} of {os.cpu_count()} cores",
    }


def compiler_version(name: str) -> str:
    done = subprocess.run([name, "-dumpfullversion", "-dumpversion"], capture_output=True, text=True, check=True)
    return f"{name} {done.stdout.strip()}"


def package_version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.figures", description=__doc__)
    parser.add_argument("--measure", nargs="*", choices=[*RUNS, []], metavar="RUN", help="runs; all if none is named")
    parser.add_argument("--write", action="store_true", help="write the figures into the pages")
    arguments = parser.parse_args()
    if arguments.measure is not None:
        measure(arguments.measure or list(RUNS))
    named = figures()
    for path, page in pages().items():
        if (new := rewritten(page, named)) != page:
            print(f"{path.relative_to(ROOT)}: {'written' if arguments.write else 'differs'}")
            if arguments.write:
                path.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()
