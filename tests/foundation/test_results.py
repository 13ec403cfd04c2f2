"""A field of a result is declared once: tables, JSON, arrays and data frames have it by its name, with its unit."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.cli.output import print_result
from symoro_elastic.foundation import results
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.results import (
    Field,
    Part,
    Result,
    Table,
    as_html,
    declare,
    figures_of,
    parts_of,
    plain,
    table_of,
)


@dataclass(frozen=True)
class Peak:
    """A row of `Spectrum`."""

    name: str
    hertz: float
    count: int = 12345
    height: float | None = None


@dataclass(frozen=True, repr=False)
class Spectrum(Result):
    """A toy result."""

    f: Array
    peaks: tuple[Peak, ...]
    signals: tuple[str, ...] = ("force", "<torque>")


class Bare(Result):
    """A result of which nothing is declared."""


@pytest.fixture(autouse=True)
def declared() -> Iterator[None]:
    declare(
        Peak,
        Field("name", head="peak", column="peak"),
        Field("frequency", "hertz", "frequency", "Hz", ".3g", column="frequency"),
        Field("count", head="samples"),
        Field("height", head="height", json=False),
    )
    declare(
        Spectrum,
        Field("f", array=True),
        Field("signals", array=True),
        Field("peaks", rows=Peak),
        Field("loudest", lambda spectrum: max(x.hertz for x in spectrum.peaks)),
    )
    yield
    for kind in (Peak, Spectrum):
        results._FIELDS.pop(kind)


def spectrum() -> Spectrum:
    return Spectrum(np.array([1.0, 2.5]), (Peak("first", 1.23456), Peak("last", np.nan, height=1e-9)))


@parts_of.register
def _(found: Spectrum) -> Sequence[Part]:
    return [table_of(Peak, found.peaks, "peaks"), "two of them"]


@figures_of.register
def _(found: Spectrum) -> dict[str, Plot | str]:
    return {"spectrum": Plot("toy: spectrum", lambda axes: axes.plot(found.f, found.f)), "flat": "it is flat"}


def test_a_field_is_in_tables_json_arrays_and_frames() -> None:
    table, sentence = spectrum().parts()
    assert isinstance(table, Table) and sentence == "two of them" and table.title == "peaks"
    assert table.heads == ("peak", "frequency, Hz", "samples", "height")
    assert table.rows == [("first", "1.23", "12345", "-"), ("last", "-", "12345", "1e-09")]
    data = spectrum().as_json()
    assert data["f"] == [1.0, 2.5] and data["loudest"] == pytest.approx(1.23456)
    assert data["peaks"][0] == {"name": "first", "frequency": 1.23456, "count": 12345}
    assert data["peaks"][1]["frequency"] is None and json.loads(json.dumps(data)) == data
    arrays = spectrum().arrays()
    assert [*arrays] == ["f", "signals"] and arrays["signals"] == ["force", "<torque>"]
    frame = spectrum().to_frame()
    assert [*frame] == ["peak", "frequency"] and frame["frequency"][0] == 1.23456


def test_a_field_more_is_everywhere() -> None:
    half = Field("half", lambda peak: peak.hertz / 2, "half", column="half")
    declare(Peak, *results.fields_of(Peak), half)
    table, _ = spectrum().parts()
    assert isinstance(table, Table) and table.heads[-1] == "half" and table.rows[0][-1] == "0.6173"
    assert spectrum().as_json()["peaks"][0]["half"] == spectrum().columns()["half"][0] == 1.23456 / 2


def test_what_is_not_declared_is_refused_by_name() -> None:
    for wanted in (Bare().as_json, Bare().arrays, Bare().columns, Bare().plot):
        with pytest.raises(TypeError, match=r"Bare has no \w+: use its attributes"):
            wanted()
    assert Bare().parts() == ["Bare"] and repr(Bare()) == "<Bare>"


def test_figures_are_shown_and_saved(tmp_path: Path) -> None:
    figures = spectrum().plots()
    assert (
        figures.left_out == {"flat": "it is flat"}
        and [*figures] == ["spectrum"]
        and repr(figures) == "<Figures: spectrum>"
    )
    assert figures._repr_html_().startswith('<img src="data:image/png;base64,')
    (path,) = figures.save(tmp_path, "svg")
    assert path == tmp_path / "spectrum.svg" and path.read_text(encoding="utf-8").startswith("<?xml")
    with pytest.raises(InputError, match="unknown 'gif'"):
        figures.save(tmp_path, "gif")


def test_names_and_titles_are_text_in_notebooks() -> None:
    page = as_html(Table(("<b>", "n"), [("<i>", "1"), ("x", "-")], "<title>"))
    assert "<caption>&lt;title&gt;</caption>" in page and "&lt;b&gt;" in page and "<i>" not in page
    assert page.count("text-align:right") == 3 and page.count("text-align:left") == 3


def test_plain_data_are_numbers_texts_lists_and_objects() -> None:
    assert plain({"z": 1 + 2j, "n": np.array([np.inf, 1.0]), 3: (True, None)}) == {
        "z": [1.0, 2.0],
        "n": [None, 1.0],
        "3": [True, None],
    }
    with pytest.raises(TypeError):
        json.dumps(plain(object()))


def test_commands_print_the_same_registration(capsys: pytest.CaptureFixture[str]) -> None:
    print_result(spectrum(), as_json=False)
    shown = capsys.readouterr().out
    assert "peaks" in shown and "frequency, Hz" in shown and "two of them" in shown
    print_result(spectrum(), as_json=True, written="x")
    assert json.loads(capsys.readouterr().out) == {**spectrum().as_json(), "written": "x"}


def test_a_summary_has_the_sentences_and_a_table_the_numbers() -> None:
    assert spectrum().summary() and "\n\n" not in spectrum().summary()
    assert isinstance(spectrum().table(), Table)
    with pytest.warns(DeprecationWarning, match="frame is now to_frame"):
        assert spectrum().frame().equals(spectrum().to_frame())
