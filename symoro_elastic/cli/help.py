"""Help of a command: options under heads, the common ones on a line at the foot, the rare ones by `--help all`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from textwrap import fill

import click


def _flags(names: str) -> frozenset[str]:
    return frozenset(f"--{name}" for name in names.split())


MOST = 15
"""Options of the first screen."""
EVERYTHING = "all"
METHOD = "Method"
HEADS: Mapping[str, frozenset[str]] = {
    "Models": _flags("model form only fold base free snap elastic merge-angles"),
    "Accuracy": _flags(
        "to within keep guaranteed limits precision certify proven tolerance sub-boxes polynomials modulus "
        "position-modulus"
    ),
    "Operating point": _flags(
        "frame position orientation at torque rate as-given hold pd hover thrust along over box starts velocity "
        "acceleration"
    ),
    METHOD: frozenset(),
    "Output": _flags("input output target out save picture report format result require"),
}
"""Options by head; `METHOD` has all others."""
COMMON = _flags("value scene seed plots plot-format force json help")
RARE = _flags(
    "compiler compiler-flags fmi start by-torque merge-angles free torque rate as-given hover thrust pd sweep sampling "
    "scheduler stribeck cogging link-side temperatures load-friction gain rounds extreme harmonics sub-boxes "
    "polynomials intervals thickness"
)
"""Options that only `--help all` lists where a command has more than fit on a screen."""


class HeadedCommand(click.Command):
    """A command whose help lists the options under headings."""

    def get_help_option(self, ctx: click.Context) -> click.Option:
        """Return `-h`, `--help`, which may be followed by `all`."""

        from symoro_elastic.cli.output import echo

        def show(context: click.Context, _: click.Parameter, asked: str | None) -> None:
            if asked is not None and not context.resilient_parsing:
                context.meta[EVERYTHING] = asked == EVERYTHING
                echo(context.get_help())
                context.exit()

        return click.Option(
            ["-h", "--help"],
            is_flag=False,
            flag_value="",
            metavar="[all]",
            is_eager=True,
            expose_value=False,
            callback=show,
            help="Show this message, or all options by --help all, and exit.",
        )

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write options under their heads, then the common ones without explanation unless all are listed."""
        full = bool(ctx.meta.get(EVERYTHING))
        options = [x for x in self.get_params(ctx) if isinstance(x, click.Option) and not x.hidden]
        common = [x for x in options if x.opts[-1] in COMMON]
        others = [x for x in options if x.opts[-1] not in COMMON]
        hidden = [] if full or len(others) <= MOST else [x for x in others if x.opts[-1] in RARE]
        shown = [x for x in others if x not in hidden]
        for head, rows in _by_head(shown):
            self._section(ctx, formatter, head, rows)
        if full:
            self._section(ctx, formatter, "Common", common)
            return
        more = f"{len(hidden)} more options: --help all" if hidden else "--help all explains these"
        foot = f"Common options: {', '.join(_brief(x, ctx) for x in common)}. {more}."
        formatter.write_paragraph()
        formatter.write(f"{fill(foot, formatter.width, break_on_hyphens=False)}\n")

    @staticmethod
    def _section(ctx: click.Context, formatter: click.HelpFormatter, head: str, rows: list[click.Option]) -> None:
        records = [record for row in rows if (record := row.get_help_record(ctx))]
        if records:
            with formatter.section(head):
                formatter.write_dl(records)


def _by_head(options: list[click.Option]) -> Iterator[tuple[str, list[click.Option]]]:
    named = {option: head for head, options in HEADS.items() for option in options}
    for head in HEADS:
        yield head, [x for x in options if named.get(x.opts[-1], METHOD) == head]


def _brief(option: click.Option, ctx: click.Context) -> str:
    """Return how an option is written."""
    metavar = "" if option.is_flag or option.opts[-1] == "--help" else f" {option.make_metavar(ctx)}"
    return f"{', '.join(option.opts)}{metavar}"
