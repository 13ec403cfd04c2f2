"""The longest way through listings that are written by hand: branches, loops, calls, what has no bound."""

from __future__ import annotations

import pytest

from symoro_elastic.codegen.embedded.disassembly import UnknownProcessor, functions
from symoro_elastic.codegen.embedded.report import LoopBounds, Unbounded, flow, loop_bounds, most

HEAD = "\nt.o:     file format elf32-littlearm\n\nDisassembly of section .text:\n\n00000000 <f>:\nf():\n"


def listing(text: str, head: str = HEAD) -> str:
    """Lines `number: address instruction` as objdump prints them; a line without an address is taken as it is."""
    lines = []
    for line in text.strip().splitlines():
        number, _, rest = line.strip().partition(": ")
        address, _, instruction = rest.partition(" ")
        lines += [line] if line.startswith("\t") else [f"/tmp/t.c:{number}", f"   {address}:\t{instruction}"]
    return head + "\n".join(lines) + "\n"


def executed(text: str, bounds: dict[int, int], around: dict[int, int] | None = None) -> int:
    (code,) = functions(listing(text))[0].values()
    return most(flow(code), lambda _: 1, LoopBounds(bounds, around or {}))


def test_of_two_branches_the_longer_one_counts() -> None:
    text = """
    1: 0 cmp r0, #0
    1: 2 beq.n a <f+0xa>
    2: 4 adds r0, #1
    2: 6 adds r0, #1
    2: 8 b.n c <f+0xc>
    3: a adds r0, #2
    4: c bx lr
    """
    assert executed(text, {}) == 6


def test_a_loop_runs_as_often_as_its_line_says() -> None:
    text = """
    1: 0 movs r3, #0
    3: 2 adds r0, #1
    2: 4 adds r3, #1
    2: 6 cmp r3, #5
    2: 8 bne.n 2 <f+0x2>
    4: a bx lr
    """
    assert executed(text, {2: 5}) == 1 + 5 * 4 + 1


def test_a_condition_at_the_top_is_tested_once_more() -> None:
    text = """
    1: 0 movs r3, #0
    2: 2 cmp r3, #5
    2: 4 beq.n c <f+0xc>
    3: 6 adds r0, #1
    2: 8 adds r3, #1
    2: a b.n 2 <f+0x2>
    4: c bx lr
    """
    assert executed(text, {2: 5}) == 1 + 5 * 5 + 2 + 1


def test_loops_in_loops_multiply() -> None:
    text = """
    1: 0 movs r3, #0
    2: 2 movs r4, #0
    3: 4 adds r0, #1
    2: 6 adds r4, #1
    2: 8 cmp r4, #4
    2: a bne.n 4 <f+0x4>
    1: c adds r3, #1
    1: e cmp r3, #3
    1: 10 bne.n 2 <f+0x2>
    4: 12 bx lr
    """
    assert executed(text, {1: 3, 2: 4}) == 1 + 3 * (1 + 4 * 4 + 3) + 1


POOL = """
    1: 0 cmp r0, #0
    1: 2 beq.n 14 <f+0x14>
    2: 4 adds r0, #1
    2: 6 b.n 10 <f+0x10>
    2: 8 .word 0x00000000
\t\t\t8: R_ARM_ABS32\t.rodata
    2: c .word 0x3f800000
    3: 10 adds r0, #1
    3: 12 adds r0, #1
    4: 14 bx lr
    """


def test_a_jump_over_words_keeps_its_target() -> None:
    """The relocation of a word in a pool of literals is not one of the jump before it."""
    (code,) = functions(listing(POOL))[0].values()
    assert [(one.address, one.target, one.callee) for one in code.instructions if one.target >= 0 or one.callee] == [
        (2, 0x14, ""),
        (6, 0x10, ""),
    ]
    assert executed(POOL, {}) == 7


def test_loops_without_a_bound_are_not_guessed() -> None:
    text = """
    2: 0 adds r0, #1
    2: 2 bne.n 0 <f>
    3: 4 bx lr
    """
    with pytest.raises(Unbounded, match="2"):
        executed(text, {})


def test_computed_jumps_are_not_guessed() -> None:
    with pytest.raises(Unbounded, match="1"):
        executed("1: 0 tbb [pc, r0]\n2: 4 bx lr", {})


def test_returns_under_a_condition_end_some_ways_only() -> None:
    text = """
    1: 0 cmp r0, #0
    1: 2 it eq
    1: 4 bxeq lr
    2: 6 adds r0, #1
    2: 8 pop {r4, pc}
    """
    assert executed(text, {}) == 5


def test_calls_are_told_by_the_symbol_that_the_linker_puts_in() -> None:
    text = "1: 0 push {r4, lr}\n2: 2 bl 0 <sinf>\n\t\t\t2: R_ARM_THM_CALL\tsinf\n3: 6 pop {r4, pc}"
    (code,) = functions(listing(text))[0].values()
    assert [one.callee for one in code.instructions] == ["", "sinf", ""]


def test_processors_that_are_not_read_are_named() -> None:
    with pytest.raises(UnknownProcessor, match="elf32-avr"):
        functions(listing("1: 0 ret", HEAD.replace("elf32-littlearm", "elf32-avr")))


def test_bounds_of_loops_are_read_from_the_text() -> None:
    source = """\
    for (size_t i = 0U; i < 3U; i++) {
        for (size_t j = i + 1U; j < 2U*9U; j++) {
        for (size_t k = 0U; k < i; k++) {
    for (size_t k = 0U; k < count; k++) {
    for (size_t k = 0U; k < n; k++) {
    while (large > 0U) {"""
    assert loop_bounds(source, 4).of == {1: 3, 2: 18, 3: 3, 4: 4, 6: 4}


def test_loops_around_a_line_are_known() -> None:
    source = """\
    for (size_t i = 0U; i < 3U; i++) {
        for (size_t j = 0U; j < 2U; j++) {
            x[i] += y[j];
        }
        x[i] = z;
    }
    x[0] = 1.0;"""
    assert loop_bounds(source, 0).around == {2: 3, 3: 3, 4: 3, 5: 3}


def test_a_loop_whose_own_line_is_gone_runs_as_often_as_those_around_its_lines() -> None:
    text = """
    1: 0 movs r3, #0
    3: 2 adds r0, #1
    3: 4 cmp r3, r0
    3: 6 bne.n 2 <f+0x2>
    4: 8 bx lr
    """
    assert executed(text, {2: 5}, {3: 5}) == 1 + 5 * 3 + 1
