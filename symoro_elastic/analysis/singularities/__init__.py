"""Where a frame loses a direction: the factors of the determinant of its Jacobian, and what happens at their zeros."""
