from collections import Counter
from pathlib import Path

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.scene.meshes import (
    TriangleMesh,
    ellipsoid,
    extrude,
    join,
    lay,
    loft,
    triangulate,
)
from hunav_drake.systems.scene.models.make_people import make_people

L_SHAPE = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)]


def volume(mesh: TriangleMesh) -> float:
    """The volume inside a closed surface, by the divergence theorem."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6)


def open_edges(mesh: TriangleMesh) -> int:
    """How many directed edges lack the one that runs back."""
    keys = [tuple(np.round(v, 9)) for v in mesh.vertices]
    edges = Counter(
        (keys[f[i]], keys[f[(i + 1) % 3]]) for f in mesh.faces for i in range(3)
    )
    return sum(edges[a, b] != edges[b, a] for a, b in edges)


def areas(p: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (p[triangles[:, i]] for i in range(3))
    u, v = b - a, c - a
    return (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2


@pytest.mark.parametrize("outline", [L_SHAPE, L_SHAPE[::-1]])
def test_a_prism_over_a_concave_outline_has_its_volume(outline):
    dut = extrude(outline, 0.5, 2.5)
    assert volume(dut) == pytest.approx(4 * 2)
    assert open_edges(dut) == 0


def test_the_normals_of_a_prism_are_those_of_its_faces():
    dut = extrude(L_SHAPE, 0.0, 1.0)
    a, b, c = (dut.vertices[dut.faces[:, i]] for i in range(3))
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    for i in range(3):
        np.testing.assert_allclose(dut.normals[dut.faces[:, i]], n, atol=1e-12)


def test_an_ellipsoid_has_nearly_its_volume():
    dut = ellipsoid((1, 2, 3), (0.5, 1.0, 2.0), sides=64)
    assert volume(dut) == pytest.approx(4 / 3 * np.pi, rel=0.01)
    assert open_edges(dut) == 0


@pytest.mark.parametrize(("power", "area"), [(2.0, np.pi), (40.0, 4.0)])
def test_a_loft_between_equal_sections_is_a_cylinder_or_nearly_a_box(
    power, area
):
    dut = loft([[0, 0, 0, 1, 1], [0, 0, 3, 1, 1]], sides=400, power=power)
    assert volume(dut) == pytest.approx(3 * area, rel=0.02)
    assert open_edges(dut) == 0


def test_normals_of_a_loft_point_outwards():
    dut = loft([[0, 0, z, 1, 2] for z in (0, 1, 2)])
    rings = dut.vertices[:-2]
    assert np.all(np.sum(dut.normals[:-2, :2] * rings[:, :2], axis=1) > 0)
    np.testing.assert_allclose(dut.normals[-2:], [[0, 0, -1], [0, 0, 1]])


def test_moving_keeps_the_shape_and_pitch_swings_what_hangs():
    dut = loft([[0, 0, -2, 1, 1], [0, 0, 0, 1, 1]])
    moved = dut.moved((5, 6, 7), pitch=-np.pi / 2)
    assert volume(moved) == pytest.approx(volume(dut))
    np.testing.assert_allclose(moved.vertices[-2], [5 + 2, 6, 7], atol=1e-12)


def test_joined_meshes_keep_their_faces_apart():
    prism = extrude(L_SHAPE, 0, 1)
    dut = join([prism, prism.moved((10, 0, 0))])
    assert volume(dut) == pytest.approx(2 * volume(prism))


def test_tiles_face_upwards():
    dut = lay([[(0, 0), (2, 0), (2, 1), (0, 1)]], 0.25)
    np.testing.assert_allclose(areas(dut.vertices[:, :2], dut.faces), [1, 1])
    assert set(dut.vertices[:, 2]) == {0.25}


def test_obj_text_says_what_the_mesh_is():
    dut = extrude(L_SHAPE, 0, 1)
    rows = [line.split() for line in dut.to_obj().splitlines()]
    vertices, normals = (
        np.array([[float(x) for x in r[1:]] for r in rows if r[0] == key])
        for key in ("v", "vn")
    )
    faces = np.array(
        [
            [[int(i) - 1 for i in x.split("//")] for x in r[1:]]
            for r in rows
            if r[0] == "f"
        ]
    )
    assert len(faces) == len(dut.faces)
    np.testing.assert_allclose(
        vertices[faces[..., 0]], dut.vertices[dut.faces], atol=1e-4
    )
    np.testing.assert_allclose(
        normals[faces[..., 1]], dut.normals[dut.faces], atol=1e-2
    )
    # What is equal stands once: 6 corners, below and above; 6 directions.
    assert (len(vertices), len(normals)) == (12, 6)


@given(
    st.lists(st.floats(0.2, 5.0), min_size=3, max_size=40), st.floats(0, 6.28)
)
def test_triangles_cover_any_star_shaped_outline_once(radii, turn):
    angle = turn + np.arange(len(radii)) * (2 * np.pi / len(radii))
    p = np.array(radii)[:, None] * np.stack(
        [np.cos(angle), np.sin(angle)], axis=1
    )
    dut = triangulate(p)
    x, y = p.T
    shoelace = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2
    assert len(dut) == len(p) - 2
    pieces = areas(p, dut)
    assert np.all(pieces >= -1e-12)
    assert np.sum(pieces) == pytest.approx(shoelace)


@pytest.mark.parametrize(
    "outline",
    [
        [(0, 0), (1, 0), (2, 0), (3, 0)],
        [(0, 0), (2, 2), (2, 0), (0, 2)],
        [(1, 1)] * 5,
        [(0, 0), (1, 0), (1, 0), (1, 1), (0, 1), (0, 1)],
    ],
)
def test_outlines_that_are_no_simple_polygons_are_cut_too(outline):
    assert triangulate(outline).shape == (len(outline) - 2, 3)


def test_the_shipped_parts_of_people_are_those_that_the_script_makes():
    """`python -m hunav_drake.systems.scene.models.make_people` writes them."""
    made = {f"{k}.obj": mesh.to_obj() for k, mesh in make_people().items()}
    files = Path(make_people.__code__.co_filename).parent.glob("*.obj")
    assert {file.name: file.read_text() for file in files} == made
