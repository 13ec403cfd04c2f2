"""Machines by axis and point: examples of the repository written so, and random robots."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

TENSOR = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
MOMENTS = ("MX", "MY", "MZ")


def arm_of_six(rows: str, lengths: str, axes: str) -> str:
    """An arm of six joints j1 to j6 whose inertial parameters are names, as the PUMA 560 and the RX90 have them."""
    numbers = range(1, 7)
    named = [f"{name}{j} = nan" for j in numbers for name in ("M", "IA", *MOMENTS, *TENSOR)]

    def texts(names: tuple[str, ...], j: int) -> str:
        return ", ".join(f'"{name}{j}"' for name in names)

    bodies = [
        f'j{j} = {{ mass = "M{j}", first_moments = [{texts(MOMENTS, j)}], inertia_at_origin = [{texts(TENSOR, j)}], '
        f'axes = "{axes}" }}'
        for j in numbers
    ]
    return "\n".join(
        [
            *("gravity = [0, 0, 'G3']", f"joints = [\n{rows}\n]", "[parameters]"),
            *(f"{name} = nan" for name in (*lengths.split(), "G3")),
            *(*named, "[bodies]", *bodies, "[motors]", *(f'j{j} = {{ rotor_inertia = "IA{j}" }}' for j in numbers)),
        ]
    )


RX90 = """
{ name = "j1", kind = "motor", sigma = 0, axis = "z", variable = "th1" },
{ name = "j2", kind = "motor", sigma = 0, axis = "-y", variable = "th2" },
{ name = "j3", kind = "motor", sigma = 0, axis = "-y", at = ["D3", 0, 0], variable = "th3" },
{ name = "j4", kind = "motor", sigma = 0, axis = "z", at = ["D3", 0, "RL4"], variable = "th4" },
{ name = "j5", kind = "motor", sigma = 0, axis = "-y", at = ["D3", 0, "RL4"], variable = "th5" },
{ name = "j6", kind = "motor", sigma = 0, axis = "z", at = ["D3", 0, "RL4"], variable = "th6" },
"""
PUMA560 = """
{ name = "j1", kind = "motor", sigma = 0, axis = "z", variable = "th1" },
{ name = "j2", kind = "motor", sigma = 0, axis = "y", at = [0, "R2", 0], variable = "th2" },
{ name = "j3", kind = "motor", sigma = 0, axis = "y", at = ["D3", "R3", 0], in = "j2", variable = "th3" },
{ name = "j4", kind = "motor", sigma = 0, axis = "-z", at = ["D4", 0, "-RL4"], in = "j3", variable = "th4" },
{ name = "j5", kind = "motor", sigma = 0, axis = "y", in = "j4", variable = "th5" },
{ name = "j6", kind = "motor", sigma = 0, axis = "-z", in = "j4", variable = "th6" },
"""
TWO_AXIS = (
    """joints = [
  { name = "bed_yaw",         antecedent = 0, kind = "elastic", sigma = 0, axis = "z", variable = "q1" },
  { name = "bed_y",           kind = "elastic", sigma = 1, axis = "y" },
  { name = "bed_x",           kind = "elastic", sigma = 1, axis = "x" },
  { name = "motor_secondary", kind = "elastic", sigma = 1, axis = "x", at = [0, "D4", 0] },
  { name = "motor_x",         kind = "motor",   sigma = 1, axis = "x", at = [0, "D4", 0] },
  { name = "cart_yaw",        kind = "elastic", sigma = 0, axis = "z", at = [0, "D4", 0] },
  { name = "cart_x",          kind = "elastic", sigma = 1, axis = "x", at = [0, "D4", 0] },
  { name = "cart_y",          kind = "elastic", sigma = 1, axis = "y", at = [0, "D4", 0] },
  { name = "motor_y",         kind = "motor",   sigma = 1, axis = "y", at = [0, "D4", 0] },
  { name = "y_chain_1",       kind = "elastic", sigma = 1, axis = "y", at = [0, "D4", 0] },
  { name = "ram",             kind = "elastic", sigma = 1, axis = "y", at = [0, "D4", 0] },
  { name = "tool",            kind = "fixed", axis = "y", at = ["D12", "D4 + L12", 0] },
  { name = "sensor_head", antecedent = 5, kind = "elastic", sigma = 1, axis = "x", at = [0, "D13", 0], in = "motor_x" },
]
""",
    {
        "bed_x": "{ mass = 2500, center_of_mass = [0, -0.2, 0], inertia = [900, 700, 1100] }",
        "motor_secondary": "{ mass = 90, center_of_mass = [0, 0, 0], inertia = [12, 1, 12] }",
        "motor_x": "{ mass = 45, center_of_mass = [0, 0, 0], inertia = [3, 0.5, 3] }",
        "cart_y": "{ mass = 210, center_of_mass = [0.02, 0.3, 0], inertia = [14, 12, 16] }",
        "ram": "{ mass = 95, center_of_mass = [0, -0.15, 0], inertia = [6, 3, 7] }",
    },
)
GANTRY = (
    """joints = [
  { name = "carriage_1",  antecedent = 0, kind = "motor", sigma = 1, axis = "y", at = ["-W/2", 0, 0], variable = "y1" },
  { name = "beam",        kind = "elastic", sigma = 0, axis = "z", at = ["-W/2", 0, 0], variable = "yaw" },
  { name = "cross_slide", kind = "motor",   sigma = 1, axis = "x", variable = "x" },
  { name = "ram",         kind = "motor",   sigma = 1, axis = "z", at = [0, 0.15, 0], variable = "z" },
  { name = "tool",        kind = "fixed",   axis = "z", at = [0, 0, -0.6], in = "ram" },
  { name = "carriage_2",  antecedent = 0, kind = "motor", sigma = 1, axis = "y", at = ["W/2", 0, 0], variable = "y2" },
  { name = "pivot",       kind = "passive", sigma = 0, axis = "z", at = ["W/2", 0, 0], variable = "swivel" },
  { name = "guide",       kind = "passive", sigma = 1, axis = "x", at = ["W/2", 0, 0], variable = "stroke" },
  { name = "weld",        kind = "cut", sigma = 2, at = ["W/2", 0, 0] },
  { name = "beam_end",    antecedent = "beam", kind = "fixed", at = ["W", 0, 0], in = "beam" },
]
""",
    {
        "carriage_1": "{ mass = 45, center_of_mass = [0, 0, 0], inertia = [1.2, 1.1, 0.9] }",
        "cross_slide": "{ mass = 60, center_of_mass = [0, 0, 0.05], inertia = [1.2, 1.6, 1.2] }",
        "ram": "{ mass = 35, center_of_mass = [0, 0, -0.2], inertia = [2.4, 2.4, 0.3] }",
        "carriage_2": "{ mass = 40, center_of_mass = [0, 0, 0], inertia = [1.1, 1, 0.8] }",
        "guide": "{ mass = 6, center_of_mass = [0, 0, 0], inertia = [0.03, 0.05, 0.03] }",
    },
)


def turn(axis: str, angle: float) -> np.ndarray:
    """The rotation about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    i, k = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    R = np.eye(3)
    R[i, i] = R[k, k] = c
    R[k, i], R[i, k] = s, -s
    return R


