"""The motion of a machine in numbers: equations of motion, equilibria."""
