"""Singularities of a frame: the factors of the determinant of its Jacobian, and the lost motion at their zeros."""
