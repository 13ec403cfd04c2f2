# %% [markdown]
# # Closed chains
#
# Parallelograms carry the weight of palletizers, and two motors on one beam drive a gantry. A loop is cut at one joint,
# and the equations that close it decide which joints follow.

# %%
import numpy as np

import symoro_elastic as se

machine = se.read("examples/palletizer.toml")
se.picture(machine)

# %%
machine

# %% [markdown]
# ## Which joints follow
#
# Four motors move it; the other joints follow in closed form, so the models need the positions of the motors only.

# %%
model = se.load(machine, "inverse_dynamics", "direct_dynamics")
q = np.array([0.2, -1.0, 0.3, 0.1])
tau, _ = model.inverse_dynamics(q, np.zeros(4), np.zeros(4))
np.round(tau, 3)

# %% [markdown]
# These torques hold its weight. The direct model with the same torques gives no acceleration:

# %%
np.abs(model.direct_dynamics(q, np.zeros(4), tau)).max()

# %% [markdown]
# ## Is it right?
#
# `check` compares the generated code with references of 50 digits, which close the loops by themselves.

# %%
se.check(machine, "inverse_dynamics")

# %% [markdown]
# ## How the loops are closed
#
# The equations of the loops, in the order in which they are solved:

# %%
four_bar = se.read("examples/four_bar.par")
se.equations(four_bar, "geometric_model")
