"""Machines with couplings and closed loops, and states of them, to test the program against `tests.references`.

- `machines/`: machine files;
- `data/`: states of each, and for four of them the results of another program to 25 digits;
- `machines`: both, read;
- `states`: draws the states: `python -m tests.closed_chains.states NAME`.
"""
