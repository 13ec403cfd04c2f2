"""The live page as its command serves it, in processes of its own, and in Chromium."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread, Timer
from typing import Any

import pytest

from tests.benchmarks.pages import FLAGS, NAMELESS
from tests.command_line import EXAMPLES
from tests.pages.live.served import Served

pytestmark = pytest.mark.thorough
for package in ("tornado", "watchfiles", "tomlkit"):
    pytest.importorskip(package)

ROOT = Path(__file__).parents[3]
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
NAMES = (
    "</script><script>alert(1)</script>",
    "$x_1$",
    "a \"quoted\" 'one'",
    "\u202eright to left",
    "<img src=x onerror=alert(1)>",
)


@contextmanager
def command(path: Path) -> Iterator[tuple[Served, subprocess.Popen[str]]]:
    """`symoro-elastic live PATH`; it ends by Ctrl+C, with nothing on standard error."""
    line = [sys.executable, "-m", "symoro_elastic", "live", path.name]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        line, cwd=path.parent, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        try:
            assert process.stdout and process.stderr
            yield Served(process.stdout.readline().strip()), process
            process.send_signal(signal.SIGINT)
            assert (process.wait(20), process.stderr.read()) == (0, "")
        finally:
            process.kill()


@pytest.fixture
def two_axis(tmp_path: Path) -> Path:
    return Path(shutil.copy(EXAMPLES / "two_axis.toml", tmp_path))


def test_slow_work_is_dropped_when_the_file_is_saved_again(tmp_path: Path) -> None:
    """A chain of 60 joints keeps its process busy for seconds; the next save is shown before that would end."""
    rows = [
        f'  {{ name = "j{k}", kind = "elastic", sigma = 0, theta = "q{k}", d = 0.1, alpha = "pi/2" }},'
        for k in range(60)
    ]
    bodies = [f"j{k} = {{ mass = 1, center_of_mass = [0.1, 0, 0], inertia = [1, 1, 1] }}" for k in range(60)]
    springs = [f"j{k} = {{ stiffness = 1e5 }}" for k in range(60)]
    path = tmp_path / "chain.toml"
    path.write_text("\n".join(["joints = [", *rows, "]", "[bodies]", *bodies, "[springs]", *springs]))
    small = (EXAMPLES / "planar_2r.toml").read_text()
    with command(path) as (served, _), served.watching() as news:
        first = news.until(lambda parts: "picture" in parts)["picture"]
        assert not first["modes"] and "base" not in news.parts
        path.write_text(small)
        parts = news.until(lambda parts: "cost" in parts and parts["cost"]["version"] == parts["file"]["version"])
        assert parts["file"]["version"] != first["version"]
        assert all(
            parts[name]["version"] == parts["file"]["version"] for name in ("picture", "base", "cost", "checked")
        )


def test_a_kill_in_the_middle_of_writing_loses_nothing(two_axis: Path) -> None:
    """Cells are written as fast as they can be; after each kill the file is one of the versions that were sent."""
    before = two_axis.read_text()
    masses = {95.0}
    for k in range(2):
        with contextlib.suppress(AssertionError, ConnectionError), command(two_axis) as (served, process):
            with served.watching() as news:
                seen = news.until(lambda parts: "picture" in parts)["file"]["version"]
            begun = time.monotonic()
            for mass in range(100 + 100 * k, 200 + 100 * k):
                masses.add(float(mass))
                body = {"version": seen, "path": ["bodies", "ram", "mass"], "text": str(mass)}
                if time.monotonic() - begun > 0.3 + 0.17 * k:
                    Timer(0.01 + 0.02 * k, process.kill).start()
                seen = json.loads(served.ask("cell", body).text)["version"]
        after = two_axis.read_text()
        mass = float(tomllib.loads(after)["bodies"]["ram"]["mass"])
        assert mass in masses and mass > 95
        assert re.sub(r"(ram +=.*mass = )[\d.]+", r"\g<1>95", after) == before


# Chromium


@contextmanager
def launched(chromium: Any, *flags: str) -> Iterator[Any]:
    started = chromium.launch(executable_path=CHROMIUM, args=[*FLAGS, *flags])
    yield started
    started.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Without WebGL, which takes long without a GPU: still pictures."""
    playwright = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("no Chromium: install it, or give its path in the variable CHROMIUM")
    with playwright.sync_playwright() as running, launched(running.chromium, "--disable-3d-apis") as started:
        yield started


ALLOWED = ("WebGL", "status of 409", "status of 422")
"""What Chromium says where there is no WebGL, or a GPU is waited for; and of an edit that is refused."""


