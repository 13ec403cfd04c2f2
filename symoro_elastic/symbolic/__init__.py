"""Scalars as an interned graph, and graphs as straight-line programs."""
