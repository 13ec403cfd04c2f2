"""The machine of a .par file of SYMORO, with lines `(*toml ... *)` for what that format lacks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from symoro_elastic.formats.central import about_origin, normal
from symoro_elastic.formats.files import UTF_8, WESTERN, name_of
from symoro_elastic.formats.format import Format
from symoro_elastic.formats.par.columns import Columns, Names
from symoro_elastic.formats.par.lines import as_toml, values_of
from symoro_elastic.formats.par.syntax import LISTS, ParText, take_apart
from symoro_elastic.formats.par.writing import Declared, kind_flags, layout, list_text, structure
from symoro_elastic.formats.toml.keys import MACHINE, OF_JOINTS
from symoro_elastic.formats.toml.reading import body_of, machine_of
from symoro_elastic.formats.toml.tables import Number, Table
from symoro_elastic.foundation.errors import InputError, refusing
from symoro_elastic.machine.columns import cells, declared_columns
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.format_names import SYMORO
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine
from symoro_elastic.machine.names import did_you_mean, no_such, quote
from symoro_elastic.machine.scene import RequestedPart

__all__ = ["FORMAT", "read", "write"]


def read(text: str, source: str) -> DescribedMachine:
    """Read the machine in a .par text; raises `InputError`. Consistency is checked by `checks.check`."""
    table = ParTable(take_apart(text, source))
    machine = machine_of(Table(table.entries, source))
    return replace(machine, origin=replace(machine.origin, of_name=table.origin_of_name))


def write(machine: Machine) -> str:
    """Return the .par text that `read` reads back; parameters and variables are declared only if necessary."""
    described = DescribedMachine.of(machine)
    for names in Declared:
        text = layout(described, names)
        try:
            again = read(text, machine.source)
        except InputError:
            continue
        if (again.parameters, again.joints, again.loops) == (machine.parameters, machine.joints, machine.loops):
            break
    return text


OF_LISTS = tuple(column for column in declared_columns(Joint) if set(column.par) <= set(LISTS))
"""Columns of a joint that are lists of the format."""
Entries = dict[str, Any]


class ParTable:
    """Conversion of a .par file to entries of TOML, its joints in the order of TOML rows."""

    def __init__(self, text: ParText) -> None:
        self.text, self.source, self.columns = text, text.source, Columns(text)
        self.lines = values_of(text.lines, text.source)
        self.block = self._block()
        self.order = self._order()
        self.row = {j: i for i, j in enumerate(self.order, start=1)}
        chosen = {
            j: row.text("variable") for j, row in zip(self.order, self.rows, strict=True) if "variable" in row.entries
        }
        self.names = Names(self.columns, [*self._formulas()], self.block.table("parameters").entries, chosen)

    @property
    def entries(self) -> Entries:
        """Entries of the TOML file of the same machine; raises `InputError`."""
        tables: dict[str, Entries] = {name: dict(self.block.table(name).entries) for name in OF_JOINTS}
        for j, name in enumerate(self.columns.names, start=1):
            for section, entry in self._cells(j).items():
                tables[section][name] = self._merged_entry(entry, section, name, j)
        own: Entries = {
            "name": name_of(self.text.robot if self.text.robot.strip() else Path(self.source).stem),
            **self.block.entries,
            "joints": [self._row(j) for j in self.order],
            "loops": self._loops(),
            "parameters": self._parameters(),
            "notes": [*self.text.comments, *self.block.texts("notes")],
            "base": self._base(),
            "extras": {**self.block.table("extras").entries, **self._extras()},
        }
        gravity = {"gravity": self.text.lists["G"]} if "G" in self.text.lists else {}
        return {**own, **tables, **gravity}

    @property
    def origin_of_name(self) -> str:
        """Explanation of the source of the machine's name; empty if the file states the name."""
        if "name" in self.block.entries:
            return ""
        instead = 'give another by (*toml name = "..." *)'
        if self.text.robot.strip():
            return f"it is made of Robotname = {quote(self.text.robot)}, {instead}"
        return f"it is made of the name of the file, {instead}"

    def _block(self) -> Table:
        """Entries outside the lists: from the TOML block and from extension lines of the old form."""
        old = as_toml(self.lines, self.columns.counts.bodies, self.columns.counts.joints, self.source)
        block = Table(self.text.block, self.source).only(MACHINE.names)
        for key in old:
            if key in block.entries:
                raise block.fail(key, "is in lines (*toml ... *) and in lines (*! ... *): move all to the first")
        if "gravity" in block.entries and "G" in self.text.lists:
            raise block.fail("gravity", "is given by the list G too: remove one of the two")
        return Table({**block.entries, **old}, self.source)

    def _order(self) -> list[int]:
        """Row number in the file for each row of the table; names the rows, ends of loops last."""
        counts = self.columns.counts
        self.rows = self.block.tables("joints") or [Table({}, self.source) for _ in range(counts.frames)]
        if len(self.rows) != counts.frames:
            raise self.block.fail("joints", f"has {len(self.rows)} rows, expected {counts.frames}, one a joint")
        names = [row.text("name", f"j{i}") for i, row in enumerate(self.rows, start=1)]
        ends = self._ends(names)
        last = [names.index(name) for key in ("cut", "meets") for name in ends[key]]
        if len({*last}) < len(last):
            raise self.block.fail("loops", "each cut joint, and each frame that one meets, closes one loop")
        order = [i for i in range(len(names)) if i not in last] + last
        self.columns.names = [names[i] for i in order]
        number = {i: j for j, i in enumerate(order, start=1)}
        return [number[i] for i in range(len(names))]

    def _ends(self, names: Sequence[str]) -> dict[str, list[str]]:
        """Names of the cut joints and of the frames that they meet, loop by loop: stated ones, else the last rows."""
        loops, counts = self.block.table("loops"), self.columns.counts
        if loops.entries and len(loops.entries) != counts.loops:
            what = f"names {len(loops.entries)} loops, expected {counts.loops} (NJ - NL)"
            raise self.block.fail("loops", what)
        tables = [loops.table(name) for name in loops.entries] or [Table({}, self.source)] * counts.loops
        ends: dict[str, list[str]] = {}
        for key, before in (("cut", counts.bodies), ("meets", counts.joints)):
            ends[key] = [entry.text(key, names[before + k]) for k, entry in enumerate(tables)]
            for entry, name in zip(tables, ends[key], strict=True):
                if name not in names:
                    raise entry.fail(key, no_such("joint", name, names))
        return ends

    def _loops(self) -> Entries:
        loops, counts, names = self.block.table("loops"), self.columns.counts, self.columns.names
        keys = [*loops.entries] or [f"loop_{k}" for k in range(1, counts.loops + 1)]
        return {
            name: {**loops.table(name).entries, "cut": names[counts.bodies + k], "meets": names[counts.joints + k]}
            for k, name in enumerate(keys)
        }

    def _row(self, j: int) -> Entries:
        """Entry of row j for the table of joints."""
        columns, i = self.columns, self.row[j]
        sigma, kind, antecedent = columns.whole("sigma", j, 0), columns.kind(j), columns.whole("ant", j, 0)
        variable = self.names.variables.get(j)
        if kind is Kind.PASSIVE and sigma in (0, 1) and variable is None:
            kind = Kind.COUPLED
        own = {"antecedent": self.row.get(antecedent, antecedent), "kind": kind.value, "sigma": sigma}
        own |= self._cells(j, "joints").get("joints", {})
        in_block = {key: x for key, x in self.rows[i - 1].entries.items() if key not in ("name", "variable")}
        row = {"name": columns.names[j - 1], **self._merge(own, in_block, columns.place(j, ""))}
        return row if variable is None else {**row, "variable": variable}

    def _cells(self, j: int, only: str = "") -> dict[str, Entries]:
        """Nonzero cells of a row by section and key: those of section `only`, or of all but the joints."""
        by_section: dict[str, Entries] = {}
        for column in OF_LISTS:
            texts = self.columns.texts(column.par, j)
            if (column.section == only if only else column.section != "joints") and {*texts} != {"0"}:
                by_section.setdefault(column.section, {})[column.key] = texts if column.parts else texts[0]
        return by_section

    def _merged_entry(self, own: Entries, section: str, name: str, j: int) -> Entries:
        """Return the entry of a joint in a section, merged from the lists and the TOML block."""
        in_block = self.block.table(section).table(name).entries
        if section != "bodies" or not in_block:
            return self._merge(own, in_block, self.columns.place(j, section))
        return self._agreeing(own, in_block, self.columns.place(j, "bodies"))

    def _agreeing(self, own: Entries, in_block: Mapping[str, Any], place: str) -> Entries:
        """Return the block's entry of a body about its centre of mass; raises `InputError` if the lists differ."""
        written = body_of(Table({"mass": own.get("mass", 0), **in_block}, self.source, place))
        listed_ = body_of(Table(own, self.source, place))
        with refusing(self.source, place):
            agree = about_origin(written) == normal(listed_)
        if not agree:
            what = "does not agree with the lists XX to M: change both, or remove the body in TOML"
            raise InputError(self.source, place, what)
        return {"mass": own.get("mass", "0"), **in_block}

    def _merge(self, own: Entries, in_block: Mapping[str, Any], place: str) -> Entries:
        for key in in_block:
            if key in own:
                raise InputError(self.source, f"{place}, {key}", "is in a list, too: remove one of the two")
        return {**own, **in_block}

    def _parameters(self) -> Entries:
        """Values of all parameters, nan if missing: in the order of the block if it names all, else of the cells."""
        in_block = self.block.table("parameters").entries
        names = self.names.parameters()
        undeclared = [name for name in names if name not in in_block]
        first = self.lines.get("parameters", ()) if self.lines or undeclared else in_block
        for name in in_block:
            if undeclared and name not in first and name not in names:
                raise InputError(
                    self.source, "parameters", f"no name {quote(name)} in the table{did_you_mean(name, names)}"
                )
        names = [*dict.fromkeys([*first, *names, *in_block])]
        return {name: in_block.get(name, Number("nan")) for name in names}

    def _base(self) -> Entries:
        """Entries of the base: its motion, and its body if it floats."""
        own: Entries = {}
        for column in declared_columns(Base, "base"):
            if self.text.lists.get(column.par[0], ["0"] * 3) != ["0"] * 3:
                own[column.key] = self.text.lists[column.par[0]]
        in_block = dict(self.block.table("base").entries)
        if self.columns.known_of_base is None:
            if "floating" in in_block:
                raise InputError(self.source, "base, floating", "only a floating base has one: add is_floating = 1")
            return self._merge(own, in_block, "base")
        body: Entries = {}
        for column in declared_columns(Body):
            texts = [self.columns.of_base.get(key, "0") for key in column.par]
            if {*texts} != {"0"}:
                body[column.key] = texts if column.parts else texts[0]
        floating, known = in_block.pop("floating", "rotation"), self.columns.known_of_base.value
        if in_block.pop("known", known) != known:
            raise InputError(self.source, "base, known", "differs from that of is_floating, is_mobile: leave it out")
        if "body" in in_block:
            body = self._agreeing(body, self.block.table("base").table("body").entries, "base, body")
        in_block.pop("body", None)
        return {**self._merge({**own, "body": body}, in_block, "base"), "floating": floating, "known": known}

    def _extras(self) -> Entries:
        """Entries that no model uses: unknown lists, and flags that contradict the kinds of joints."""
        lists, numbers, columns = self.text.lists, self.text.numbers, self.columns
        extras: Entries = {key: list_text(lists[key]) for key in ("QP", "QDP", "GAM", "Z") if key in lists}
        rows = range(1, columns.count + 1)
        kinds = [columns.kind(j) for j in rows]
        usual = [kind_flags(kind)[0] for kind in kinds]
        if columns.lists.get("mu", usual) != usual:
            extras["mu"] = list_text(lists["mu"])
        closed = structure([columns.whole("ant", j, 0) for j in rows], kinds)
        if numbers.get("Type", closed) != closed:
            if numbers["Type"] not in ("0", "1", "2"):
                what = f"{quote(numbers['Type'])} must be 0 (chain), 1 (tree) or 2 (closed loops)"
                raise InputError(self.source, "Type", what)
            extras["Type"] = numbers["Type"]
        unused = ["0" if kind is Kind.ELASTIC else cell for kind, cell in zip(kinds, lists.get("k", []), strict=False)]
        if any(cell != "0" for cell in unused):
            extras["k"] = list_text(unused)
        return extras

    def _formulas(self) -> Iterator[Formula]:
        """Formulas of the base and of the TOML block, whose names are parameters."""
        yield from _formulas_in(self.columns.of_base.get(cell.par, "0") for cell, _ in cells(Body()))
        tables = {name: self.block.table(name).entries for name in OF_JOINTS}
        for sections in ([name for name in OF_JOINTS if name != "bodies"], ["bodies"]):
            for joint in self.columns.names:
                yield from _formulas_in(tables[name].get(joint, ()) for name in sections)
        yield from _formulas_in([self.block.table("base").entries.get("body", ())])
        scene = self.block.table("scene").entries
        static = scene.get("static")
        yield from _formulas_in([scene.get("locked", ()), static if isinstance(static, dict) else ()])
        yield from (x for point in _points(scene.get("outputs", ())) for x in point)


def _formulas_in(values: Iterable[Any]) -> Iterator[Formula]:
    """Yield the formulas among values of tables; invalid ones are rejected where they are read."""
    for value in values:
        if isinstance(value, dict | list):
            yield from _formulas_in(value.values() if isinstance(value, dict) else value)
        elif isinstance(value, str) and not isinstance(value, Number):
            try:
                yield Formula.parse(" ".join(value.split()))
            except FormulaError:
                continue


def _points(outputs: Any) -> Iterator[tuple[Formula, ...]]:
    """Points in the outputs of a scene, as formulas of their coordinates."""
    for texts in outputs.values() if isinstance(outputs, dict) else ():
        for text in texts if isinstance(texts, list) else ():
            try:
                yield RequestedPart.parse(str(text)).at or ()
            except FormulaError:
                continue


FORMAT = Format(SYMORO, read, write, (UTF_8, WESTERN))