class Tab:
    """A page in a window, and what went wrong in it."""

    def __init__(self, browser: Any, address: str, width: int = 1400, scheme: str = "light") -> None:
        self.context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
        self.page = self.context.new_page()
        self.page.set_default_timeout(15_000)
        self.wrong: list[str] = []
        self.page.on(
            "console", lambda said: None if any(x in said.text for x in ALLOWED) else self.wrong.append(said.text)
        )
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.page.on(
            "request",
            lambda asked: self.wrong.append(asked.url) if not asked.url.startswith((address, "data:")) else None,
        )
        self.page.on("dialog", lambda dialog: (self.wrong.append(dialog.message), dialog.dismiss()))
        self.page.goto(address)
        self.page.wait_for_selector("body[data-modes=true]")

    def cell(self, name: str) -> Any:
        return self.page.locator(f'input[aria-label="{name}"]')

    def shown(self) -> str:
        return str(self.page.get_attribute("body", "data-shown"))

    def wait_for_another(self, before: str) -> None:
        self.page.wait_for_selector(f'body[data-modes=true]:not([data-shown="{before}"])')


def test_two_tabs_edit_undo_and_refuse_each_other(browser: Any, two_axis: Path) -> None:
    before = two_axis.read_text()
    with command(two_axis) as (served, _):
        one, other = Tab(browser, served.address), Tab(browser, served.address)
        shown = one.shown()
        one.cell("bodies, ram, mass").fill("97.5")
        one.cell("bodies, ram, mass").press("Enter")
        for tab in (one, other):
            tab.wait_for_another(shown)
            assert tab.cell("bodies, ram, mass").input_value() == "97.5"
        assert two_axis.read_text() == before.replace("mass = 95,", "mass = 97.5,")
        other.cell("springs, ram, stiffness").focus()
        other.cell("springs, ram, stiffness").type("9")  # being typed while an editor saves
        shown = other.shown()
        theirs = two_axis.read_text() + "# theirs\n"
        two_axis.write_text(theirs)
        other.wait_for_another(shown)
        assert other.cell("springs, ram, stiffness").input_value().count("9") == 1
        other.cell("springs, ram, stiffness").press("Enter")
        other.page.wait_for_selector("#refused:has-text('saved elsewhere since')")
        assert two_axis.read_text() == theirs
        shown = other.shown()
        other.cell("springs, ram, stiffness").press("Enter")  # having seen it
        other.wait_for_another(shown)
        assert re.search(r"ram += \{ stiffness = \S*9\S* \}  # est\.", two_axis.read_text())
        assert two_axis.read_text().endswith("# theirs\n")
        shown = one.shown()
        one.page.click("text=Undo (2)")
        one.wait_for_another(shown)
        assert two_axis.read_text() == theirs
        one.page.click("text=Undo (1)")
        one.page.wait_for_selector("#refused:has-text('saved elsewhere since')")
        one.cell("bodies, ram, mass").fill("-1")
        one.cell("bodies, ram, mass").press("Enter")
        one.page.wait_for_selector("#refused:has-text('is negative')")
        assert one.cell("bodies, ram, mass").get_attribute("aria-invalid") == "true"
        assert two_axis.read_text() == theirs and [*one.wrong, *other.wrong] == []


def test_a_saved_file_is_shown_as_the_picture_before_was_seen(browser: Any, two_axis: Path) -> None:
    with command(two_axis) as (served, _), launched(browser.browser_type) as with_space:
        tab = Tab(with_space, served.address)
        picture = tab.page.frame_locator("#picture iframe")
        picture.locator("input[type=range]").first.press("ArrowRight")
        picture.get_by_role("button", name="Top").click()
        was = picture.locator("canvas").evaluate("(x) => [x.dataset.q, x.dataset.camera]")
        shown = tab.shown()
        two_axis.write_text(two_axis.read_text().replace("mass = 2500", "mass = 2600"))
        tab.wait_for_another(shown)
        now = picture.locator("canvas").evaluate("(x) => [x.dataset.q, x.dataset.camera]")
        assert now[0].split()[4] == was[0].split()[4] == "0.00200000000000"
        assert [*map(float, now[1].split())] == pytest.approx([*map(float, was[1].split())], abs=1e-6)
        two_axis.write_text(two_axis.read_text().replace('antecedent = "bed_y"', 'antecedent = "bedy"'))
        tab.page.wait_for_selector(".said.error:has-text('line 20, joint 3 (bed_x), antecedent:')")
        assert picture.locator("canvas").evaluate("(x) => x.dataset.camera") == now[1] and tab.wrong == []


