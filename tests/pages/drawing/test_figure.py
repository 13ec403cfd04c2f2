"""Figures: frames are where the models put them, and shapes move as joints do."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind
from symoro_elastic.models.bound.joint_axes import placed_machine
from symoro_elastic.pages.drawing.figure import BALL, CORNERS, UNIT, Figure, Placements, figure_of, placements_of
from symoro_elastic.pages.drawing.projection import view_of
from symoro_elastic.pages.drawing.shapes import Shape, Wire, bend, inverse, slip, transform
from symoro_elastic.pages.drawing.svg import machine_picture, picture_of, svg
from tests.command_line import EXAMPLES

CLOSED = Path(__file__).parents[2] / "closed_chains" / "machines"
MOVED = {
    "two_axis.toml": {"motor_x": 0.1, "bed_yaw": 0.2, "cart_x": -0.03},
    "gantry.toml": {"carriage_1": 0.02, "ram": -0.1},
    "sr400.par": {"th2": -0.8},
    "ball_screw.toml": {},
}


@cache
def placements(name: str) -> Placements:
    return placements_of(read_machine(EXAMPLES / name)[0])


@cache
def figure(name: str) -> Figure:
    found = placements(name)
    return figure_of(found, found.start)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", MOVED)
def test_frames_are_where_the_machine_has_them(name: str) -> None:
    found = placements(name)
    T = found.at(found.position(MOVED[name]))
    for j, joint in enumerate(placed_machine(found.machine, MOVED[name]).joints, start=1):
        if joint.joint.kind is Kind.CUT:
            continue
        np.testing.assert_allclose(T[j, :3, 3], joint.origin, atol=1e-12)
        np.testing.assert_allclose(T[j, :3, 2], joint.axis, atol=1e-12)


def test_a_floating_base_has_coordinates_and_no_plate() -> None:
    found = placements("floating_arm.toml")
    T = found.at(found.position({"base.x": 0.3, "base.z": 0.2}))
    base = [mark.frame for mark in figure("floating_arm.toml").marks if mark.name == "base"]
    np.testing.assert_allclose(T[base[0], :3, 3], [0.3, 0, 0.2], atol=1e-15)
    assert not any(shape.role == "base" for shape in figure("floating_arm.toml").shapes)


def springs(found: Figure) -> list[Wire]:
    return [wire for wire in found.wires if wire.role == Kind.ELASTIC]


def test_springs_hang_between_antecedent_and_joint() -> None:
    """One end of each moves with the joint, the other stays with the antecedent; both kinds of joints."""
    found, still = placements("two_axis.toml"), figure("two_axis.toml")
    rng = np.random.default_rng(1)
    q = found.start + rng.uniform(-0.3, 0.3, len(found.start))
    T = found.at(q)
    entry = {j: k for k, j in enumerate(found.machine.independent)}
    assert len(springs(still)) == 10
    for wire in springs(still):
        j, a = wire.frame, still.antecedents[wire.frame]
        seen = (inverse(T[a]) @ T[j], inverse(still.reference[a]) @ still.reference[j])
        moved = slip(*seen, still.slides[j])
        assert moved == pytest.approx(q[entry[j]] - found.start[entry[j]], abs=1e-12)
        points = bend(wire, moved, still.slides[j])
        fixed, free = int(np.argmax(wire.behind)), int(np.argmin(wire.behind))
        assert wire.behind[fixed] == 1 and wire.behind[free] == 0
        np.testing.assert_allclose(points[free], wire.points[free])
        in_antecedent = [
            T[:3, :3] @ x + T[:3, 3] for T, x in zip(seen, (points[fixed], wire.points[fixed]), strict=True)
        ]
        np.testing.assert_allclose(*in_antecedent, atol=1e-12)


@pytest.mark.parametrize("name", MOVED)
def test_rods_reach_from_frame_to_frame(name: str) -> None:
    """The ends of each rod are an origin, and an origin or the axis of a joint that slides."""
    found = figure(name)
    rods = [solid for solid in found.solids if solid.role == "link"]
    origins = found.reference[:, :3, 3]
    for rod in rods:
        T = found.reference[rod.frame] @ rod.placement
        ends = [T[:3, 3] + sense * T[:3, 2] * rod.size[2] / 2 for sense in (-1, 1)]
        assert rod.shape is Shape.CYLINDER
        assert min(np.linalg.norm(ends[0] - origins[rod.frame]), np.linalg.norm(ends[1] - origins[rod.frame])) < 1e-9
        away = []
        for j, a in enumerate(found.antecedents):
            if a == rod.frame and j:
                off = ends[1] - origins[j]
                along = found.reference[j][:3, 2]
                away.append(float(np.linalg.norm(off - along * (off @ along) * found.slides[j])))
        assert min(away) < 1e-9


def test_every_kind_of_joint_has_its_shape() -> None:
    found = figure("gantry.toml")
    roles = {mark.name: mark.role for mark in found.marks}
    for mark in found.marks:
        there = {shape.role for shape in found.shapes if shape.frame == mark.frame}
        assert roles[mark.name] in there or mark.role == "base", mark
    assert {mark.name for mark in found.marks} == {
        "base",
        *(joint.name for joint in placements("gantry.toml").machine.joints),
    }
    rails = [solid for solid in found.solids if solid.role == "rail"]
    assert len(rails) == sum(joint.sigma == 1 for joint in placements("gantry.toml").machine.joints)


@pytest.mark.thorough
def test_sizes_follow_the_machine() -> None:
    found = figure("gantry.toml")
    assert found.unit == pytest.approx(UNIT * found.extent) and 2 < found.extent < 3
    chain = read_machine(EXAMPLES / "rx90.par")[0]
    row = replace(chain.joints[0], d=Formula.parse(0.1))
    rows = tuple(replace(row, name=f"j{k}", variable=f"q{k}", antecedent=k) for k in range(40))
    long = placements_of(replace(chain, joints=rows))
    found = figure_of(long, long.start)
    assert found.unit == pytest.approx(0.02) and found.extent > 3.9, "links of 0.1 m"


def test_up_is_against_gravity() -> None:
    assert figure("two_axis.toml").up.tolist() == [0, 1, 0]
    assert figure("rx90.par").up.tolist() == [0, 0, 1], "its gravity is along z, and has no value"
    axes = view_of(figure("two_axis.toml")).axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
    assert axes[1, 1] > 0.9 and axes[2, 1] > 0.3, "seen from above, up is up"


def test_what_has_no_value_is_said() -> None:
    found = figure("rx90.par")
    assert found.remarks[0] == "not to scale: D3, RL4 without value"
    assert found.remarks[1] == "bodies without usable values are not drawn: j1, j2, j3, j4, j5, j6"
    assert figure("two_axis.toml").remarks == ()


def test_bodies_without_a_box_are_balls() -> None:
    """An inertia about one axis alone needs no remark; base parameters have no bodies."""
    two_r = read_machine(EXAMPLES / "planar_2r.toml")[0]
    body = replace(two_r.joints[0].body, inertia=tuple(map(Formula.parse, (1, 0, 0, 0, 0, 0))))
    wrong = placements_of(replace(two_r, joints=(replace(two_r.joints[0], body=body), *two_r.joints[1:])))
    found = figure_of(wrong, wrong.start)
    assert found.remarks == () and Shape.BALL in {solid.shape for solid in found.solids if solid.role == "body"}
    grouped = placements_of(replace(two_r, is_grouped=True))
    found = figure_of(grouped, grouped.start)
    assert "base parameters" in found.remarks[0] and not any(shape.role == "body" for shape in found.shapes)


def all_points(found: Figure) -> np.ndarray:
    placed = ((found.reference[x.frame] @ x.placement, CORNERS * x.size) for x in found.solids if x.role == "body")
    return np.concatenate([found.reference[:, :3, 3], *(transform(*pair) for pair in placed)])


@pytest.mark.parametrize("name", MOVED)
def test_the_room_contains_all_origins_and_bodies(name: str) -> None:
    found, moved = placements(name), placements(name).position(MOVED[name])
    for drawn in (figure(name), figure_of(found, moved)):
        points, thin = all_points(drawn), 0.5 * BALL * drawn.unit
        assert (points >= drawn.room[0] - thin).all() and (points <= drawn.room[1] + thin).all()


def test_bodies_around_the_joints_are_outlines() -> None:
    """Axes through one point, in bodies of 0.5 m; a link beside its joint is filled."""
    joints = [{"name": x, "kind": "motor", "sigma": 1, "alpha": "pi/2", "r": f"q_{x}"} for x in "xyz"]
    bodies = {x: {"mass": 60, "center_of_mass": [0, 0.1, 0], "inertia": [2, 3, 2]} for x in "xyz"}
    gantry = placements_of(se.read({"name": "gantry", "gravity": [0, 0, -9.81], "joints": joints, "bodies": bodies}))
    found = figure_of(gantry, gantry.start)
    assert [solid.outlined for solid in found.solids if solid.role == "body"] == [True] * 3
    assert "body s3" in svg(picture_of(found))
    assert not all(solid.outlined for solid in figure("gantry.toml").solids if solid.role == "body")


def test_a_body_far_longer_than_the_machine_is_a_ball() -> None:
    """A bed of 60 m under an arm of 0.9 m."""
    two_r = read_machine(EXAMPLES / "planar_2r.toml")[0]
    heavy = replace(two_r.joints[0].body, inertia=tuple(map(Formula.parse, (1, 0, 0, 3000, 0, 3000))))
    long = placements_of(replace(two_r, joints=(replace(two_r.joints[0], body=heavy), *two_r.joints[1:])))
    found = figure_of(long, long.start)
    assert found.remarks == ("bodies over 8 times as long as the machine are drawn as balls: shoulder",)
    assert found.extent < 3


def test_numbers_beyond_all_range_are_refused_or_said() -> None:
    two_r = read_machine(EXAMPLES / "planar_2r.toml")[0]
    far = placements_of(replace(two_r, joints=(*two_r.joints[:2], replace(two_r.joints[2], d=Formula.parse(1e300)))))
    with pytest.raises(InputError, match="m large: 1e\\+06 m is the largest that is drawn: check units"):
        figure_of(far, far.start)
    moments = tuple(map(Formula.parse, (1e200, 0, 0)))
    body = replace(two_r.joints[0].body, moments=moments, mass=Formula.parse(1e-9), central=False)
    heavy = placements_of(replace(two_r, joints=(replace(two_r.joints[0], body=body), *two_r.joints[1:])))
    assert figure_of(heavy, heavy.start).remarks == ("bodies without usable values are not drawn: shoulder",)


@pytest.mark.thorough
def test_names_of_very_many_frames_are_left_out() -> None:
    two_r = read_machine(EXAMPLES / "planar_2r.toml")[0]
    rows = tuple(
        replace(two_r.joints[2], name=f"point_{k}", antecedent=2, r=Formula.parse(0.01 * k)) for k in range(200)
    )
    many = replace(two_r, joints=(*two_r.joints[:2], *rows))
    found = machine_picture(many)
    assert found.labels == [] and found.figure.remarks == ("more than 150 frames: names are left out",)


def test_positions_where_a_loop_does_not_close_are_refused() -> None:
    """Two jacks pulled out by a metre."""
    found = placements_of(read_machine(CLOSED / "two_jack_arm.toml")[0])
    names = [joint.name for joint in found.machine.independent_joints]
    q = found.start + np.eye(len(names))[names.index("rod_1")]
    with pytest.raises(InputError, match="boom_jack, stick_jack does not close there: give another position"):
        found.at(q)
