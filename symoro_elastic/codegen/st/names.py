"""Names of Structured Text: it ignores case, has many reserved words, and controllers tell 32 characters apart."""

from __future__ import annotations

import re
from collections.abc import Iterable

from symoro_elastic.codegen.target import words

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
"""Of IEC 61131-3: keywords, standard functions and blocks, instructions and qualifiers of actions."""
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


class StNames:
    """Names that are given in turn: no two are equal but for case, none is reserved or too long."""

    def __init__(self, taken: Iterable[str] = (), around: str = "") -> None:
        """`taken` are names that hold already; those that hold around begin with the name `around`."""
        self.given: dict[str, str] = {}
        self._taken = {*RESERVED, *(name.upper() for name in taken)}
        self._around = f"{around}_"[:SHORTEST_START].upper() if around else ""

    def give(self, name: str) -> str:
        """Return the name for a quantity: its own where it can be had."""
        if name not in self.given:
            self.given[name] = self._free(name)
            self._taken.add(self.given[name].upper())
        return self.given[name]

    @property
    def changed(self) -> dict[str, str]:
        """The names that are others than wanted."""
        return {name: given for name, given in self.given.items() if name != given}

    def _free(self, name: str) -> str:
        stem = re.sub("_+", "_", name).strip("_")
        stem = f"of_{stem}" if self._around and stem.upper().startswith(self._around) else stem
        found, number = stem[:LONGEST_NAME].rstrip("_"), 0
        while found.upper() in self._taken or (number == 0 and len(stem) > LONGEST_NAME):
            number += 1
            end = f"_{number}"
            found = stem[: LONGEST_NAME - len(end)].rstrip("_") + end
        return found
