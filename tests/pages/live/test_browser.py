"""The live page as its command serves it, in processes of its own, and in Chromium.

The command is started once; pages whose subject is no process are served in a thread.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from symoro_elastic.pages.live.followed_file import version_of
from tests.benchmarks.pages import FLAGS, NAMELESS
from tests.command_line import EXAMPLES
from tests.pages.live.served import Served, serving

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


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    return Path(shutil.copy(EXAMPLES / "planar_2r.toml", tmp_path))


@pytest.fixture(scope="module")
def command(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Served, Path]]:
    """`symoro-elastic live PATH`; it ends by Ctrl+C, with nothing on standard error."""
    path = Path(shutil.copy(EXAMPLES / "planar_2r.toml", tmp_path_factory.mktemp("live")))
    line = [sys.executable, "-m", "symoro_elastic", "live", path.name]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(
        line, cwd=path.parent, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509 (else ignored in the background)
    ) as process:  # fmt: skip
        try:
            assert process.stdout and process.stderr
            yield Served(process.stdout.readline().strip()), path
            process.send_signal(signal.SIGINT)
            assert (process.wait(20), process.stderr.read()) == (0, "")
        finally:
            process.kill()


@pytest.fixture
def commanded(command: tuple[Served, Path]) -> tuple[Served, Path]:
    """The page of the command, of the machine as it is in the examples."""
    served, path = command
    content = (EXAMPLES / "planar_2r.toml").read_bytes()
    path.write_bytes(content)
    with served.watching() as news:
        news.until(lambda parts: parts.get("cost", {}).get("version") == version_of(content))
    return command


def test_slow_work_is_dropped_when_the_file_is_saved_again(commanded: tuple[Served, Path]) -> None:
    """A chain of 100 joints keeps its process busy for seconds; the next save is shown before that would end."""
    served, path = commanded
    small = path.read_text()
    rows = [
        f'  {{ name = "j{k}", kind = "elastic", sigma = 0, theta = "q{k}", d = 0.1, alpha = "pi/2" }},'
        for k in range(100)
    ]
    bodies = [f"j{k} = {{ mass = 1, center_of_mass = [0.1, 0, 0], inertia = [1, 1, 1] }}" for k in range(100)]
    springs = [f"j{k} = {{ stiffness = 1e5 }}" for k in range(100)]
    with served.watching() as news:
        path.write_text("\n".join(["joints = [", *rows, "]", "[bodies]", *bodies, "[springs]", *springs]))
        chain = version_of(path.read_bytes())
        shown = news.until(lambda parts: parts.get("picture", {}).get("version") == chain)
        assert not shown["picture"]["modes"] and shown["base"]["version"] != chain
        path.write_text(f"{small}# again\n")
        now = version_of(path.read_bytes())
        parts = news.until(lambda parts: parts["cost"]["version"] in (now, chain) and parts["file"]["version"] == now)
        assert all(parts[name]["version"] == now for name in ("picture", "base", "cost", "checked"))


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


def test_two_tabs_edit_undo_and_refuse_each_other(browser: Any, machine: Path) -> None:
    before = machine.read_text()
    with serving(machine) as served:
        one, other = Tab(browser, served.address), Tab(browser, served.address)
        shown = one.shown()
        one.cell("parameters, m1, value").fill("97.5")
        one.cell("parameters, m1, value").press("Enter")
        for tab in (one, other):
            tab.wait_for_another(shown)
            assert tab.cell("parameters, m1, value").input_value() == "97.5"
        assert machine.read_text() == before.replace("value = 2.5,", "value = 97.5,")
        other.cell("parameters, l1, value").focus()
        other.cell("parameters, l1, value").type("9")  # being typed while an editor saves
        shown = other.shown()
        theirs = machine.read_text() + "# theirs\n"
        machine.write_text(theirs)
        other.wait_for_another(shown)
        assert other.cell("parameters, l1, value").input_value().count("9") == 1
        other.cell("parameters, l1, value").press("Enter")
        other.page.wait_for_selector("#refused:has-text('saved elsewhere since')")
        assert machine.read_text() == theirs
        shown = other.shown()
        other.cell("parameters, l1, value").press("Enter")  # having seen it
        other.wait_for_another(shown)
        assert re.search(r'l1 += \{ value = \S*9\S*, +unit = "m" \}\n', machine.read_text())
        assert machine.read_text().endswith("# theirs\n")
        ours = machine.read_text()
        for name, wanted in (("Undo (2)", theirs), ("Redo (1)", ours), ("Undo (2)", theirs)):
            shown = one.shown()
            one.page.click(f"text={name}")
            one.wait_for_another(shown)
            assert machine.read_text() == wanted
        one.page.click("text=Undo (1)")
        one.page.wait_for_selector("#refused:has-text('saved elsewhere since')")
        one.cell("bodies, elbow, mass").fill("-1")
        one.cell("bodies, elbow, mass").press("Enter")
        one.page.wait_for_selector("#refused:has-text('is negative')")
        assert one.cell("bodies, elbow, mass").get_attribute("aria-invalid") == "true"
        assert machine.read_text() == theirs and [*one.wrong, *other.wrong] == []


def test_a_saved_file_is_shown_as_the_picture_before_was_seen(browser: Any, commanded: tuple[Served, Path]) -> None:
    served, machine = commanded
    with launched(browser.browser_type) as with_space:
        tab = Tab(with_space, served.address)
        picture = tab.page.frame_locator("#picture iframe")
        still = picture.locator("canvas").get_attribute("data-q")
        picture.locator("input[type=range]").first.press("ArrowRight")
        picture.get_by_role("button", name="Top").click()
        was = picture.locator("canvas").evaluate("(x) => [x.dataset.q, x.dataset.camera]")
        shown = tab.shown()
        machine.write_text(machine.read_text().replace("value = 2.5", "value = 2.6"))
        tab.wait_for_another(shown)
        now = picture.locator("canvas").evaluate("(x) => [x.dataset.q, x.dataset.camera]")
        assert now[0] == was[0] != still
        assert [*map(float, now[1].split())] == pytest.approx([*map(float, was[1].split())], abs=1e-6)
        machine.write_text(machine.read_text().replace('antecedent = "shoulder"', 'antecedent = "sholder"'))
        tab.page.wait_for_selector(".said.error:has-text('line 9, joint 2 (elbow), antecedent:')")
        assert picture.locator("canvas").evaluate("(x) => x.dataset.camera") == now[1] and tab.wrong == []


def test_a_page_of_another_site_reads_and_writes_nothing(browser: Any, machine: Path) -> None:
    before = machine.read_bytes()

    class Foreign(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><title>foreign</title>")

        def log_message(self, *_: object) -> None:
            pass

    with serving(machine) as served, HTTPServer(("127.0.0.1", 0), Foreign) as foreign:
        Thread(target=foreign.serve_forever, daemon=True).start()
        with served.watching() as news:
            seen = news.until(lambda parts: "cost" in parts)["file"]["version"]
        page = browser.new_context().new_page()
        for host in ("127.0.0.1", "localhost"):
            page.goto(f"http://{host}:{foreign.server_port}/")
            assert (
                page.evaluate(
                    """async ([address, version]) => {
                  const body = JSON.stringify({ version, path: ["bodies", "elbow", "mass"], text: "1" }), found = [];
                  for (const [mode, type] of [["cors", "application/json"], ["no-cors", "text/plain"]])
                    for (const where of ["cell", "undo", "redo"])
                      found.push(await fetch(address + where,
                          { method: "POST", mode, body, headers: { "Content-Type": type } })
                        .then((x) => x.type, () => "refused"));
                  for (const where of ["", "events", "picture"])
                    found.push(await fetch(address + where).then(() => "read", () => "refused"));
                  return found; }""",
                    [served.address, seen],
                )
                == ["refused"] * 9
            )
            framed = page.evaluate(
                """async (address) => { const frame = document.createElement("iframe"); frame.src = address;
                  const loaded = new Promise((done) => frame.addEventListener("load", done));
                  document.body.append(frame); await loaded;
                  try { return frame.contentWindow.document.title; } catch { return "closed"; } }""",
                served.address,
            )
            assert framed == "closed"
            assert "planar_2r" not in page.frames[-1].content()
        foreign.shutdown()
    assert machine.read_bytes() == before


def test_names_are_inert_and_nothing_is_wider_than_the_window(browser: Any, machine: Path) -> None:
    listed = ", ".join(json.dumps(name) for name in NAMES)
    text = machine.read_text().replace("gravity =", f"notes = [{listed}]\ngravity =")
    good = text.replace('"tip"', f'"{"a" * 60}"').replace("I2", "D" + "1" * 50)
    machine.write_text(good)
    with serving(machine) as served:
        for width, scheme in ((1400, "light"), (390, "dark"), (1400, "dark"), (390, "light")):
            tab = Tab(browser, served.address, width, scheme)
            page, measured = tab.page, "document.documentElement.scrollWidth"
            for name in ("file", "base", "cost", "equations"):
                page.click(f"#tab-{name}")
                if name == "equations":
                    page.frame_locator("#equations").locator("math").first.wait_for()
                assert page.evaluate(measured) <= width and page.evaluate(NAMELESS) == []
            machine.write_text(good.replace('"elbow",    kind', f"{json.dumps(NAMES[0])}, kind", 1))
            page.wait_for_selector(".said.error:has-text('alert(1)')")
            assert page.evaluate(measured) <= width
            machine.write_text(f"{good}# {NAMES[3]}\n[{json.dumps(NAMES[4])}]\n")
            page.wait_for_selector(".said.error:has-text('onerror')")
            machine.write_text(good)
            page.wait_for_selector("#said:empty", state="attached")
            assert tab.wrong == []
            tab.context.close()


def test_the_keyboard_reaches_everything(browser: Any, machine: Path) -> None:
    with serving(machine) as served:
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
        expected = ["gravity, gravity, gravity 1", "gravity, gravity, gravity 2", "gravity, gravity, gravity 3"]
        assert reached[:4] == [*expected, "joints, shoulder, antecedent"] and len({*reached}) == 8
        first = page.locator('input[aria-label="joints, shoulder, antecedent"]')
        first.fill("nonsense")
        first.press("Escape")
        assert first.input_value() == "0"


def test_rows_are_added_and_removed_and_kinds_chosen(browser: Any, machine: Path) -> None:
    """By hand: friction comes, limits go, a motor becomes passive, friction goes; undo brings back all."""
    before = machine.read_text()
    with serving(machine) as served:
        tab = Tab(browser, served.address)
        page = tab.page
        assert page.locator("th[title]", has_text="mass, kg").get_attribute("title")
        page.get_by_label("row of friction").select_option("elbow")
        for act in (
            lambda: page.get_by_label("Add to friction").click(),
            lambda: page.get_by_label("Remove elbow of limits").click(),
            lambda: page.get_by_label("joints, elbow, kind").select_option("passive"),
            lambda: page.get_by_label("Remove elbow of friction").click(),
        ):
            shown = tab.shown()
            act()
            tab.wait_for_another(shown)
        assert "friction" not in machine.read_text() and 'kind = "passive"' in machine.read_text()
        for k in (4, 3, 2, 1):
            page.click(f"text=Undo ({k})")
        page.wait_for_selector("button:disabled:has-text('Undo')")
        assert machine.read_text() == before and tab.wrong == []
