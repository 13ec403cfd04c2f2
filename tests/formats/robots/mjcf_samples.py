"""Robots in MJCF, written for the tests, and random ones."""

from __future__ import annotations

import numpy as np

SPRINGS = """
<mujoco model="springs">
  <compiler angle="degree"/>
  <worldbody>
    <body name="shoulder" pos="0.1 -0.2 0.3" euler="20 -35 70">
      <joint name="swing" pos="0.02 0.01 -0.03" axis="1 2 -3" ref="15" armature="0.3" damping="0.7" frictionloss="0.4"/>
      <inertial pos="0.1 0.05 -0.02" mass="2.5" fullinertia="0.05 0.07 0.06 0.004 -0.003 0.002"/>
      <body name="slider" pos="0.4 0 0.1" quat="1 2 -1 0.5">
        <joint name="slide" type="slide" axis="0.3 -1 0.2" ref="0.05" stiffness="300" springref="0.02" damping="4"/>
        <inertial pos="0 0.02 0.1" quat="1 0.2 0.3 -0.4" mass="1.5" diaginertia="0.01 0.02 0.025"/>
        <body name="wrist" pos="0 0.3 0" euler="0 90 0">
          <joint name="bend" axis="0 0 1" ref="-10" stiffness="12" springref="25" armature="0.02" damping="0.1"/>
          <inertial pos="0.05 0 0" mass="0.8" diaginertia="0.004 0.003 0.005"/>
          <body name="hand" pos="0.2 0 0">
            <joint name="spin" axis="1 0 0" damping="0.05"/>
            <inertial pos="0.01 0.02 0.03" mass="0.4" diaginertia="0.001 0.002 0.0015"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="drive" joint="swing" gear="-3" armature="0.01" damping="0.2"/></actuator>
</mujoco>
"""
"""Springs without motors, all that acts on a joint, references, an actuator with a rotor behind its gear."""

SEVERAL = """
<mujoco model="several">
  <worldbody>
    <body name="pedestal" pos="0 0 0.5" euler="0 0 40">
      <geom type="box" size="0.2 0.2 0.5"/>
      <body name="carriage" pos="0 0 0.5">
        <joint name="along" type="slide" axis="1 0 0"/>
        <joint name="across" type="slide" axis="0 1 0"/>
        <joint name="turn" axis="0 0.2 1" pos="0.1 0.2 0"/>
        <joint name="tilt" axis="1 0 0.1" pos="-0.1 0 0.3" ref="0.2"/>
        <geom type="capsule" fromto="0 0 0 0.3 0.1 0.2" size="0.05" density="1500"/>
        <body name="tool" pos="0.3 0.1 0.2" euler="30 0 60">
          <geom type="box" size="0.05 0.02 0.1" mass="0.7"/>
          <body name="camera" pos="0 0 0.15" euler="90 10 0"/>
        </body>
        <body pos="0 -0.2 0"><joint axis="1 1 1"/><geom type="sphere" size="0.08" pos="0.1 0 0"/></body>
      </body>
    </body>
    <body name="table" pos="2 0 0"><geom type="box" size="1 1 0.1"/></body>
  </worldbody>
</mujoco>
"""
"""Several joints on a body, inertias of shapes, a frame on a leaf, a body and joints without names, scenery."""

SPRUNG_MOTORS = """
<mujoco model="sprung_motors">
  <option gravity="1 -2 -9"/>
  <default>
    <joint armature="0.05" damping="0.3"/>
    <default class="stiff"><joint stiffness="40"/></default>
  </default>
  <worldbody>
    <body name="link1"><joint name="j1" class="stiff" axis="0 1 0" springref="17"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.04"/>
      <body name="link2" pos="0 0 0.4"><joint name="j2" class="stiff" axis="0 1 0.5" ref="20"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
        <body name="link3" pos="0.3 0 0"><joint name="j3" type="slide" axis="1 0 0" stiffness="200" springref="0.1"/>
          <geom type="box" size="0.03 0.04 0.05"/></body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="j1"/><position joint="j2" kp="50"/><motor joint="j3" gear="10"/></actuator>
</mujoco>
"""
"""Motors with springs beside them."""

