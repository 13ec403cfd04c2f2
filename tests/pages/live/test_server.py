"""The server of the live page: who is let in, what it writes, and what stays when something is wrong."""

from __future__ import annotations

import gc
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from symoro_elastic.foundation import packages
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.pages.live import following
from symoro_elastic.pages.live.followed_file import FollowedFile, version_of
from symoro_elastic.pages.live.following import Work
from tests.command_line import EXAMPLES, refused
from tests.pages.live.served import LONGEST, Served, serving

for package in ("tornado", "watchfiles", "tomlkit"):
    pytest.importorskip(package)

HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
}


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Served, Path]]:
    """A server of a machine that no test changes."""
    path = tmp_path_factory.mktemp("live") / "planar_2r.toml"
    shutil.copy(EXAMPLES / "planar_2r.toml", path)
    with serving(path) as served:
        yield served, path


@pytest.fixture
def own(tmp_path: Path) -> Iterator[tuple[Served, Path]]:
    """A server of a machine of the test's own."""
    path = tmp_path / "planar_2r.toml"
    shutil.copy(EXAMPLES / "planar_2r.toml", path)
    with serving(path) as served:
        yield served, path


def version(served: Served) -> str:
    with served.watching() as news:
        return str(news.until(lambda parts: "cost" in parts)["file"]["version"])


def edit(served: Served, seen: str, text: str, path: Any = ("parameters", "m1", "value")) -> Any:
    return served.ask("cell", {"version": seen, "path": path, "text": text})


# Who is let in


@pytest.mark.sampled(5)
@pytest.mark.parametrize("where", ["", "picture", "events"])
@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Host": "evil.example"}, 403),  # a name that was bound again to this computer
        ({"Host": ""}, 403),
        ({"Host": "127.0.0.1:1"}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Sec_Fetch_Site": "cross-site"}, 403),
        ({"Sec_Fetch_Site": "same-site"}, 403),
    ],
    ids=str,
)
def test_who_comes_from_elsewhere_is_refused(
    shared: tuple[Served, Path], where: str, headers: dict[str, str], status: int
) -> None:
    assert shared[0].ask(where, **headers).status in (status, 400)  # 400 by tornado itself


@pytest.mark.parametrize("path", ["/", "//", "/wrong/", "/wrong/events", "/%00/", "/../", "/wrong/../../etc/passwd"])
def test_without_the_token_there_is_nothing(shared: tuple[Served, Path], path: str) -> None:
    answer = shared[0].ask(whole=path)
    assert (answer.status, answer.text) == (404, "page not found")


@pytest.mark.parametrize(
    "path", ["planar_2r.toml", "../planar_2r.toml", "%2e%2e/planar_2r.toml", "picture/../../x", "..%2f..%2fetc/passwd"]
)
def test_no_path_of_a_file_is_an_address(shared: tuple[Served, Path], path: str) -> None:
    assert shared[0].ask(path).status == 404
    assert shared[0].ask(f"equations?model={path}").status == 404


def test_every_answer_has_the_headers_that_keep_others_out(shared: tuple[Served, Path]) -> None:
    served, _ = shared
    version(served)
    for path in ("", "picture", "equations?model=inertia_matrix", "nothing", "cell"):
        answer = served.ask(path)
        assert HEADERS.items() <= answer.headers.items(), path
        assert "frame-ancestors" in answer.headers["Content-Security-Policy"] and "Server" not in answer.headers
    policy = served.ask("").headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; script-src 'sha256-") and "unsafe" not in policy
    assert "http" not in policy and "frame-ancestors 'none'" in policy


def test_it_listens_on_this_computer_only(shared: tuple[Served, Path]) -> None:
    assert shared[0].address.startswith("http://127.0.0.1:") and len(shared[0].address.split("/")[3]) >= 32