def of_robot(text: str) -> str:
    """The robot of a URDF, without springs and followers, by axes and points of its joints in the root link's frame.

    Links and joints of the file are frames; bodies are in axes of frame 0.
    """
    root = ET.fromstring(text)
    links = {str(one.get("name")): one for one in root.findall("link")}
    joints = {str(one.find("child").get("link")): one for one in root.findall("joint")}  # type: ignore[union-attr]
    placed: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    carrier: dict[str, str] = {}
    rows, bodies = [], []
    frames = [f'"link {next(name for name in links if name not in joints)}" = {{ at = [0, 0, 0] }}']

    def place(link: str) -> tuple[np.ndarray, np.ndarray]:
        if link not in placed:
            joint = joints.get(link)
            placed[link] = (np.eye(3), np.zeros(3)) if joint is None else after(joint)
        return placed[link]

    def after(joint: ET.Element) -> tuple[np.ndarray, np.ndarray]:
        R, p = place(str(joint.find("parent").get("link")))  # type: ignore[union-attr]
        S, t = pose(joint)
        return R @ S, p + R @ t

    for link in [str(one.find("child").get("link")) for one in root.findall("joint")]:  # type: ignore[union-attr]
        joint = joints[link]
        parent = str(joint.find("parent").get("link"))  # type: ignore[union-attr]
        name, R, p = str(joint.get("name")), *place(link)
        before = carrier.get(parent, "")
        carrier[link] = name
        start = f'{{ name = "{name}", antecedent = {repr(before) if before else 0}, at = {listed(p)}, kind = '
        if joint.get("type") == "fixed":
            rows.append(f'{start}"fixed" }},')
        else:
            element = joint.find("axis")
            axis = R @ (np.eye(3)[0] if element is None else vector(element, "xyz"))
            sigma = int(joint.get("type") == "prismatic")
            rows.append(f'{start}"motor", sigma = {sigma}, axis = {listed(axis / np.linalg.norm(axis))} }},')
        inertial = links[link].find("inertial")
        if inertial is not None:
            S, c = pose(inertial)
            tensor = {key: float(inertial.find("inertia").get(f"i{key.lower()}")) for key in TENSOR}  # type: ignore
            tensor_in_link = np.array([[tensor["".join(sorted(a + b))] for a in "XYZ"] for b in "XYZ"])
            turned = (R @ S) @ tensor_in_link @ (R @ S).T
            entries = listed(turned[np.triu_indices(3)])
            mass = inertial.find("mass").get("value")  # type: ignore[union-attr]
            bodies.append(f"{name} = {{ mass = {mass}, center_of_mass = {listed(R @ c)}, inertia = {entries} }}")
        for what in (f"link {link}", f"joint {name}"):
            frames.append(f'"{what}" = {{ on = "{name}", at = [0, 0, 0], rpy = {listed(angles(R))} }}')
    head = ["gravity = [0, 0, -9.81]", "joints = [", *rows, "]", "[frames]", *frames]
    return "\n".join([*head, "[bodies]", *bodies, ""])


def vector(element: ET.Element | None, key: str) -> np.ndarray:
    return np.array([float(x) for x in (element.get(key, "0 0 0") if element is not None else "0 0 0").split()])


def pose(element: ET.Element) -> tuple[np.ndarray, np.ndarray]:
    roll, pitch, yaw = vector(element.find("origin"), "rpy")
    return turn("z", yaw) @ turn("y", pitch) @ turn("x", roll), vector(element.find("origin"), "xyz")


def angles(R: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw of a rotation."""
    yaw = np.arctan2(R[1, 0], R[0, 0]) if np.hypot(R[0, 0], R[1, 0]) > 1e-12 else 0.0
    left = turn("z", -yaw) @ R
    return np.array([np.arctan2(-left[1, 2], left[1, 1]), np.arctan2(-left[2, 0], left[0, 0]), yaw])


def listed(values: np.ndarray) -> str:
    return "[" + ", ".join(repr(float(x) if abs(x) > 1e-90 else 0.0) for x in values) + "]"
