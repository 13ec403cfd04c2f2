"""Lines of Structured Text: statements of at most eight operators a line, comments that hold a user's text."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence

from symoro_elastic.codegen.target import words

WIDTH = 110
MOST_OPERATORS = 8
INDENT = "  "
_OPERATOR = re.compile(r" [+-] |[*/]")
LONGEST_NAME = 32
SHORTEST_START = 24
"""Characters that stay of the name of the machine where names of blocks are cut."""
IEC = words(
    """
    ABS ACOS ACTION ADD AND ANDN ANY ANY_BIT ANY_DATE ANY_DERIVED ANY_ELEMENTARY ANY_INT ANY_MAGNITUDE ANY_NUM ANY_REAL
    ANY_STRING ARRAY ASIN AT ATAN ATAN2 BOOL BY BYTE CAL CALC CALCN CASE CD CHAR CLASS CLK CONCAT CONFIGURATION CONSTANT
    CONTINUE COS CTD CTU CTUD CU CV D DATE DATE_AND_TIME DELETE DERIVATIVE DINT DIV DO DS DT DWORD ELSE ELSIF EN
    END_ACTION END_CASE END_CLASS END_CONFIGURATION END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF END_INTERFACE
    END_METHOD END_NAMESPACE END_PROGRAM END_REPEAT END_RESOURCE END_STEP END_STRUCT END_TRANSITION END_TYPE END_VAR
    END_WHILE ENO EQ EXIT EXP EXPT EXTENDS F_EDGE F_TRIG FALSE FINAL FIND FOR FROM FUNCTION FUNCTION_BLOCK GE GT
    HYSTERESIS IF IMPLEMENTS IN INITIAL_STEP INSERT INT INTEGRAL INTERFACE INTERNAL INTERVAL JMP JMPC JMPCN L LD LDATE
    LDN LDT LE LEFT LEN LIMIT LINT LN LOG LREAL LT LTIME LTOD LWORD MAX METHOD MID MIN MOD MOVE MUL MUX N NAMESPACE NE
    NEG NON_RETAIN NOT NULL OF ON OR ORN OVERLAP OVERRIDE P P0 P1 PID POINTER PRIORITY PRIVATE PROGRAM PROTECTED PT
    PUBLIC PV R R1 R_EDGE R_TRIG RAMP READ_ONLY READ_WRITE REAL REF REF_TO REPEAT REPLACE RESOURCE RET RETAIN RETC RETCN
    RETURN RIGHT ROL ROR RS RTC S S1 SD SEL SEMA SHL SHR SIN SINGLE SINT SL SQRT SR ST STEP STN STRING STRING_TO_ARRAY
    STRUCT SUB SUPER T TAN TASK THEN THIS TIME TIME_OF_DAY TO TOD TOF TON TP TRANSITION TRUE TRUNC TYPE UDINT UINT
    ULINT UNTIL USING USINT VAR VAR_ACCESS VAR_CONFIG VAR_EXTERNAL VAR_GLOBAL VAR_IN_OUT VAR_INPUT VAR_OUTPUT VAR_TEMP
    WCHAR WHILE WITH WORD WSTRING XOR XORN
    """
)
"""Reserved words of IEC 61131-3: keywords, standard functions and blocks, instructions, qualifiers of actions."""
TWINCAT_AND_CODESYS = words(
    """
    ABSTRACT ADR ADRINST ANDN_ AND_THEN AXIS_REF BIT BITADR CEIL CONTINUE CRC EXISTS FLOOR FRAC GET GVL HIGH INDEXOF INI
    ITF LOW LOWER_BOUND LTRUNC MAXTRUNC MOVE OR_ELSE OVERLOAD PARAMS PERSISTENT PROPERTY PVOID QUEUE REFERENCE ROUND
    SET SIZEOF SYSTEM TASKINFO TEST UPPER_BOUND UXINT VAR_GENERIC VAR_INST VAR_STAT VOID XINT XSIZEOF XWORD
    __DELETE __ISVALIDREF __NEW __QUERYINTERFACE __QUERYPOINTER __SYSTEM __TRY __CATCH __FINALLY __ENDTRY __XADD __XWORD
    """
)
SCL = words(
    """
    BEGIN BLOCK_DB BLOCK_FB BLOCK_FC BLOCK_SDB BLOCK_SFB BLOCK_SFC CONST COUNTER DATA_BLOCK DB END_BLOCK END_CONST
    END_DATA_BLOCK END_LABEL END_ORGANIZATION_BLOCK END_REGION FB FC GOTO KNOW_HOW_PROTECT LABEL NIL OB OK
    ORGANIZATION_BLOCK PARTIAL_ AUTHOR FAMILY NAME REGION S5T S5TIME S5_TIME SDB SFB SFC SQR TIMER TITLE UDT VARIANT
    VERSION Z
    """
)
OF_COMPILERS = words("BUFSIZ DOMAIN EOF HUGE HUGE_VAL I INFINITY NAN OVERFLOW RAND_MAX SING UNDERFLOW INT_MAX INT_MIN")
"""Macros of C: compilers that go through C write names in capitals."""
RESERVED = IEC | TWINCAT_AND_CODESYS | SCL | OF_COMPILERS


def statement(head: str, right: str) -> list[str]:
    """Return `head` and `right;`, broken before signs or else after `*` and `/`, at the outermost brackets."""
    indent = head[: len(head) - len(head.lstrip())] + INDENT * 2
    first, *more = _pieces(right, WIDTH - len(head) - 1, WIDTH - len(indent) - 1)
    lines = [head + first, *(indent + piece for piece in more)]
    return [*lines[:-1], f"{lines[-1]};"]


def _pieces(text: str, room: int, later: int) -> Iterator[str]:
    """Pieces of a text that fit into lines; `room` is the length of the first line, `later` of the others."""
    breaks = _breaks(text)
    start = 0
    while True:
        fitting = [x for x in breaks if x[0] > start and len(text[start : x[0]].rstrip()) <= room]
        crowded = [sign for _, _, sign in breaks if sign >= start][MOST_OPERATORS:]
        if len(text) - start <= room and not crowded:
            break
        if crowded:
            fitting = [x for x in fitting if x[0] <= crowded[0]]
        if not fitting:
            fitting = [x for x in breaks if x[0] > start][:1]
        if not fitting:
            break
        half = start + (fitting[-1][0] - start) // 2
        end = min((depth, -place) for place, depth, _ in fitting if place >= half)[1]
        yield text[start:-end].rstrip()
        start, room = -end, later
    yield text[start:]


def _breaks(text: str) -> list[tuple[int, int, int]]:
    """Possible line breaks as (position, depth, position of the operator)."""
    depths, depth = [], 0
    for character in text:
        depth += (character == "(") - (character == ")")
        depths.append(depth)
    breaks = []
    for operator in _OPERATOR.finditer(text):
        place = operator.start() + 1
        is_sum = operator[0][0] == " "
        breaks.append((place if is_sum else operator.end(), depths[place - 1] * 2 + (not is_sum), place - (not is_sum)))
    return breaks


def call(head: str, arguments: Sequence[str]) -> list[str]:
    """Return `head(arguments);`, with the arguments on lines of their own where they are long."""
    line = f"{head}({', '.join(arguments)});"
    indent = head[: len(head) - len(head.lstrip())] + INDENT * 2
    if len(line) <= WIDTH:
        return [line]
    text = ", ".join(argument.replace(" ", "\0") for argument in arguments)
    lines = textwrap.wrap(f"{text});", WIDTH, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False)
    return [f"{head}(", *(line.replace("\0", " ") for line in lines)]


def comment(text: str, indent: str = "") -> list[str]:
    """Return a comment, broken into lines where it is long."""
    first = f"{indent}(* "
    return textwrap.wrap(
        f"{in_comment(text)} *)",
        WIDTH,
        initial_indent=first,
        subsequent_indent=" " * len(first),
        break_long_words=False,
    )


def in_comment(text: str) -> str:
    """A user's text made safe for a comment: a single line that neither ends nor begins a comment."""
    line = "".join(character if character.isprintable() else " " for character in text)
    for mark, apart in (("(*", "( *"), ("*)", "* )"), ("/*", "/ *"), ("*/", "* /"), ("{", "("), ("}", ")")):
        line = line.replace(mark, apart)
    return line