FLOATING = """
<mujoco model="crawler">
  <worldbody>
    <body name="trunk" pos="0 0 1">
      <freejoint name="root"/>
      <geom type="box" size="0.3 0.2 0.1" pos="0.05 0.02 0"/>
      <body name="front" pos="0.3 0 0"><joint name="hip" axis="0 1 0"/>
        <geom type="capsule" size="0.03 0.2" pos="0 0 -0.2"/>
        <body pos="0 0 -0.4"><joint name="knee" axis="0 1 0" stiffness="3"/><geom type="sphere" size="0.06"/></body>
      </body>
      <body name="tail" pos="-0.3 0 0"><joint name="wag" axis="0 0 1" armature="0.01"/>
        <geom type="box" size="0.1 0.02 0.03"/></body>
    </body>
  </worldbody>
  <actuator><motor joint="hip"/><motor joint="wag"/></actuator>
</mujoco>
"""
HULL = """
<mujoco model="hull"><worldbody><body name="hull" pos="0 0 1" euler="20 0 10"><freejoint/>
  <inertial pos="0.1 0.02 -0.05" mass="3" fullinertia="0.05 0.07 0.06 0.004 -0.003 0.002"/>
  <body name="mast" pos="0.2 0 0.1"><geom type="box" size="0.01 0.02 0.3"/><site name="lamp" pos="0 0 0.3"/></body>
</body></worldbody></mujoco>
"""
"""A floating body without joints."""
SWITCHED_OFF = """
<mujoco model="switched_off">
  <option><flag gravity="disable" spring="disable" damper="disable"/></option>
  <worldbody><body><joint name="a" axis="0 1 0" stiffness="5" damping="1" armature="0.1"/>
    <geom size="0.1" pos="0.2 0 0"/>
    <body pos="0.4 0 0"><joint name="b" axis="0 1 0"/><geom size="0.1" pos="0.1 0 0"/></body></body></worldbody>
</mujoco>
"""
COPIES = """
<mujoco model="copies">
  <compiler angle="radian" inertiafromgeom="true"/>
  <worldbody>
    <frame pos="0 0 0.3" euler="0.4 0 0">
      <body name="hub"><joint name="axle" axis="0 0 1" ref="0.3"/>
        <inertial pos="0 0 0" mass="99" diaginertia="9 9 9"/><geom type="cylinder" size="0.2 0.05"/>
        <replicate count="3" euler="0 0 2.0943951023931953" sep="_">
          <body name="arm" pos="0.25 0 0"><joint name="lift" axis="0 1 0"/>
            <geom type="box" size="0.1 0.02 0.02" pos="0.1 0 0"/></body>
        </replicate>
      </body>
    </frame>
  </worldbody>
</mujoco>
"""
"""Frames, copies, inertias of shapes in place of given ones."""

FINGER = """
<body name="{s}_lever" pos="0 {y} 0.06" quat="{q}">
  <inertial mass="0.011" pos="0 0.02 0.002" diaginertia="3e-6 2.5e-6 1e-6"/>
  <joint name="{s}_drive" armature="0.004" damping="0.08"/>
  <body name="{s}_bar" pos="0 0.03 -0.005">
    <inertial mass="0.013" pos="0 0.002 0.02" diaginertia="4e-6 3e-6 1.5e-6"/><joint name="{s}_pin"/></body></body>
<body name="{s}_rocker" pos="0 {z} 0.066" quat="{q}">
  <inertial mass="0.02" pos="0 0.02 0.02" diaginertia="9e-6 6e-6 4e-6"/>
  <joint name="{s}_sprung" stiffness="0.06" springref="1.9" damping="0.0015"/>
  <body name="{s}_tip" pos="0 0.05 0.04">
    <inertial mass="0.012" pos="0 -0.01 0.012" diaginertia="3e-6 2e-6 1.5e-6"/>
    <joint name="{s}_turn" pos="0 -0.02 0.006"/><site name="{s}_pad" pos="0 -0.02 0.03" euler="0 0 40"/></body></body>
"""
GRIPPER = f"""
<mujoco model="gripper"><default><joint axis="1 0 0"/></default><worldbody><body name="palm" euler="20 0 30">
{FINGER.format(s="right", y=0.028, z=0.012, q="1 0 0 0")}{FINGER.format(s="left", y=-0.028, z=-0.012, q="0 0 0 1")}
</body></worldbody>
<tendon><fixed name="both"><joint joint="right_drive" coef="0.5"/>
<joint joint="left_drive" coef="0.5"/></fixed></tendon>
<equality><connect anchor="0 0.001 0" body1="right_tip" body2="right_bar"/>
<connect anchor="0 0.001 0" body1="left_tip" body2="left_bar"/>
<joint joint1="right_drive" joint2="left_drive" polycoef="0 1 0 0 0"/></equality>
<actuator><general tendon="both" gear="2"/></actuator></mujoco>
"""
"""Two fingers of five bars, whose levers are coupled and driven by one tendon."""

