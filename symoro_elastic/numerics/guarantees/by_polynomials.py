"""Certificates whose errors are the smaller ones of intervals and of polynomials."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.numerics.guarantees.certificate import Certificate, Subject
from symoro_elastic.numerics.guarantees.polynomial_rounding import rounding_bound


def by_polynomials(certificate: Certificate, subject: Subject, progress: Progress = no_progress) -> Certificate:
    """Return the certificate of a subject with the errors that polynomials prove, where these are smaller.

    Results that are no polynomials, as those of direct models, keep theirs. `progress` is called after each result.
    """
    entries = []
    for k, (entry, x) in enumerate(zip(certificate.entries, subject.results, strict=True)):
        error = min(entry.error, rounding_bound(x, subject.box, subject.rounding).bound)
        entries.append(replace(entry, error=error, likely=min(entry.likely, error)))
        progress(k + 1, len(certificate.entries))
    return replace(certificate, entries=tuple(entries))
