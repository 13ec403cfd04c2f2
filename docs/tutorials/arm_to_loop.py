# %% [markdown]
# # An arm from URDF to a loop of 1 kHz
#
# A URDF file describes rigid links. This tutorial adds the elasticity of gears, checks the model, and makes the C
# function that a controller calls every millisecond.

# %%
import numpy as np

import symoro_elastic as se

rigid = se.read("examples/pendant_arm.urdf", snap=1e-9)
rigid

# %% [markdown]
# ## Elastic gears
#
# Each joint becomes its motor, with the inertia of the rotor as the joint feels it, and a spring behind it.

# %%
arm = se.read("examples/pendant_arm.urdf", snap=1e-9, elastic={"shoulder": (8e4, 1.6), "elbow": (3e4, 0.7)})
se.modes(arm, hold=["all"], at={"elbow": 1.2})

# %% [markdown]
# ## Is the model right?
#
# `check` compares generated code with references of 50 digits at ordinary and extreme states.

# %%
se.check(rigid, "inverse_dynamics")

# %% [markdown]
# ## The function
#
# Compiled C, called from Python with the same signature. On a controller the same C is called directly.

# %%
model = se.load(rigid, "inverse_dynamics", "direct_dynamics", backend="c")
q, qd, qdd = np.array([0.1, 0.3, -0.5, 0.2]), np.array([0.2, 0.4, 0.1, 0.0]), np.array([1.0, -2.0, 0.5, 3.0])
tau, _ = model.inverse_dynamics(q, qd, qdd)
again = model.direct_dynamics(q, qd, tau)
np.abs(again - qdd).max()

# %% [markdown]
# ## A loop of 1 kHz
#
# Computed torque: the model cancels inertia, gravity and friction; double integrators remain, closed here
# with 10 Hz. The motor of the third joint gives 5 % less than commanded.

# %%
w, h = 2 * np.pi * 10, 1e-3
wanted = np.array([0.4, 0.6, -0.9, 0.0])
q, qd = np.array([0.1, 0.3, -0.5, 0.2]), np.zeros(4)
errors = []
for _ in range(400):
    a = w**2 * (wanted - q) - 2 * w * qd
    tau, _ = model.inverse_dynamics(q, qd, a)
    qdd = model.direct_dynamics(q, qd, tau * [1, 1, 0.95, 1])
    qd = qd + h * qdd
    q = q + h * qd
    errors.append(np.abs(wanted - q).max())
print(f"largest error after 0.1 s {errors[99]:.4f} rad, after 0.4 s {errors[-1]:.5f} rad")

# %% [markdown]
# ## Files for the controller
#
# `generate` writes C with a header, an example program and the numpy module; `--target st` and `linuxcnc` write
# Structured Text and LinuxCNC components instead.

# %%
se.generate(rigid, "inverse_dynamics", out="arm")
