"""Functions of a program as C: its text, results, steps, wrappers; batches of states."""