def declarations(names: Sequence[str], type_: str, indent: str) -> list[str]:
    """Return declarations of variables of the same type, several per line."""
    lines = textwrap.wrap(", ".join(names), WIDTH - len(type_) - 4, break_long_words=False)
    return [f"{indent}{line.rstrip(',')} : {type_};" for line in lines]


class StNames:
    """Allocates names that differ not only in case, are not reserved and not too long."""

    def __init__(self, taken: Iterable[str] = (), around: str = "") -> None:
        """Prepare the names; `taken` are used, names that begin with `around` belong to the enclosing scope."""
        self.given: dict[str, str] = {}
        self._taken = {*RESERVED, *(name.upper() for name in taken)}
        self._around = f"{around}_"[:SHORTEST_START].upper() if around else ""

    def give(self, name: str) -> str:
        """Return the Structured Text name of a quantity: its own name if available."""
        if name not in self.given:
            self.given[name] = self._free(name)
            self._taken.add(self.given[name].upper())
        return self.given[name]

    @property
    def changed(self) -> dict[str, str]:
        """The names that differ from the requested ones, by requested name."""
        return {name: given for name, given in self.given.items() if name != given}

    def _free(self, name: str) -> str:
        stem = re.sub("_+", "_", name).strip("_")
        stem = f"of_{stem}" if self._around and stem.upper().startswith(self._around) else stem
        free, number = stem[:LONGEST_NAME].rstrip("_"), 0
        while free.upper() in self._taken or (number == 0 and len(stem) > LONGEST_NAME):
            number += 1
            end = f"_{number}"
            free = stem[: LONGEST_NAME - len(end)].rstrip("_") + end
        return free
