"""Pages of machines in Chromium: no error, no request, names where the frames are, nothing wider than the window.

`python -m tests.benchmarks.pages FOLDER [NAME ...]` writes the pages and what they look like to a folder; look at them.
Needs playwright, and a Chromium that it finds, or whose path is in the variable CHROMIUM.
"""

from __future__ import annotations

import os
import shutil
import sys
import sysconfig
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.formats import FORMATS, read_machine
from symoro_elastic.pages.drawing.figure import placements_of
from tests.command_line import EXAMPLES, ended

FLAGS = (
    *("--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    "--disable-background-networking",
)
SCHEMES: tuple[Any, ...] = ("light", "dark")
SIZES = {"wide": (1400, 900), "phone": (390, 844)}
MACHINES: dict[str, tuple[object, ...]] = {
    "two_axis": (EXAMPLES / "two_axis.toml", "--scene", EXAMPLES / "scenes" / "two_axis_move.toml"),
    "gantry": (EXAMPLES / "gantry.toml",),
    "palletizer": (EXAMPLES / "palletizer.toml",),
    "rx90": (EXAMPLES / "rx90.par", "--at", "th2=0.6", "--at", "th3=0.9"),
    "floating_arm": (EXAMPLES / "floating_arm.toml", "--at", "shoulder=0.5"),
}
ROBOTS = Path(sysconfig.get_path("purelib")) / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
URDF = {
    "panda": ROBOTS / "panda_description" / "urdf" / "panda.urdf",
    "talos": ROBOTS / "talos_data" / "robots" / "talos_reduced.urdf",
    "hyq": ROBOTS / "hyq_description" / "robots" / "hyq_no_sensors.urdf",
}
READ = {suffix for form in FORMATS for suffix in form.suffixes}
MACHINES |= {name: (path,) for name, path in URDF.items() if path.exists() and path.suffix in READ}
NAMELESS = """() => [...document.querySelectorAll("button, input, select, canvas, svg[role=img]")].filter((x) =>
  x.checkVisibility() && !(x.getAttribute("aria-label") || x.textContent.trim() || x.labels?.[0]?.textContent.trim())
).map((x) => x.outerHTML.slice(0, 90))"""
DOTS = """() => [...document.querySelectorAll("#labels g")].map((g) => [Number(g.dataset.frame),
  Number(g.querySelector("circle").getAttribute("cx")), Number(g.querySelector("circle").getAttribute("cy"))])"""
TEXTS = """() => [...document.querySelectorAll("#labels g:not(.hidden) text")].map((t) => {
  const b = t.getBBox(); return [b.x, b.y, b.x + b.width, b.y + b.height]; })"""


@dataclass
class Opened:
    """A page in a window, and what went wrong there."""

    name: str
    page: Any
    wrong: list[str]

    def expect(self, holds: bool, what: str) -> None:
        if not holds:
            self.wrong.append(what)


def listened(name: str, page: Any, file: Path, allowed: tuple[str, ...]) -> Opened:
    """Open a file; errors of scripts, and requests of what does not begin as is `allowed`, are wrong."""
    opened = Opened(name, page, [])
    page.on("console", lambda m: opened.expect(m.type != "error", f"console: {m.text[:200]}"))
    page.on("pageerror", lambda error: opened.wrong.append(f"script: {str(error)[:200]}"))
    page.on("request", lambda r: opened.expect(r.url.startswith(allowed), f"request: {r.url[:80]}"))
    page.goto(file.as_uri(), wait_until="load")
    return opened


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser, of the system where there is one."""
    from playwright.sync_api import sync_playwright

    path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        yield browser
        browser.close()


def windows(browser: Any, sizes: Mapping[str, tuple[int, int]] = SIZES) -> Iterator[tuple[str, str, Any]]:
    """Sizes and schemes by name, each with a window of its own."""
    for size, (width, height) in sizes.items():
        for scheme in SCHEMES:
            context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
            yield size, scheme, context
            context.close()


def check_names(opened: Opened, machine: Path) -> float:
    """Distance, px, of the farthest dot from the projection of its frame; texts must not touch."""
    opened.page.wait_for_timeout(150)
    numbers = [opened.page.locator("#space").get_attribute(f"data-{key}") for key in ("camera", "q")]
    camera, q = (np.array([float(x) for x in (text or "").split()]) for text in numbers)
    T = placements_of(read_machine(str(machine))[0]).at(q)
    seen = (camera.reshape(4, 4) @ np.concatenate([T[:, :3, 3], np.ones((len(T), 1))], axis=1).T).T
    box = opened.page.locator("#space").bounding_box()
    points = np.stack([(1 + seen[:, 0]) * box["width"] / 2, (1 - seen[:, 1]) * box["height"] / 2], axis=1)
    dots = opened.page.evaluate(DOTS)
    far = max(float(np.hypot(*(points[int(j)] - (x, y)))) for j, x, y in dots)
    opened.expect(far < 1, f"a name is {far:.2f} px from its frame")
    texts = opened.page.evaluate(TEXTS)
    touching = [
        (a, b)
        for k, a in enumerate(texts)
        for b in texts[:k]
        if a[0] < b[2] and b[0] < a[2] and a[1] + 2 < b[3] and b[1] + 2 < a[3]
    ]
    opened.expect(not touching, f"{len(touching)} names lie upon others")
    return far


def check_page(opened: Opened, machine: Path, folder: Path, size: str) -> Iterator[float]:
    """Use every control once; take pictures."""
    page, tall = opened.page, size.startswith("phone")
    wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    opened.expect(wide <= 0, f"{wide} px wider than the window")
    nameless = page.evaluate(NAMELESS)
    opened.expect(not nameless, f"without a name: {nameless}")
    yield check_names(opened, machine)
    page.screenshot(path=folder / f"{opened.name}.{size}.png", full_page=tall)
    slider = page.locator("#sections input[type=range]").first
    if slider.count():
        slider.focus()
        for _ in range(30):
            page.keyboard.press("ArrowRight")
    page.locator("#space").focus()
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.keyboard.press(key)
    yield check_names(opened, machine)
    page.screenshot(path=folder / f"{opened.name}.{size}.moved.png")
    modes = page.locator(".modes button")
    if modes.count():
        modes.first.click()
        page.wait_for_timeout(330)
        page.screenshot(path=folder / f"{opened.name}.{size}.mode.png", full_page=tall)
        modes.first.click()
    if page.get_by_role("button", name="Play").count():
        page.get_by_role("button", name="Play").first.click()
        page.wait_for_timeout(1200)
        width, height = (page.locator("#space").bounding_box()[side] for side in ("width", "height"))
        seen = [0 < x < width and 0 < y < height for _, x, y in page.evaluate(DOTS)]
        opened.expect(all(seen), f"{seen.count(False)} frames are outside of the window in the motion")
        page.screenshot(path=folder / f"{opened.name}.{size}.motion.png", full_page=tall)
    page.get_by_role("button", name="Top").click()
    check_tools(opened)


def check_tools(opened: Opened) -> None:
    """Measure between two frames, record a second, and open the page again where its address says it stands."""
    page = opened.page
    selects = page.locator("select[aria-label^=Measure]")
    if selects.count():
        for k in range(2):
            selects.nth(k).select_option(index=k + 1)
        opened.expect("mm" in page.locator(".measured").inner_text(), "nothing is measured")
    record = page.get_by_role("button", name="Record what moves")
    if record.count():
        record.click()
        page.locator("#space").focus()
        for _ in range(8):
            page.keyboard.press("ArrowLeft")
            page.wait_for_timeout(60)
        with page.expect_download() as saved:
            page.get_by_role("button", name="End").click()
        opened.expect(Path(saved.value.path()).stat().st_size > 5000, "the video is empty")
    page.wait_for_timeout(400)
    camera = page.locator("#space").get_attribute("data-camera")
    page.reload()
    page.wait_for_selector("#space[data-camera]", state="attached")
    page.wait_for_timeout(200)
    again = page.locator("#space").get_attribute("data-camera")
    far = max(abs(float(x) - float(y)) for x, y in zip(camera.split(), again.split(), strict=True))
    opened.expect(far < 1e-3, f"the address brings another view: {far:.2g}")


def main(folder: Path, names: list[str]) -> int:
    """Write and open the pages; 1 where something is wrong."""
    folder.mkdir(parents=True, exist_ok=True)
    failed = 0
    with chromium() as browser:
        for name in names or MACHINES:
            machine, *options = MACHINES[name]
            file = (folder / f"{name}.html").resolve()
            made = ended("view", machine, "--out", file, "--force", *options)
            if made.code:
                print(f"{name}: {made.err}")
                return 1
            for size, scheme, context in windows(browser):
                opened = listened(name, context.new_page(), file, (file.as_uri(), "blob:"))
                opened.page.wait_for_selector("#space[data-camera]", state="attached")
                far = list(check_page(opened, Path(str(machine)), folder, f"{size}.{scheme}"))
                told = f"{file.stat().st_size / 1000:.0f} kB, names within {max(far):.2g} px"
                print(f"{name:14} {size:6} {scheme:6} {told}", *opened.wrong, sep="; ")
                failed += len(opened.wrong)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