@pytest.mark.parametrize(
    ("headers", "body", "status"),
    [
        ({"Origin": ""}, {}, 403),
        ({"Origin": "http://evil.example"}, {}, 403),
        ({"Content_Type": "text/plain"}, {}, 403),  # what a form of another page may send
        ({"Content_Type": "application/x-www-form-urlencoded"}, {}, 403),
        ({}, b"{", 400),
        ({}, b"[" * 10_000, 400),
        ({}, [], 400),
        ({}, {"version": 1}, 400),
        ({}, {"version": "x", "path": ["bodies"], "text": "1"}, 400),
        ({}, {"version": "x", "path": ["bodies", 1.5], "text": "1"}, 400),
        ({}, {"version": "x", "path": ["bodies", "arm", "mass"], "text": 1}, 400),
        ({}, {"version": "x", "path": ["bodies", "arm", "mass"], "text": "1", "file": "/etc/passwd"}, 400),
        ({}, {"version": "x", "path": ["bodies", "arm", "mass"], "text": "1"}, 409),
    ],
    ids=str,
)
def test_posts_that_are_none_of_the_page_write_nothing(
    shared: tuple[Served, Path], headers: dict[str, str], body: Any, status: int
) -> None:
    served, path = shared
    before = path.read_bytes()
    assert served.ask("cell", body, **headers).status == status
    assert path.read_bytes() == before and [*path.parent.iterdir()] == [path]


def test_a_long_post_is_refused(shared: tuple[Served, Path]) -> None:
    with suppress(ConnectionError):  # it is read no further
        assert shared[0].ask("cell", {"text": "1" * 20_000}).status in (400, 413)


# What is shown


def test_a_client_is_told_all_parts(shared: tuple[Served, Path]) -> None:
    served, _ = shared
    with served.watching() as news:
        parts = news.until(lambda parts: "cost" in parts)
    assert parts["file"]["name"] == "planar_2r.toml" and parts["checked"]["error"] is None
    assert [table["heading"] for table in parts["cells"]["tables"]][:5] == [
        "gravity",
        "joints",
        "parameters",
        "limits",
        "bodies",
    ]
    assert [row[0] for row in parts["cost"]["rows"]][:2] == ["inverse_dynamics", "direct_dynamics"]
    assert parts["base"]["rows"] and "inertia_matrix" in parts["models"]["titles"]
    assert "<canvas" in served.ask("picture").text
    assert "<math" in served.ask("equations?model=inertia_matrix").text
    assert served.ask("equations?model=nonsense").status == 404


