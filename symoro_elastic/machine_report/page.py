"""The page of a report."""

from __future__ import annotations

from html import escape

from symoro_elastic.codegen.templates import render
from symoro_elastic.machine_report.sections import Subject, sections


def report_page(subject: Subject) -> str:
    """Return the page as HTML: nothing is loaded from elsewhere, and names of the machine are text in it."""
    made = list(sections(subject))
    title, headline = escape(subject.machine.name), escape(subject.machine.headline.partition(": ")[2])
    return render("report/report.html.j2", title=title, headline=headline, sections=made)
