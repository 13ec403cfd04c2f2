# %% [markdown]
# # From a log to the machine
#
# A controller logs positions and torques. This tutorial designs a motion that shows the parameters, lets an arm that we
# know only as a log follow it, identifies, and reads what was found and what was not.

# %%
from pathlib import Path

import numpy as np

import symoro_elastic as se

machine = se.read("examples/planar_2r.toml")
machine

# %% [markdown]
# ## An exciting motion
#
# A sum of harmonics whose coefficients make the equations well conditioned, within limits of positions, velocities and
# accelerations.

# %%
motion = se.excite(machine, position=(-1.2, 1.2), velocity=3.0, acceleration=15.0, evaluations=200)
motion

# %% [markdown]
# ## The log
#
# The arm on the shop floor carries a heavier second link than the file says. It is simulated here, with encoders of 20
# bits and noise of the torques; all that the cells after this one see of it is the log.

# %%
text = Path("examples/planar_2r.toml").read_text(encoding="utf-8")
Path("floor.toml").write_text(text.replace("m2  = { value = 1.5,", "m2  = { value = 1.9,"), encoding="utf-8")
floor = se.load(se.read("floor.toml"), "inverse_dynamics")

rng = np.random.default_rng(1)
t = np.arange(0, 30, 0.002)
q, qd, qdd = motion.best.motion.at(t)
tau = floor.inverse_dynamics(q, qd, qdd)[0] + 0.05 * rng.standard_normal(q.shape)
step = 2 * np.pi / 2**20
log = {"t": t} | {f"q_{name}": np.round(q[:, k] / step) * step for k, name in enumerate(["shoulder", "elbow"])}
log |= {f"tau_{name}": tau[:, k] for k, name in enumerate(["shoulder", "elbow"])}

# %% [markdown]
# ## Identification
#
# Velocities and accelerations come from filtered positions, standard deviations from the residuals. Parameters that the
# motion cannot distinguish are grouped; each line has a standard deviation.

# %%
found = se.identify(machine, log)
found

# %%
found.plot()

# %% [markdown]
# ## Does it predict?
#
# A machine file that predicts the motion it was made from proves little. Another motion of the same arm:

# %%
other = se.excite(machine, position=(-1.0, 1.0), velocity=2.0, acceleration=10.0, evaluations=100, seed=3)
q, qd, qdd = other.best.motion.at(t)
fresh = {"t": t} | {f"q_{name}": q[:, k] for k, name in enumerate(["shoulder", "elbow"])}
fresh |= {
    f"tau_{name}": x for name, x in zip(["shoulder", "elbow"], floor.inverse_dynamics(q, qd, qdd)[0].T, strict=True)
}
se.identify(machine, log, validate=fresh)
