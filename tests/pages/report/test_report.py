"""The page about a machine: what it holds, what it links, and what it never loads."""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from html import unescape
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.pages.equations.page import link_symbols
from tests.golden import ROOT
from tests.pages.document_readers import Page

DRIVE: dict[str, Any] = {
    "name": "drive",
    "notes": ["a <b>note</b> & more"],
    "gravity": [0, 0, 0],
    "joints": [
        {"name": "motor", "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "arm", "antecedent": "motor", "kind": "elastic", "sigma": 0, "theta": "q2"},
        {"name": "tool", "antecedent": "arm", "kind": "fixed", "sigma": 2, "d": "L"},
    ],
    "parameters": {"L": {"value": 0.5, "unit": "m"}},
    "bodies": {
        "motor": {"mass": 1.0, "inertia": [0.01, 0.01, 0.02]},
        "arm": {"mass": 2.0, "center_of_mass": [0.25, 0.0, 0.0], "inertia": [0.01, 0.04, 0.04]},
    },
    "motors": {"motor": {"rotor_inertia": 0.1}},
    "springs": {"arm": {"stiffness": 1000.0}},
}
TITLES = [
    "Summary",
    "Machine",
    "Modes",
    "Stiffness at the tool",
    "Frequency responses",
    "Operations",
    "Accuracy",
    "Equations",
]


@pytest.fixture(scope="module")
def page() -> str:
    pytest.importorskip("scipy")
    return se.report(DRIVE).html


@pytest.mark.thorough
def test_sections_in_their_order(page: str) -> None:
    assert re.findall(r'<h2 id="\w+">(.*?)</h2>', page)[: len(TITLES)] == TITLES
    assert "Not for this machine" not in page


@pytest.mark.thorough
def test_the_first_frequency_is_that_of_the_spring(page: str) -> None:
    """f = sqrt(k / (ZZ + M d^2)) / 2 pi with the motor held."""
    hertz = np.sqrt(1000.0 / (0.04 + 2.0 * 0.25**2)) / (2 * np.pi)
    assert f"Mode 1: {hertz:.4g} Hz, 100% of the strain energy in arm" in unescape(page)


@pytest.mark.thorough
def test_the_summary_answers_first(page: str) -> None:
    """Frequency and stiffness in closed form: a bar on a spring, pushed across at 0.5 m."""
    rows = dict(re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", unescape(page)))
    assert list(rows) == ["First vibration", "Stiffness at rest", "Cost of a call", "Accuracy", "Warnings"]
    assert "is limited by arm (100% of its strain energy)" in rows["First vibration"]
    assert rows["Stiffness at rest"].startswith(
        f"tool.y under tool.fy: {1e-6 * 1000 / 0.5**2:.4g} N/um at rest, limited by arm"
    )
    assert re.search(r"inverse dynamics \d+x \d+\+", rows["Cost of a call"]) and "within its bound" in rows["Accuracy"]
    assert rows["Warnings"] == "none"


@pytest.mark.thorough
def test_heads_have_units_and_numbers_stand_below_each_other(page: str) -> None:
    shown = unescape(page).replace("\u00a0", " ")
    assert all(head in shown for head in (">alpha, rad<", ">d, m<", ">M, kg<", ">MX, kg m<", ">ZZ, kg m2<"))
    assert "k = 1000 N m/rad" in shown or "k = 1000.0 N m/rad" in shown
    masses = re.findall(r'<td style="[^"]*right" data-head="M, kg">(.*?)</td>', shown)
    assert masses == ["1.0", "2.0"]
    zz = re.findall(r'data-head="ZZ, kg m2">(.*?)</td>', shown)
    tails = [re.sub("<.*?>", "", cell).partition(".")[2] for cell in zz]
    assert len({len(tail) for tail in tails}) == 1


@pytest.mark.thorough
def test_names_and_notes_are_text(page: str) -> None:
    assert "a &lt;b&gt;note&lt;/b&gt; &amp; more" in page
    assert "<b>note" not in page


def test_nothing_is_loaded(page: str) -> None:
    without_pictures = re.sub(r'src="data:[^"]*"', "", page)
    assert not re.search(r"https?:(?!//www\.w3\.org)|url\(|@import|<script[^>]+src|<link", without_pictures)
    assert "default-src 'none'" in page


def test_places_are_unique_and_links_lead_to_them(page: str) -> None:
    read = Page(page)
    assert len(read.ids) == len(set(read.ids))
    named = {name.removeprefix("#") for name in read.references if name.startswith("#")}
    named |= set(re.findall(r'data-of="([^"]+)"', page))
    assert named <= set(read.ids)
    assert len(set(re.findall(r'data-of="([^"]+)"', page))) > 10


def test_pictures_are_described_and_whole(page: str) -> None:
    images = re.findall(r'<img class="\w+" src="data:image/svg\+xml;base64,([^"]*)" alt="([^"]*)">', page)
    assert len(images) == page.count("<img") == 1 + 1 + 1 + 1
    assert all(described for _, described in images)
    for picture, _ in images:
        ElementTree.fromstring(base64.b64decode(picture))


def test_what_cannot_be_computed_says_why(tmp_path: Path) -> None:
    """Without values nothing vibrates, and the rest of the page is there."""
    pytest.importorskip("scipy")
    machine = se.read(DRIVE)
    unknown = replace(machine, parameters=tuple(replace(p, value=None) for p in machine.parameters))
    stiff = {**DRIVE, "springs": {}, "joints": [{**row, "kind": "motor"} for row in DRIVE["joints"][:1]]}
    assert "no joint is elastic" in se.report({**stiff, "bodies": {"motor": DRIVE["bodies"]["motor"]}}).html
    found = se.report(unknown)
    assert "Equations" in found.html
    path = found.write(tmp_path)
    assert path == tmp_path / "drive.html"
    with pytest.raises(se.InputError, match="exists"):
        found.write(tmp_path)


@pytest.mark.thorough
def test_the_same_bytes_every_time(page: str) -> None:
    assert se.report(DRIVE).html == page


def test_symbols_are_linked_to_the_longest_definition() -> None:
    defined = {"<msub>a</msub>": "a", "<mrow><msub>a</msub>b</mrow>": "ab"}
    found = link_symbols("<mo>x</mo><mrow><msub>a</msub>b</mrow><msub>a</msub>", defined)
    assert re.findall(r'data-of="(\w+)"', found) == ["ab", "a"]


@pytest.mark.thorough
def test_short_models_are_written_out() -> None:
    """A and H of the planar arm as in a textbook, before the steps."""
    pytest.importorskip("scipy")
    text = se.report(str(ROOT / "examples" / "planar_2r.toml")).html
    assert "A(q) qdd + H(q, qd)" in text
    assert text.index("inertia_matrix-written1") < text.index("<summary>planar_2r: inertia matrix")


@pytest.mark.thorough
def test_a_machine_with_drives_has_a_section_about_them() -> None:
    """Its margins are those of `control`; gains that are sought say that they need damping."""
    pytest.importorskip("scipy")
    given = {**DRIVE, "drives": {"motor": {"Kp": 3.0, "Kv": 10, "Tn": 0.1, "dead_time": 1e-3}}}
    text = unescape(se.report(given).html)
    found = se.control(given).places[0].axes[0]
    section = text[text.index('id="drives"') :]
    assert f"{found.velocity.modulus:.3g}" in section and "Kp of motor: maximum" in section
    assert section.count("<img") >= 3 and "open loops of motor" in section
    assert "dead time 0.001 s" in text[: text.index('id="drives"')]
    sought = unescape(se.report({**DRIVE, "drives": {"motor": {"Kp": "tuned", "Kv": 1, "dead_time": 1e-3}}}).html)
    assert "Not computed" in sought and "modes without damping" in sought


def test_a_machine_without_drives_has_none(page: str) -> None:
    assert 'id="drives"' not in page
