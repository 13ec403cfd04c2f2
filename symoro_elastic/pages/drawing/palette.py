"""Colours of figures, by the role of a shape, on light and on dark paper."""

from __future__ import annotations

from dataclasses import dataclass

LIT = (0.16, 0.0, -0.16)
"""Of faces turned to the light, aside and away: how far towards white, or black."""


@dataclass(frozen=True)
class Palette:
    """Colours `#rrggbb`: paper, ink, faint ink, and those of shapes by their role.

    `edges` is how far the edges of a shape are mixed with white, or black.
    """

    paper: str
    ink: str
    faint: str
    edges: float
    roles: dict[str, str]

    def shade(self, role: str, shade: int) -> str:
        """Return the colour of a face: shade 0 is lit, 2 is dark."""
        return mix(self.roles[role], LIT[shade])

    def outline(self, role: str) -> str:
        """Return the colour of the edges of a shape: darker on light paper, lighter on dark paper."""
        return mix(self.roles[role], self.edges)


def mix(colour: str, share: float) -> str:
    """Return a colour mixed with white by a fraction, with black by a negative one."""
    aim = 255 if share > 0 else 0
    parts = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return "#" + "".join(f"{round(part + abs(share) * (aim - part)):02x}" for part in parts)


LIGHT = Palette(
    "#fbfaf7",
    "#20262b",
    "#6d757c",
    -0.45,
    {
        "body": "#8fa9bf",
        "mesh": "#b9c3cb",
        "beam": "#9db8a6",
        "motor": "#1f6fb2",
        "elastic": "#dd7418",
        "passive": "#9aa2a8",
        "coupled": "#7a68ae",
        "fixed": "#b3b8bc",
        "cut": "#b8405a",
        "link": "#6b747c",
        "rail": "#c2c8cc",
        "base": "#d6d0c2",
        "ghost": "#c3c9cd",
        "arrow": "#b0246b",
        "x": "#c9382f",
        "y": "#2a8a52",
        "z": "#2f5fc4",
    },
)
DARK = Palette(
    "#14181c",
    "#e8eaec",
    "#98a2aa",
    0.3,
    {
        "body": "#5f7d96",
        "mesh": "#7d8a94",
        "beam": "#5f8070",
        "motor": "#4a9fe0",
        "elastic": "#f2994a",
        "passive": "#87919a",
        "coupled": "#a08fd8",
        "fixed": "#707a82",
        "cut": "#e2708a",
        "link": "#8b969f",
        "rail": "#4d565e",
        "base": "#57534a",
        "ghost": "#4a545d",
        "arrow": "#ff7ab8",
        "x": "#ee6f66",
        "y": "#5cc489",
        "z": "#7fa6f5",
    },
)
