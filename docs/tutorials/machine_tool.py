# %% [markdown]
# # Which spring limits a machine tool
#
# The two-axis machine of the paper: two linear motors, an elastic bed, and a cart, a ram and chains that yield. Which
# of its ten springs limits the bandwidth, where, and what would a stiffer one bring?

# %%
import symoro_elastic as se

machine = se.read("examples/two_axis.toml")
se.picture(machine)

# %% [markdown]
# ## Modes
#
# With the motors held, springs and masses vibrate. The share of the strain energy says which spring a mode bends.

# %%
modes = se.modes(machine, hold=["all"])
modes

# %%
modes.plot("energies")

# %%
print(modes.parts()[-1])

# %% [markdown]
# The last sentence names the spring, and by how much 1 % more of it would help: the exact derivative.
#
# ## At the tool
#
# What the process feels is the compliance between force and motion of the tool. Not every mode shows there.

# %%
response = se.response(machine, inputs=["tool.fx"], outputs=["tool.x"], hold=["all"], damping=0.02)
response

# %%
response.plot("stiffness_tool_x")

# %% [markdown]
# ## Where it stands
#
# The position of the motors changes masses and levers, so the limit may change, too.

# %%
for y in (0.0, 0.2, 0.4):
    there = se.modes(machine, hold=["all"], at={"motor_y": y})
    print(f"motor_y at {y:.1f} m: {there.frequencies[0]:.2f} Hz; {there.parts()[-1].split(', is ')[-1]}")

# %% [markdown]
# ## A stiffer variant
#
# The first frequency with a yaw spring of half, once and twice the stiffness:

# %%
swept = se.sweep(machine, over={"bed_yaw.stiffness": [2e7, 4e7, 8e7]}, hold=["all"], results=["frequency_1"])
swept
