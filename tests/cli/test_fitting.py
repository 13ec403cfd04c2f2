"""Tables in 80 columns: every name and every number is there, in one piece."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from symoro_elastic.analysis.vibration.comparison import compare
from symoro_elastic.analysis.vibration.views import frequencies_table, losses_table
from symoro_elastic.cli import output
from symoro_elastic.foundation.results import Table
from symoro_elastic.pages.models_page import catalogue_lines
from tests.analysis.vibration.test_reduced import arm
from tests.command_line import EXAMPLES, run

WIDTH = 80
TWO_AXIS, FLEX4, TWO_R = (EXAMPLES / name for name in ("two_axis.toml", "flex4.par", "planar_2r.toml"))
LIMITS = ("--position", "-1:1", "--velocity", 2, "--acceleration", 9, "--evaluations", 2, "--sample-rate", 100)
COMMANDS: dict[str, tuple[object, ...]] = {
    **{f"show {path.stem}": ("show", path) for path in sorted(EXAMPLES.glob("*.[tp][oa][mr]*"))},
    **{f"generate {path.stem}": ("generate", path, "--target", "numpy") for path in (TWO_AXIS, FLEX4)},
    "generate all": ("generate", TWO_R, "--model", "inverse_dynamics_parameter_derivatives", "--only",
                     "inverse_dynamics_parameter_derivatives by m1", "--target", "numpy"),
    "check": ("check", TWO_R),
    "check self": ("check", "--self", TWO_R),
    "modes": ("modes", TWO_AXIS, "--hold", "all"),
    "modes, all free": ("modes", TWO_AXIS),
    "modes over": ("modes", TWO_AXIS, "--hold", "all", "--along", "motor_y=0:1:3"),
    "response": ("response", TWO_AXIS),
    "excite": ("excite", TWO_R, *LIMITS),
}  # fmt: skip


def rendered(table: Table, width: int) -> list[str]:
    """The lines of a table at a width; none is longer, and a console as wide as a table cuts none."""
    lines = []
    for part in output.fit_tables(table, width):
        console = Console(width=width, highlight=False)
        with console.capture() as shown:
            console.print(part)
        lines += shown.get().splitlines()
    assert all(len(line) <= width and "\N{HORIZONTAL ELLIPSIS}" not in line for line in lines)
    return lines


def lost(table: Table, lines: list[str]) -> list[str]:
    """Words of a table that are in no line; columns without text may be missing."""
    text = "\n".join(lines)
    columns = [(head, *cells) for head, cells in table.columns if any(cells)]
    words = {word for column in columns for cell in column for word in cell.split()}
    return sorted(word for word in words if word not in text)


@pytest.mark.sampled(16)
@pytest.mark.parametrize("command", COMMANDS)
def test_tables_of_the_examples_lose_nothing(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tables = []
    whole = output.fit_tables

    def recorded(table: Table, width: int) -> list[Any]:
        tables.append(table)
        return whole(table, width)

    monkeypatch.setattr(output, "PIPED", WIDTH)
    monkeypatch.setattr(output, "fit_tables", recorded)
    extra = {"generate": ("--out", tmp_path), "excite": ("--out", tmp_path / "motion.csv")}
    ran = run(*COMMANDS[command], *extra.get(command.split(maxsplit=1)[0], ()))
    monkeypatch.undo()
    assert ran.exit_code == 0 and tables
    for table in tables:
        lines = rendered(table, WIDTH)
        assert lost(table, lines) == []
        assert all(line.rstrip() in ran.stdout for line in lines)


@pytest.mark.thorough
def test_tables_of_comparisons_lose_nothing() -> None:
    found = compare(arm(rotor=0.6, axial=0.0), ratios={"motor2": 7.5})
    for table in (frequencies_table(found), losses_table(found)):
        assert lost(table, rendered(table, WIDTH)) == []


def test_models_lose_nothing() -> None:
    lines = catalogue_lines(WIDTH)
    assert all(len(line) <= WIDTH for line in lines)
    assert " ".join(" ".join(catalogue_lines(400)).split()) == " ".join(" ".join(lines).split())


@pytest.mark.thorough
def test_any_table_loses_nothing_at_any_width() -> None:
    draw = random.Random(1)

    def text(most: int) -> str:
        words = (
            "".join(draw.choices("abcdefgh_0123456789.", k=draw.randint(1, most))) for _ in range(draw.randint(1, 5))
        )
        return draw.choice((" ", ", ", " = ")).join(words)

    for _ in range(150):
        columns = draw.randint(1, 12)
        table = Table(tuple(text(9) for _ in range(columns)), keys=draw.randint(1, 2))
        for _ in range(draw.randint(1, 6)):
            table.add_row(*(text(18) for _ in range(columns)))
        assert lost(table, rendered(table, draw.choice((80, 100, 120)))) == []


def test_long_words_are_broken_and_kept() -> None:
    table = Table(("name", "formula"))
    table.add_row("base", "x" * 200)
    assert "".join(rendered(table, 40)).count("x") == 200


def test_columns_without_text_are_left_out() -> None:
    table = Table(("name", "empty", "value"))
    table.add_row("one", "", "[m]")
    (head, _, row) = (line for line in rendered(table, 80) if line.strip())
    assert head.split() == ["name", "value"] and row.split() == ["one", "[m]"]


def test_wide_enough_tables_stay_as_they_are() -> None:
    table = Table(("model", "a call"))
    table.add_row("direct_dynamics", "124x 116+ 4 sin/cos")
    assert len(output.fit_tables(table, 80)) == 1
    assert "  direct_dynamics   124x 116+ 4 sin/cos  " in rendered(table, 80)
