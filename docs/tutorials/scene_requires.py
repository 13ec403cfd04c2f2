# %% [markdown]
# # What a scene requires
#
# A machine has more springs than a motion needs. From a motion and a tolerance to the smallest model: which springs
# matter, which step suffices, and what is lost.

# %%
import symoro_elastic as se

machine = se.read("examples/two_axis.toml")
scene = "examples/scenes/two_axis_move.toml"

# %% [markdown]
# The tool moves by 80 mm and 50 mm in 150 ms; it must be within 10 um of the machine with all ten springs.
#
# ## The motion itself

# %%
(simulation,) = se.simulate(machine, scene)
simulation

# %%
simulation.plot("deviation")

# %% [markdown]
# ## The ladder of models
#
# Springs are left out one after the other, least important first. The error is predicted by the linear machine along
# the motion, and measured at the rungs near the tolerance.

# %%
ladder = se.ladder(machine, scene)
ladder

# %%
ladder.plot("rungs")

# %% [markdown]
# The sentence below the table is the advice. Every chosen model was simulated together with the full machine.

# %%
print(ladder.parts()[-1])

# %% [markdown]
# On the command line `symoro-elastic ladder ... --save reduced.toml` writes this scene, and `generate --scene
# reduced.toml` the models of what is left: see the guide "From a motion to real time".