def test_a_page_of_another_site_reads_and_writes_nothing(browser: Any, two_axis: Path) -> None:
    before = two_axis.read_bytes()

    class Foreign(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><title>foreign</title>")

        def log_message(self, *_: object) -> None:
            pass

    with command(two_axis) as (served, _), HTTPServer(("127.0.0.1", 0), Foreign) as foreign:
        Thread(target=foreign.serve_forever, daemon=True).start()
        with served.watching() as news:
            seen = news.until(lambda parts: "cost" in parts)["file"]["version"]
        page = browser.new_context().new_page()
        for host in ("127.0.0.1", "localhost"):
            page.goto(f"http://{host}:{foreign.server_port}/")
            assert (
                page.evaluate(
                    """async ([address, version]) => {
                  const body = JSON.stringify({ version, path: ["bodies", "ram", "mass"], text: "1" }), found = [];
                  for (const [mode, type] of [["cors", "application/json"], ["no-cors", "text/plain"]])
                    for (const where of ["cell", "undo"])
                      found.push(await fetch(address + where,
                          { method: "POST", mode, body, headers: { "Content-Type": type } })
                        .then((x) => x.type, () => "refused"));
                  for (const where of ["", "events", "picture"])
                    found.push(await fetch(address + where).then(() => "read", () => "refused"));
                  return found; }""",
                    [served.address, seen],
                )
                == ["refused"] * 7
            )
            framed = page.evaluate(
                """async (address) => { const frame = document.createElement("iframe"); frame.src = address;
                  const loaded = new Promise((done) => frame.addEventListener("load", done));
                  document.body.append(frame); await loaded;
                  try { return frame.contentWindow.document.title; } catch { return "closed"; } }""",
                served.address,
            )
            assert framed == "closed"
            assert "two_axis" not in page.frames[-1].content()
        foreign.shutdown()
    assert two_axis.read_bytes() == before


def test_names_are_inert_and_nothing_is_wider_than_the_window(browser: Any, two_axis: Path) -> None:
    listed = ", ".join(json.dumps(name) for name in NAMES)
    text = two_axis.read_text().replace("notes = [", f"notes = [{listed},")
    good = text.replace("sensor_head", "a" * 60).replace("D13", "D" + "1" * 50)
    two_axis.write_text(good)
    with command(two_axis) as (served, _):
        for width, scheme in ((1400, "light"), (390, "dark"), (1400, "dark"), (390, "light")):
            tab = Tab(browser, served.address, width, scheme)
            page, measured = tab.page, "document.documentElement.scrollWidth"
            for name in ("file", "base", "cost", "equations"):
                page.click(f"#tab-{name}")
                if name == "equations":
                    page.frame_locator("#equations").locator("math").first.wait_for()
                assert page.evaluate(measured) <= width and page.evaluate(NAMELESS) == []
            two_axis.write_text(good.replace('"bed_y",     kind', f"{json.dumps(NAMES[0])},     kind", 1))
            page.wait_for_selector(".said.error:has-text('alert(1)')")
            assert page.evaluate(measured) <= width
            two_axis.write_text(f"{good}# {NAMES[3]}\n[{json.dumps(NAMES[4])}]\n")
            page.wait_for_selector(".said.error:has-text('onerror')")
            two_axis.write_text(good)
            page.wait_for_selector("#said:empty", state="attached")
            assert tab.wrong == []
            tab.context.close()


def test_the_keyboard_reaches_everything(browser: Any, two_axis: Path) -> None:
    with command(two_axis) as (served, _):
        page = Tab(browser, served.address).page
        page.locator("#tab-file").focus()
        for name in ("base", "cost", "equations", "file"):
            page.keyboard.press("ArrowRight")
            assert page.evaluate("document.activeElement.id") == f"tab-{name}"
            assert page.locator(f"#panel-{name}").is_visible()
        page.keyboard.press("Tab")
        reached = []
        for _ in range(8):
            reached.append(page.evaluate("document.activeElement.getAttribute('aria-label')"))
            assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
            page.keyboard.press("Tab")
        assert reached[:2] == ["joints, bed_yaw, antecedent", "joints, bed_yaw, kind"] and len({*reached}) == 8
        first = page.locator('input[aria-label="joints, bed_yaw, kind"]')
        first.fill("nonsense")
        first.press("Escape")
        assert first.input_value() == "elastic"