@pytest.mark.thorough
def test_what_an_editor_saves_is_shown_and_a_broken_file_keeps_the_last_good_machine(own: tuple[Served, Path]) -> None:
    served, path = own
    good = path.read_text()
    with served.watching() as one, served.watching() as other:
        first = one.until(lambda parts: "cost" in parts)["file"]["version"]
        picture = served.ask("picture").text
        path.write_text(good.replace('antecedent = "shoulder"', 'antecedent = "sholder"'))
        for client in (one, other):
            said = client.until(lambda parts: parts.get("checked", {}).get("error"))["checked"]["error"]
            assert (said["place"], said["line"]) == ("joint 2 (elbow), antecedent", 9)
            assert said["what"] == "no joint 'sholder'; did you mean 'shoulder'?" and 'name = "elbow"' in said["text"]
            assert client.parts["picture"]["version"] == first
        assert served.ask("picture").text == picture
        path.write_text(good.replace("gravity = [", "gravity = ["[:-1]))
        said = one.until(lambda parts: "TOML" in str(parts["checked"]["error"]))["checked"]["error"]
        assert said["line"] == good[: good.index("gravity =")].count("\n") + 1
        path.unlink()
        one.until(lambda parts: "no such file" in str(parts["checked"]["error"]))
        longer = path.with_name("saved")
        longer.write_text(good.replace("value = 0.4", "value = 0.5"))
        longer.replace(path)  # as editors save
        one.until(lambda parts: not parts["checked"]["error"] and parts["picture"]["version"] != first)
    assert served.ask("picture").text != picture


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["rx90.par", "pendant_arm.urdf"])
def test_files_of_other_formats_are_shown_and_not_edited(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    shutil.copy(EXAMPLES / name, path)
    before = path.read_bytes()
    with serving(path) as served, served.watching() as news:
        parts = news.until(lambda parts: "cost" in parts)
        assert parts["cells"]["tables"] == [] and "shown as it is saved" in parts["cells"]["refused"]
        answer = edit(served, parts["file"]["version"], "1", ["joints", 0, "d"])
    assert answer.status == 422 and "change it in an editor" in answer.text and path.read_bytes() == before


# What is written


@pytest.mark.thorough
def test_a_cell_is_written_with_all_else_as_it_was_and_undone(own: tuple[Served, Path]) -> None:
    served, path = own
    before = path.read_bytes()
    with served.watching() as other:
        seen = other.until(lambda parts: "cost" in parts)["file"]["version"]
        answer = edit(served, seen, "97.5")
        assert answer.status == 200
        lines = [(a, b) for a, b in zip(before.splitlines(), path.read_bytes().splitlines(), strict=True) if a != b]
        assert lines == [(lines[0][0], lines[0][0].replace(b"value = 2.5,", b"value = 97.5,"))]
        told = other.until(lambda parts: parts["file"]["undo"] == 1 and parts["checked"]["version"] != seen)
        assert told["file"]["version"] == json.loads(answer.text)["version"]
        stale = edit(served, seen, "98")
        assert stale.status == 409 and "saved elsewhere since" in stale.text
        after = path.read_bytes()
        assert served.ask("undo", {}).status == 200 and path.read_bytes() == before
        assert served.ask("undo", {}).status == 422
        assert other.until(lambda parts: parts["file"]["redo"] == 1)["file"]["undo"] == 0
        assert served.ask("redo", {}).status == 200 and path.read_bytes() == after
        assert served.ask("redo", {}).status == 422 and served.ask("undo", {}).status == 200
        assert edit(served, seen, "98").status == 200 and served.ask("redo", {}).status == 422, "a change ends what was"


def test_rows_are_added_removed_and_undone(own: tuple[Served, Path]) -> None:
    served, path = own
    before = path.read_bytes()

    def post(how: str, path: list[Any], text: str = "") -> Any:
        return served.ask(how, {"version": version(served), "path": path, "text": text})

    for how, place, text, row in (
        ("add", ["joints", "wrist", "kind"], "passive", b'name = "wrist"'),
        ("add", ["friction", "elbow", "viscous"], "", b"[friction]\nelbow = { viscous = "),
        ("remove", ["joints", 3], "", b""),
    ):
        answer = post(how, place, text)
        assert answer.status == 200 and row in path.read_bytes(), answer
    assert b"wrist" not in path.read_bytes()
    for body in (["joints", "x", "kind"], ["springs", "elbow", "colour"], ["nothing", "elbow", "mass"]):
        assert post("add", body, "wheel").status == 422
    assert post("remove", ["joints", 1]).status == 422, "the tool is on the elbow"
    assert post("remove", ["bodies"]).status == 400 and post("add", ["a", "b"]).status == 400
    for _ in range(3):
        assert served.ask("undo", {}).status == 200
    assert path.read_bytes() == before


@pytest.mark.thorough
def test_what_was_saved_elsewhere_is_neither_overwritten_nor_undone(own: tuple[Served, Path]) -> None:
    served, path = own
    seen = version(served)
    assert edit(served, seen, "97.5").status == 200
    theirs = path.read_bytes() + b"# mine\n"
    path.write_bytes(theirs)
    assert edit(served, seen, "98").status == 409 and served.ask("undo", {}).status == 409
    assert path.read_bytes() == theirs
    path.write_bytes(theirs.removesuffix(b"# mine\n"))
    assert served.ask("undo", {}).status == 200
    path.write_bytes(theirs)
    assert served.ask("redo", {}).status == 409 and path.read_bytes() == theirs


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("1\n[springs]", "not one line"),
        ("x" * 1001, "not one line"),
        ("__import__('os').system('touch harm')", "joint|body|is not|bodies|mass"),
        ("</script><script>alert(1)</script>", ""),
        ("-5", "negative"),
        ("no_such_parameter", "no_such_parameter"),
        ('1, inertia = "9"', ""),
    ],
    ids=lambda x: x[:20],
)
def test_what_is_no_machine_is_not_written(shared: tuple[Served, Path], text: str, said: str) -> None:
    served, path = shared
    before = path.read_bytes()
    answer = edit(served, version(served), text, ["bodies", "elbow", "mass"])
    assert answer.status == 422 and any(word in answer.text for word in said.split("|")), answer
    assert path.read_bytes() == before and [*path.parent.iterdir()] == [path] and not Path("harm").exists()


@pytest.mark.parametrize(
    "path",
    [["name", "x"], ["bodies", "elbow"], ["bodies", "elbow", "inertia"], ["joints", -1, "d"], ["joints", 99, "d"],
     ["bodies", "elbow", "inertia", 9], ["bodies", "elbow", "inertia", -1], ["bodies", "none", "mass"]],
    ids=str,
)  # fmt: skip
def test_only_cells_are_written(shared: tuple[Served, Path], path: list[Any]) -> None:
    served, file = shared
    before = file.read_bytes()
    assert edit(served, version(served), "1", path).status == 422 and file.read_bytes() == before


