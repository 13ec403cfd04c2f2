"""The columns of a .par file: their lengths checked, their cells read, their defaults filled in.

The variables that its rows own are the names in the cells that sigma selects which are not parameters: the format
declares neither parameters nor coupled joints. A row with a motor or a spring owns a variable; one with
mu = 0 is passive if its cell holds a name of its own, else it is coupled. What stays in doubt is refused.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.formats.joint_cells import OTHER, SELECTED, formula, no_variable, offset_of, rows_by_name, whole
from symoro_elastic.formats.par.syntax import BODY, GEOMETRIC, INERTIAL, JOINT, VECTORS, ParText
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import declared_columns as columns_of
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import NO_VECTOR, Joint, Kind, KnownOfBase, Vector3
from symoro_elastic.machine.names import quote, why_reserved

ROWS = (*GEOMETRIC, *BODY, "eta", "k")
"""Lists with an entry a row."""
FALSE, TRUE = ("0", "False", "false"), ("1", "True", "true")

OF_JOINTS = (*BODY, *JOINT, "mu")
"""Lists whose entries for the cut joints and for the frames that these meet may be left out."""
WAYS = "each in a line (*toml ... *)"
Candidates = dict[int, set[str]]
"""Names that may be variables of the rows, by the number of the row."""


@dataclass(frozen=True)
class Counts:
    """Row counts of a table: bodies in rows 1 to `bodies`, cut joints up to `joints`, then the frames they meet."""

    bodies: int
    joints: int

    @property
    def loops(self) -> int:
        """Number of closed loops, B = NJ - NL."""
        return self.joints - self.bodies

    @property
    def frames(self) -> int:
        """Number of rows, NF = NJ + B."""
        return self.joints + self.loops

    def is_end(self, j: int) -> bool:
        """Whether row j is the frame that a cut joint meets."""
        return j > self.joints

    def lengths(self, key: str) -> dict[int, str]:
        """Allowed numbers of entries of a list, and what they count."""
        if key in VECTORS or key == "Z":
            return {16 if key == "Z" else 3: "fixed"}
        if not self.loops:
            return {self.frames: "NL" if key in BODY else "NJ" if key in JOINT else "NF"}
        shorter = {self.bodies: "NL", self.joints: "NJ"} if key in OF_JOINTS else {}
        return {**shorter, self.frames: "NF = 2 NJ - NL"}

    def has_base(self, key: str, entries: int) -> bool:
        """Whether a list with this number of entries begins with an entry for a floating base."""
        return key in BODY and entries in (self.bodies + 1, self.frames + 1)


def counts(text: ParText) -> Counts:
    """Read the numbers of bodies and joints; raises `InputError` if they or NF are wrong."""
    if "NL" not in text.numbers:
        raise InputError(text.source, "NL", "is missing: write NL = the number of bodies")
    bodies = whole(text.numbers["NL"], text.source, "NL")
    joints = whole(text.numbers.get("NJ", str(bodies)), text.source, "NJ")
    if bodies < 0:
        raise InputError(text.source, "NL", f"{bodies} must be the number of bodies")
    if joints < bodies:
        what = f"{joints} joints are too few for NL = {bodies} bodies: each body has one, each closed loop one more"
        raise InputError(text.source, "NJ", what)
    found_counts = Counts(bodies, joints)
    frames = whole(text.numbers.get("NF", str(found_counts.frames)), text.source, "NF")
    if frames != found_counts.frames:
        raise InputError(text.source, "NF", f"{frames} must be 2 NJ - NL = {found_counts.frames}, or left out")
    return found_counts


def check_lengths(text: ParText, count: Counts, with_base: bool) -> None:
    """Raise `InputError` for a list that has too few or too many entries."""
    for key, cells in text.lists.items():
        lengths = count.lengths(key)
        if len(cells) in lengths or (with_base and count.has_base(key, len(cells))):
            continue
        *first, last = (f"{length} ({what})" for length, what in lengths.items())
        expected = f"{', '.join(first)} or {last}" if first else last
        raise InputError(text.source, key, f"has {len(cells)} entries, expected {expected}")


class Columns:
    """The table of a .par file by columns; rows are numbered from 1, and named j1, j2 ... by default."""

    def __init__(self, text: ParText) -> None:
        self.text, self.source = text, text.source
        self.known_of_base = self._known_of_base()
        for key in ("ant", "sigma"):
            if key not in text.lists:
                raise InputError(self.source, key, f"the list is missing: write {key} = {{...}}, an entry a joint")
        self.counts = counts(text)
        check_lengths(text, self.counts, with_base=self.known_of_base is not None)
        self.count = self.counts.frames
        self.of_base = self._of_base()
        lists = {key: text.lists[key] for key in ROWS if key in text.lists}  # without entries for ends: zeros
        self.lists = {key: [*cells, *["0"] * (self.count - len(cells))] for key, cells in lists.items()}
        self.names = [f"j{j}" for j in range(1, self.count + 1)]
        self._whole: dict[tuple[str, int], int] = {}
        self._formulas: dict[str, tuple[Formula, ...]] = {}

    def place(self, j: int, key: str) -> str:
        """Name of a cell for messages."""
        name = self.names[j - 1]
        joint = f"joint {j} ({name if why_reserved(name) is None else quote(name)})"
        return f"{joint}, {key}" if key else joint

    def whole(self, key: str, j: int, default: int) -> int:
        """The integer in a cell."""
        if key not in self.lists:
            return default
        if (key, j) not in self._whole:
            self._whole[key, j] = whole(self.lists[key][j - 1], self.source, self.place(j, key))
        return self._whole[key, j]

    def flag(self, key: str, j: int, default: int) -> int:
        """The flag, 0 or 1, in a cell."""
        value = self.whole(key, j, default)
        if value not in (0, 1):
            raise InputError(self.source, self.place(j, key), f"{value} must be 0 or 1")
        return value

    def formula(self, key: str, j: int) -> Formula:
        """The formula in a cell, zero if the file has no such list."""
        if key not in self.lists:
            return ZERO
        if key not in self._formulas:
            cells = enumerate(self.lists[key], start=1)
            self._formulas[key] = tuple(formula(text, self.source, self.place(i, key)) for i, text in cells)
        return self._formulas[key][j - 1]

    def texts(self, keys: Sequence[str], j: int) -> list[str]:
        """The texts of the cells of a row in these lists; 0 where the file has no such list."""
        if keys == ("k",) and self.kind(j) is not Kind.ELASTIC:
            return ["0"]
        return [self.lists[key][j - 1] if key in self.lists else "0" for key in keys]

    def base_vector(self, key: str) -> Vector3:
        """The three entries of a list that belongs to frame 0, such as gravity."""
        if key not in self.text.lists:
            return NO_VECTOR
        x, y, z = (formula(text, self.source, key) for text in self.text.lists[key])
        return x, y, z

    def kind(self, j: int) -> Kind:
        """Kind of a joint by its row, sigma, eta and mu; without motor and spring it is passive, or coupled."""
        fixed = self.whole("sigma", j, 0) == 2
        if self.counts.bodies < j <= self.counts.joints:
            return self._cut(j)
        if self.counts.is_end(j) and not fixed:
            raise InputError(self.source, self.place(j, "sigma"), self._no_end(j))
        elastic = self.flag("eta", j, 0) == 1
        if fixed and elastic:
            raise InputError(self.source, self.place(j, "eta"), "a fixed frame (sigma = 2) has no spring: write 0")
        if fixed:
            return Kind.FIXED
        if elastic:
            return Kind.ELASTIC
        return Kind.MOTOR if self.flag("mu", j, 1) else Kind.PASSIVE

    def _cut(self, j: int) -> Kind:
        """The kind of a cut joint, which has no motor and no spring."""
        for key in ("mu", "eta"):
            if self.flag(key, j, 0):
                rows = range(1, self.counts.bodies + 1)
                passive = [self.names[i - 1] for i in rows if self.kind(i) is Kind.PASSIVE][:8]
                elsewhere = f" (passive joints: {', '.join(passive)})" if passive else ""
                what = f"the cut joint carries no motor, spring or body: write 0, or cut the loop elsewhere{elsewhere}"
                raise InputError(self.source, self.place(j, key), what)
        return Kind.CUT

    def _no_end(self, j: int) -> str:
        """Return why a row that moves cannot be the frame that a cut joint meets."""
        first, last = self.counts.joints + 1, self.count
        rows = f"row {last} is the frame" if first == last else f"rows {first} to {last} are the frames"
        cut = self.names[j - self.counts.loops - 1]
        return f"must be 2: {rows} that cut joints meet, this one {quote(cut)}, and does not move"

    def _known_of_base(self) -> KnownOfBase | None:
        """Known quantity of the base: the wrench of a floating base, the acceleration of a mobile one; else None."""
        quantities = []
        for key, quantity in (("is_floating", KnownOfBase.WRENCH), ("is_mobile", KnownOfBase.ACCELERATION)):
            value = self.text.numbers.get(key, "0")
            if value not in (*TRUE, *FALSE):
                raise InputError(self.source, key, f"{quote(value)} must be 0 or 1")
            quantities += [quantity] if value in TRUE else []
        if len(quantities) > 1:
            raise InputError(self.source, "is_mobile", "the base is floating already: write 1 for one of the two")
        return quantities[0] if quantities else None

    def _of_base(self) -> dict[str, str]:
        """Cells of a floating base, which precede those of the bodies; removes them from the lists."""
        cells = {}
        for key in BODY:
            if self.known_of_base and self.counts.has_base(key, len(self.text.lists.get(key, ()))):
                cells[key], *self.text.lists[key] = self.text.lists[key]
        for key in BODY[len(INERTIAL) :]:
            if not formula(cells.get(key, "0"), self.source, f"base, {key}").is_zero:
                raise InputError(self.source, f"base, {key}", "the base has no joint, and f0 is an argument: write 0")
        return cells


def owned_names(names: Mapping[int, Collection[str]], optional: Collection[int]) -> Candidates:
    """Return the candidates for each row's variable: one if determined, several if ambiguous, none if coupled.

    A row with one name owns it; one with several owns that which no other row owns. Rows in `optional` are coupled
    where other rows own all their names; a name that such a row has alone is not taken from one that must own one.
    """
    candidates = {j: set(options) for j, options in names.items()}
    holders = rows_by_name(candidates)
    waiting = deque(j for j, options in candidates.items() if len(options) == 1)
    visited: set[tuple[str, bool]] = set()
    while waiting:
        i = waiting.popleft()
        name = next(iter(candidates[i]), "")
        if len(candidates[i]) != 1 or (name, i in optional) in visited:
            continue
        visited.add((name, i in optional))
        for j in holders[name]:
            yields = j in optional or (len(names[j]) > 1 and i not in optional)
            if j != i and yields and name in candidates[j]:
                candidates[j].remove(name)
                waiting.append(j)
    return candidates


def _owned_names(candidates: Candidates) -> set[str]:
    """Names that are determined to be variables of rows."""
    return {name for names in candidates.values() if len(names) == 1 for name in names}


class _Cells:
    """The cells that sigma selects in moving rows, from which the joint variables are determined.

    `declared` are parameters; so are the names `elsewhere`, in cells without variable, by the number of times.
    `chosen` are the variables that the file names as those of rows.
    """

    def __init__(
        self, columns: Columns, declared: Collection[str], elsewhere: Mapping[str, int], chosen: Mapping[int, str]
    ) -> None:
        self.columns, self.elsewhere = columns, elsewhere
        rows = range(1, columns.count + 1)
        self.sigma = {j: sigma for j in rows if (sigma := columns.whole("sigma", j, 0)) in SELECTED}
        self.cells = {j: columns.formula(SELECTED[sigma], j) for j, sigma in self.sigma.items()}
        self.names = {j: cell.names.difference(declared) for j, cell in self.cells.items()}
        self.holders = Counter(name for names in self.names.values() for name in names)
        self.given = self._checked_choices(chosen)
        passive = [j for j in self.cells if j not in self.given and columns.kind(j) is Kind.PASSIVE]
        self.optional = {j for j in passive if any(self.holders[name] > 1 for name in self.names[j])}
        self.candidates = {j: set(self._candidates(j)) for j in self.cells}

    def own(self) -> dict[int, str]:
        """Return the joint variables by row number; raises `InputError` for an ambiguous one."""
        candidates = owned_names(self.candidates, self.optional)
        for narrowed in (self._named_by_followers, self._only_here, self._named_by_followers):
            candidates = owned_names({**candidates, **narrowed(candidates)}, self.optional)
        owned = _owned_names(candidates)
        for j, names in candidates.items():
            doubt = self._doubt(j, names, owned)
            if doubt:
                raise self._error(j, SELECTED[self.sigma[j]], doubt)
        return {j: name for j, names in candidates.items() for name in names}

    def _candidates(self, j: int) -> Collection[str]:
        """Names in a cell that may be its joint variable: summands that are no parameters elsewhere."""
        names = self.names[j]
        if j in self.given:
            return {self.given[j]}
        if len(names) == 1 and j not in self.optional:
            return names
        variables = names.difference(self.elsewhere)
        added = {name for name in variables if offset_of(self.cells[j], name) is not None}
        return added if j in self.optional else added or variables or names

    def _named_by_followers(self, candidates: Candidates) -> Candidates:
        """Assignments of ambiguous rows that have a single name needed by a coupled row."""
        owners = rows_by_name(candidates)
        narrowed: Candidates = {}
        for j in self._without_leader(candidates):
            possible = [(i, name) for name in self.names[j] for i in owners.get(name, ())]
            narrowed |= {i: {name} for i, name in possible if len(possible) == 1}
        self.candidates |= narrowed
        return narrowed

    def _without_leader(self, candidates: Candidates) -> list[int]:
        """Coupled rows whose cells contain no variable determined for another row."""
        owned = _owned_names(candidates)
        return [j for j in self.optional if not candidates[j] and owned.isdisjoint(self.names[j])]

    def _only_here(self, candidates: Candidates) -> Candidates:
        """Assignments of ambiguous rows that have a single name found in no other cell."""
        followed = {name for j in self._without_leader(candidates) for name in self.names[j]}
        followed |= {name for j in self.optional if len(candidates[j]) == 1 for name in candidates[j]}
        narrowed = {}
        for j, names in candidates.items():
            new = {name for name in names if self.holders[name] == 1}
            if len(names) > 1 and len(new) == 1 and names.isdisjoint(followed):
                narrowed[j] = new
        return narrowed

    def _checked_choices(self, chosen: Mapping[int, str]) -> Mapping[int, str]:
        """The joint variables that the file states, by row; raises `InputError` for impossible ones."""
        for j, variable in chosen.items():
            if j not in self.cells:
                raise self._error(j, "variable", "a fixed frame has no variable of its own: leave it out")
            if variable not in self.cells[j].names:
                where = f"{SELECTED[self.sigma[j]]} = {quote(self.cells[j])}"
                raise self._error(j, "variable", f"{quote(variable)} does not occur in {where}")
        return chosen

    def _error(self, j: int, key: str, what: str) -> InputError:
        return InputError(self.columns.source, self.columns.place(j, key), what)

    def _doubt(self, j: int, names: Collection[str], owned: Collection[str]) -> str:
        """Return why the variable of a row is ambiguous or missing; empty if it is determined."""
        cell, name = quote(self.cells[j]), min(names, default="")
        joint = self.columns.names[j - 1]
        if len(names) > 1:
            what = f"{cell} may hold any of {', '.join(sorted(names))} as joint variable (sigma = {self.sigma[j]})"
            return f"{what}: declare the parameters among them in [parameters], or give the variable of {joint}: {WAYS}"
        leaders = sorted(self.names[j].intersection(owned))
        if not names and not leaders:
            return self._no_variable(j)
        if not names and j not in self.optional:
            what = f"{cell} holds variables of other joints only ({', '.join(leaders)})"
            return f"{what}: add one of its own, or write mu = 0 for a coupled joint"
        if j in self.optional and len(self.candidates[j]) > 1 and self.holders[name] > 1:
            what = f"{name!r} in {cell} may be a variable of its own, or a parameter"
            return f"{what}: give variable = {name!r} in the row of {joint}, or declare {name} in [parameters]: {WAYS}"
        return ""

    def _no_variable(self, j: int) -> str:
        names = self.columns.formula(OTHER[self.sigma[j]], j).names
        elsewhere = [name for name in names if self.elsewhere[name] == 1 and not self.holders[name]]
        return no_variable(self.cells[j], self.sigma[j], elsewhere)


GEOMETRY = tuple(key for column in columns_of(Joint, "joints") for key in column.par)


class Names:
    """All names in the cells of a file, in order of first appearance by joint, then by column."""

    def __init__(
        self, columns: Columns, further: Sequence[Formula], declared: Collection[str], chosen: Mapping[int, str]
    ) -> None:
        self.cells = [*_cells(columns), *further]
        elsewhere = Counter(name for cell in (*_without_variables(columns), *further) for name in cell.names)
        self.variables = _Cells(columns, declared, elsewhere, chosen).own()

    def parameters(self) -> list[str]:
        """All names but the joint variables, in order of appearance."""
        variables = {*self.variables.values()}
        return [*dict.fromkeys(name for cell in self.cells for name in _in_order(cell) if name not in variables)]


def _cells(columns: Columns) -> Iterator[Formula]:
    for j in range(1, columns.count + 1):
        for key in (*GEOMETRY, *BODY):
            yield columns.formula(key, j)
        if columns.kind(j) == Kind.ELASTIC:
            yield columns.formula("k", j)
    for key in VECTORS:
        yield from columns.base_vector(key)


def _without_variables(columns: Columns) -> Iterator[Formula]:
    """Cells without a joint variable."""
    for j in range(1, columns.count + 1):
        selected = SELECTED.get(columns.whole("sigma", j, 0))
        for key in (*GEOMETRY, *BODY):
            if key != selected:
                yield columns.formula(key, j)
    for key in VECTORS:
        yield from columns.base_vector(key)


def _in_order(cell: Formula) -> list[str]:
    return sorted(cell.names, key=lambda name: (cell.text.index(name), name))