ROBOTS = {
    "springs": SPRINGS,
    "several": SEVERAL,
    "sprung_motors": SPRUNG_MOTORS,
    "floating": FLOATING,
    "damped_base": FLOATING.replace('<freejoint name="root"/>', '<joint type="free" name="root" damping="0.7"/>'),
    "hull": HULL,
    "switched_off": SWITCHED_OFF,
    "copies": COPIES,
}


def random_robot(seed: int) -> str:
    """A random tree of 2 to 7 bodies with odd places, joints at odd points, springs, rotors and refs."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 8))
    inside: list[list[int]] = [[] for _ in range(count + 1)]
    for k in range(1, count + 1):
        inside[int(rng.integers(max(0, k - 3), k))].append(k)
    text, driven = _body(rng, inside, 0)
    motors = "".join(f'<motor joint="{name}" gear="{rng.uniform(-5, 5)!r}"/>' for name in driven)
    return f"<mujoco><worldbody>{text}</worldbody><actuator>{motors}</actuator></mujoco>"


def _body(rng: np.random.Generator, inside: list[list[int]], k: int) -> tuple[str, list[str]]:
    own, driven = ("", []) if k == 0 else _joints(rng, k)
    for child in inside[k]:
        text, names = _body(rng, inside, child)
        own, driven = own + text, driven + names
    if k == 0:
        return own, driven
    place = f'pos="{_numbers(rng, 3, 0.4)}" quat="{_numbers(rng, 4, 1)}"'
    return f'<body name="body_{k}" {place}>{own}</body>', driven


def _joints(rng: np.random.Generator, k: int) -> tuple[str, list[str]]:
    text, driven = "", []
    for i in range(int(rng.integers(1, 3))):
        slides, motor, sprung = rng.random() < 0.25, rng.random() < 0.6, rng.random() < 0.3
        name, ref = f"joint_{k}{'ab'[i]}", rng.uniform(-0.3, 0.3) if slides else rng.uniform(-60, 60)
        forces = f'damping="{rng.uniform(0, 2)!r}" armature="{rng.uniform(0.01, 0.5)!r}" ref="{ref!r}"'
        if sprung:
            forces += f' stiffness="{rng.uniform(5, 50)!r}" springref="{rng.uniform(-0.3, 0.3)!r}"'
        axis = rng.choice(["0 0 1", "0 1 0", "1e-9 0 1", _numbers(rng, 3, 1)])
        kind = "slide" if slides else "hinge"
        text += f'<joint name="{name}" type="{kind}" axis="{axis}" pos="{_numbers(rng, 3, 0.2)}" {forces}/>'
        driven += [name] if motor else []
    inertia = f'diaginertia="{_numbers(rng, 3, 0.01, 0.03)}" quat="{_numbers(rng, 4, 1)}"'
    return text + f'<inertial pos="{_numbers(rng, 3, 0.1)}" mass="{rng.uniform(0.5, 3)!r}" {inertia}/>', driven


def _numbers(rng: np.random.Generator, count: int, most: float, middle: float = 0.0) -> str:
    return " ".join(repr(float(x)) for x in middle + rng.uniform(-most, most, count))
