"""Bodies by modes of finite elements, and how many joints and modes the parts of a machine need."""
