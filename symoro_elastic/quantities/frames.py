"""Names of frames: `base` is frame 0, others have names of their own, or those of their joints."""

BASE = "base"
"""Frame 0, and the six rows of a base that moves."""
JOINT, LINK, SITE, ROW = "joint", "link", "site", "row"
"""What may stand before a name that several frames have: those of a joint, a link or a site of a file, and of a row."""
OF_FILES = (JOINT, LINK, SITE)


def kind_and_name(text: str) -> tuple[str, str]:
    """Return the kind and the name in a text such as `link tool`; the kind is empty without one."""
    what, _, name = map(str.strip, text.partition(" "))
    return (what, name) if what in OF_FILES and name else ("", text)
