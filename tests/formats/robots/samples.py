"""Small robots in URDF: written by hand, and random ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hypothesis import strategies as st

ARM = """<?xml version="1.0"?>
<!-- An arm with a slide, a tool on a fixed link, and axes in any direction. -->
<robot name="arm">
  <link name="ground"/>
  <link name="column">
    <inertial>
      <origin xyz="0.01 -0.02 0.2" rpy="0.3 0 -0.2"/>
      <mass value="8.5"/>
      <inertia ixx="0.11" ixy="0.002" ixz="-0.003" iyy="0.12" iyz="0.001" izz="0.04"/>
    </inertial>
    <visual><geometry><mesh filename="package://arm/column.dae"/></geometry></visual>
  </link>
  <link name="upper">
    <inertial>
      <origin xyz="0.2 0 0.01"/>
      <mass value="4"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.06"/>
    </inertial>
  </link>
  <link name="cover">
    <inertial>
      <origin xyz="0 0.05 0" rpy="0 0 0.7"/>
      <mass value="0.4"/>
      <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.003" iyz="0" izz="0.004"/>
    </inertial>
  </link>
  <link name="fore">
    <inertial>
      <origin xyz="0 0 0.15" rpy="0 0 0"/>
      <mass value="2.5"/>
      <inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.02" iyz="0" izz="0.005"/>
    </inertial>
  </link>
  <link name="ram">
    <inertial>
      <origin xyz="0 0.01 0.1" rpy="0 0 0"/>
      <mass value="1.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.002"/>
    </inertial>
  </link>
  <link name="tool"/>
  <joint name="waist" type="revolute">
    <origin xyz="0 0 0.1" rpy="0 0 0.4"/>
    <parent link="ground"/><child link="column"/>
    <axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="100" velocity="2"/>
    <dynamics damping="0.8" friction="0.3"/>
  </joint>
  <joint name="shoulder" type="continuous">
    <origin xyz="0.05 0.12 0.3" rpy="0 1.5707963267948966 0"/>
    <parent link="column"/><child link="upper"/>
    <axis xyz="0 -1 0"/>
  </joint>
  <joint name="cover_joint" type="fixed">
    <origin xyz="0.1 0.02 0" rpy="0.2 -0.1 0"/>
    <parent link="upper"/><child link="cover"/>
  </joint>
  <joint name="elbow" type="revolute">
    <origin xyz="0.4 0 0.03" rpy="0.1 -0.7 0.25"/>
    <parent link="upper"/><child link="fore"/>
    <axis xyz="0.6 0 0.8"/>
    <limit lower="-3" upper="3" effort="100" velocity="2"/>
  </joint>
  <joint name="slide" type="prismatic">
    <origin xyz="0.02 0 0.25" rpy="-0.3 0.2 0"/>
    <parent link="fore"/><child link="ram"/>
    <limit lower="0" upper="0.2" effort="100" velocity="2"/>
    <dynamics damping="12"/>
  </joint>
  <joint name="flange" type="fixed">
    <origin xyz="0 0.1 0.2" rpy="0.5 0.4 -1.2"/>
    <parent link="ram"/><child link="tool"/>
  </joint>
</robot>
"""


def link(name: str, mass: float = 1.0) -> str:
    """A link without a product of inertia in its principal axes, which are turned."""
    return f"""
  <link name="{name}"><inertial>
    <origin xyz="0.1 0.02 -0.05" rpy="0.3 0.2 0.1"/><mass value="{mass!r}"/>
    <inertia ixx="0.02" ixy="0.001" ixz="-0.002" iyy="0.03" iyz="0.0015" izz="0.04"/>
  </inertial></link>"""


def joint(
    name: str,
    parent: str,
    child: str,
    type_: str = "revolute",
    xyz: Sequence[float] = (0.3, 0.0, 0.0),
    rpy: Sequence[float] = (0.0, 0.0, 0.0),
    axis: Sequence[float] = (0.0, 0.0, 1.0),
    inside: str = "",
) -> str:
    limit = '<limit lower="-9" upper="9" effort="9" velocity="9"/>'
    place, turn, direction = (" ".join(map(repr, map(float, x))) for x in (xyz, rpy, axis))
    return f"""
  <joint name="{name}" type="{type_}"><origin xyz="{place}" rpy="{turn}"/>
    <parent link="{parent}"/><child link="{child}"/><axis xyz="{direction}"/>{limit}{inside}</joint>"""


def robot(*elements: str, name: str = "sample") -> str:
    return f'<robot name="{name}">' + "".join(elements) + "\n</robot>\n"


GRIPPER = robot(
    '<link name="base"/>',
    *(link(name) for name in ("wrist", "left", "right", "thumb")),
    joint("turn", "base", "wrist", xyz=(0, 0, 0.2)),
    joint("left_finger", "wrist", "left", "prismatic", (0.1, 0.05, 0), axis=(0, 1, 0)),
    joint(
        *("right_finger", "wrist", "right", "prismatic", (0.1, -0.05, 0), (0, 0, math.pi), (0, 1, 0)),
        inside='<mimic joint="left_finger" multiplier="0.5" offset="0.01"/>',
    ),
    joint(
        *("thumb_joint", "right", "thumb", "revolute", (0.05, 0.1, 0.2), (0.4, 0, 0), (1, 0, 0)),
        inside='<mimic joint="right_finger" multiplier="-30"/><dynamics damping="0.2"/>',
    ),
    name="gripper",
)
"""Two slides and a joint that follow one finger, one through the other."""


@dataclass(frozen=True)
class RandomJoint:
    """A joint of a random robot, on the link with this number."""

    parent: int
    type: str
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    axis: tuple[float, ...]


TILTS = (0.0, 1e-15, 3e-13, -2e-9, 1e-6, 5e-4, 8e-3)
"""Angles by which nearly parallel axes differ, rad."""
ANGLES = st.one_of(
    st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi, 1.57079632679, 3.14159265359, 0.785398]),
    st.sampled_from(TILTS),
    st.floats(-3.2, 3.2),
)
LENGTHS = st.one_of(st.sampled_from([0.0, 0.1, -0.25, 1e-12]), st.floats(-0.6, 0.6))
AXES = st.one_of(
    st.sampled_from([(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 1e-8, 1.0), (0.577, 0.577, -0.577)]),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: math.hypot(*axis) > 0.1),
)
TYPES = st.sampled_from(["revolute", "revolute", "revolute", "continuous", "prismatic", "fixed"])


@st.composite
def random_robots(draw: st.DrawFn) -> str:
    """A tree of one to six joints, with at least one that moves."""
    count = draw(st.integers(1, 6))
    joints = [
        RandomJoint(
            draw(st.integers(max(0, k - 2), k)),
            draw(TYPES) if k else "revolute",
            tuple(draw(LENGTHS) for _ in range(3)),
            tuple(draw(ANGLES) for _ in range(3)),
            draw(AXES),
        )
        for k in range(count)
    ]
    links = [link(f"link{k}", 0.5 + k) for k in range(count + 1)]
    rows = [
        joint(f"joint{k}", f"link{one.parent}", f"link{k + 1}", one.type, one.xyz, one.rpy, one.axis)
        for k, one in enumerate(joints)
    ]
    return robot(*links, *rows)
