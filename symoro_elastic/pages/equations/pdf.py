"""Compile a LaTeX document to PDF."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.foundation.output_files import fill_folder, temporary_folder, write_file

INSTEAD = "use --format latex or html"
QUIET = ("-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape")
# How often each must run: once to find the headings, once to make room for the table of contents,
# once for its page numbers. (latexmk sometimes takes the second for the last: it compares dates.)
ENGINES: dict[str, tuple[tuple[str, ...], int]] = {
    "pdflatex": (QUIET, 3),
    "lualatex": (QUIET, 3),
    "tectonic": (("--untrusted",), 1),
}
SECONDS = 300


def pdf(tex: str, path: Path) -> Path:
    """Compile a document to `path` with the first LaTeX engine found; write nothing if that fails.

    Raises `InputError`.
    """
    engine = find_engine(str(path))
    with temporary_folder() as folder:
        fill_folder(Path(folder), {"equations.tex": tex})
        compiled = Path(folder, "equations.pdf")
        log = _compile(engine, folder)
        if not is_plain_file(compiled):
            raise InputError(str(path), "pdf", f"{engine} failed{_reason(log)}: {INSTEAD}")
        write_file(read_file(compiled), path)
    return path


def find_engine(source: str) -> str:
    """Return the first installed LaTeX engine; raises `InputError` without one."""
    engine = next((name for name in ENGINES if shutil.which(name)), None)
    if engine is None:
        raise InputError(source, "pdf", f"no LaTeX is installed ({', '.join(ENGINES)}): {INSTEAD}")
    return engine


def _compile(engine: str, folder: str) -> str:
    options, times = ENGINES[engine]
    environment = os.environ | {"SOURCE_DATE_EPOCH": "0", "FORCE_SOURCE_DATE": "1"}
    log = ""
    for _ in range(times):
        try:
            done = subprocess.run(
                [engine, *options, "equations.tex"],
                cwd=folder,
                env=environment,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=SECONDS,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"! {error}"
        log = (done.stdout + done.stderr).decode("utf-8", "replace")
        if done.returncode:
            Path(folder, "equations.pdf").unlink(missing_ok=True)
            break
    return log


def _reason(log: str) -> str:
    """The first error of a log, in brackets."""
    match = re.search(r"^(?:!|error:) *(.+)", log, re.MULTILINE)
    return f" ({match[1].strip()})" if match else ""