def test_where_the_file_cannot_be_replaced_it_stays(own: tuple[Served, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    served, path = own
    before = path.read_bytes()
    seen = version(served)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    answer = edit(served, seen, "97.5")
    assert answer.status == 422 and "No space left" in answer.text
    assert path.read_bytes() == before and [*path.parent.iterdir()] == [path]


def test_a_link_in_the_place_of_the_file_is_neither_read_nor_written(own: tuple[Served, Path]) -> None:
    served, path = own
    secret = path.with_name("secret.toml")
    secret.write_bytes(path.read_bytes().replace(b"2.5", b"31337"))
    before = secret.read_bytes()
    with served.watching() as news:
        seen = news.until(lambda parts: "cost" in parts)["file"]["version"]
        path.unlink()
        path.symlink_to(secret)
        error = news.until(lambda parts: parts["checked"]["error"])["checked"]["error"]
        assert error["what"] == "is a link now, which it was not: start again with the file itself"
        for answer in (edit(served, seen, "1"), edit(served, version_of(before), "1"), served.ask("undo", {})):
            assert answer.status == 422
        assert served.ask("equations?model=inertia_matrix").status == 422
        assert "31337" not in json.dumps(news.parts)
    assert secret.read_bytes() == before and path.is_symlink()


def test_a_folder_that_becomes_a_link_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "arm.toml").write_text("secret = 31337")
    (tmp_path / "mine").mkdir()
    file = FollowedFile(str(shutil.copy(EXAMPLES / "planar_2r.toml", tmp_path / "mine" / "arm.toml")))
    assert file.content()
    (tmp_path / "mine").rename(tmp_path / "moved")
    (tmp_path / "mine").symlink_to(tmp_path / "other")
    with pytest.raises(InputError, match="is a link now"):
        file.content()


@pytest.mark.thorough
def test_a_link_that_the_name_is_leads_to_the_file_that_is_written(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    real = Path(shutil.copy(EXAMPLES / "planar_2r.toml", tmp_path / "real" / "arm.toml"))
    (tmp_path / "link.toml").symlink_to(real)
    with serving(tmp_path / "link.toml") as served:
        assert edit(served, version(served), "97.5").status == 200
    assert b"97.5" in real.read_bytes() and (tmp_path / "link.toml").is_symlink()


def test_a_read_only_file_stays(own: tuple[Served, Path]) -> None:
    served, path = own
    before, seen = path.read_bytes(), version(served)
    path.chmod(0o444)
    answer = edit(served, seen, "97.5")
    assert (answer.status, answer.text) == (422, "file: is read-only: make it writable, or choose another name")
    assert path.read_bytes() == before and path.stat().st_mode & 0o777 == 0o444


@pytest.mark.thorough
def test_all_names_of_a_file_are_edited(own: tuple[Served, Path]) -> None:
    served, path = own
    path.with_name("other").hardlink_to(path)
    assert edit(served, version(served), "97.5").status == 200
    assert b"97.5" in path.with_name("other").read_bytes() == path.read_bytes()


def test_a_file_in_latin_1_is_not_edited_and_says_why(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_bytes("# Länge\n".encode("latin-1") + (EXAMPLES / "planar_2r.toml").read_bytes())
    with serving(path) as served, served.watching() as news:
        parts = news.until(lambda parts: parts.get("checked", {}).get("error"))
        said = "the byte 0xe4 is not UTF-8: save the file as UTF-8 text"
        assert (parts["checked"]["error"]["what"], parts["checked"]["error"]["line"]) == (said, 1)
        answer = edit(served, parts["file"]["version"], "1")
    assert (answer.status, answer.text) == (422, f"line 1, column 4: {said}")


# What is logged, and what is kept


def test_no_log_holds_the_address(shared: tuple[Served, Path], caplog: pytest.LogCaptureFixture) -> None:
    served, _ = shared
    token = served.address.split("/")[3]
    for path in ("equations?model=%ff", "nothing", "cell?%ff", "%ff"):
        assert served.ask(path).status in (400, 404, 405)
    assert served.ask("cell", b"{").status == 400
    assert token not in caplog.text


def test_errors_of_the_program_are_logged_without_the_address(
    shared: tuple[Served, Path], caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    served, _ = shared

    def fail() -> str:
        raise RuntimeError("a defect")

    monkeypatch.setattr("symoro_elastic.pages.live.handlers.live_page", fail)
    assert served.ask("").status == 500
    assert "RuntimeError: a defect" in caplog.text and served.address.split("/")[3] not in caplog.text


def test_garbage_is_collected_while_it_is_served(tmp_path: Path) -> None:
    """Commands that end soon leave it, edits would add up."""
    path = shutil.copy(EXAMPLES / "planar_2r.toml", tmp_path)
    before = gc.get_threshold()
    try:
        gc.set_threshold(2_000_000, 50)
        with serving(Path(path)) as served:
            served.ask("")
            assert gc.get_threshold()[0] == 700
        assert gc.get_threshold()[:2] == (2_000_000, 50)
    finally:
        gc.set_threshold(*before)


def test_the_page_is_served_before_computing_has_begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While the process that all are forked from still imports."""
    path, imported = Path(shutil.copy(EXAMPLES / "planar_2r.toml", tmp_path)), threading.Event()
    context = following._context()
    begin = context.Process.start  # type: ignore[attr-defined]

    def wait(process: Any) -> None:
        assert imported.wait(LONGEST)
        begin(process)

    monkeypatch.setattr(context.Process, "start", wait)  # type: ignore[attr-defined]
    with serving(path, Work) as served, served.watching() as news:
        assert "<script" in served.ask("").text and news.until(lambda parts: "file" in parts).keys() == {"file"}
        imported.set()
        assert news.until(lambda parts: "checked" in parts)["checked"]["error"] is None


def written_until(call: int, path: Path) -> bool:
    """Write a cell in a process killed before the n-th function that it calls of files; whether all was written."""
    child = os.fork()
    if child:
        return os.waitpid(child, 0)[1] == 0
    left = iter(range(call))

    def count(_frame: Any, event: str, called: Any) -> None:
        of_files = event == "c_call" and (
            called.__module__ in ("posix", "io", "_io") or hasattr(called.__self__, "close")
        )
        if of_files and next(left, None) is None:
            os.kill(os.getpid(), signal.SIGKILL)

    async def no_fault(_text: str) -> str:
        sys.setprofile(count)
        return ""

    file = FollowedFile(str(path))
    with suppress(StopIteration):
        file.edit("cell", version_of(file.content()), ["parameters", "m1", "value"], "97.5", no_fault).send(None)
    sys.setprofile(None)
    os._exit(0)


def killed_everywhere(path: Path) -> None:
    """Kill the writing of a cell before each function of files; wherever it is, the file is the one before or after."""
    before = path.read_bytes()
    after = before.replace(b"value = 2.5,", b"value = 97.5,")
    found, call = [], 0
    while not written_until(call, path):
        found.append(path.read_bytes())
        path.write_bytes(before)
        call += 1
    assert len(found) > 10 and path.read_bytes() == after and [*path.parent.iterdir()] == [path]
    replaced = found.index(after)
    assert found == [before] * replaced + [after] * (len(found) - replaced)


@pytest.mark.thorough
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs a POSIX system")
def test_a_kill_in_the_middle_of_writing_loses_nothing(tmp_path: Path) -> None:
    """In a process of its own, which is small: those that are killed are copies of it."""
    path = shutil.copy(EXAMPLES / "planar_2r.toml", tmp_path)
    code = f"import pathlib, {__name__} as own; own.killed_everywhere(pathlib.Path({str(path)!r}))"
    subprocess.run([sys.executable, "-c", code], cwd=EXAMPLES.parent, check=True)


# The command


def test_what_cannot_be_served_is_said_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "none.toml: file: no such file" in refused("live", tmp_path / "none.toml")
    assert "unknown format '.docx'" in refused("live", "machine.docx")
    with serving(EXAMPLES / "planar_2r.toml") as served:
        taken = served.host.partition(":")[2]
        assert f"--port: {taken} cannot be had" in refused("live", EXAMPLES / "planar_2r.toml", "--port", taken)

    def missing(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name.partition(".")[0])

    monkeypatch.setattr(packages, "import_module", missing)
    assert "serving a page needs tornado: pip install 'symoro-elastic[live]'" in refused("live", EXAMPLES / "rx90.par")
