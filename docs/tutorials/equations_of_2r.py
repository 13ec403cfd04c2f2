# %% [markdown]
# # The equations of two links
#
# A planar arm with two turning joints is small enough to read, and holds all that the equations of larger machines
# hold: inertia that depends on the position, centrifugal and Coriolis terms, gravity.

# %%
import numpy as np

import symoro_elastic as se

machine = se.read("examples/planar_2r.toml")
machine

# %% [markdown]
# The table of geometric parameters says where each joint is: `d` is the length of the link before it, `alpha` the angle
# between the axes. Both axes are parallel, so `alpha` is zero.

# %%
se.picture(machine)

# %% [markdown]
# ## The inverse dynamic model
#
# Torques from positions, velocities and accelerations, by the recursion of Newton and Euler: out along the chain for
# velocities and accelerations, back for forces. The equations keep the paper's numbers.

# %%
equations = se.equations(machine, "inverse_dynamics")
equations

# %% [markdown]
# As a function, here with numbers:

# %%
model = se.load(machine, "inverse_dynamics", "inertia_matrix")
q, qd, qdd = [0.3, 0.8], [0.5, -0.2], [1.0, 2.0]
tau, _ = model.inverse_dynamics(q, qd, qdd)
tau

# %% [markdown]
# ## The same by Lagrange
#
# Torques are linear in accelerations: the inertia matrix is their slope. Columns by differences of the inverse model
# are those of the model `inertia_matrix`.

# %%
at_rest, _ = model.inverse_dynamics(q, [0, 0], [0, 0])
columns = np.array([model.inverse_dynamics(q, [0, 0], row)[0] for row in np.eye(2)]) - at_rest
np.abs(columns - model.inertia_matrix(q)).max()

# %% [markdown]
# ## Base parameters
#
# Ten numbers describe a body, but a motion shows only some of their combinations. These are the ones that torques
# depend on: what identification can find, and what a shorter model computes with.

# %%
se.equations(machine, "base_parameters")
