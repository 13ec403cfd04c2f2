"""Evidence that the generated models are compared with: independent of the equations and of the symbolic layer.

- `random_machines`: machines to try;
- `multiprecision`: every model to 50 digits, from world-frame Jacobians and derivatives of the frames' positions;
- `pinocchio_model`: the same machines in the C++ library Pinocchio;
- `lagrange`: A and H of small machines from Lagrange's equations;
- `constraint_multipliers`, `virtual_work`: machines with couplings and loops to 70 digits, by multipliers on the free
  tree and by d'Alembert's principle on power series of placements; `closed_chains` closes the loops for both.

Only the reading of the table into numbers (`numbers_of_machine`) is common to them.
"""
