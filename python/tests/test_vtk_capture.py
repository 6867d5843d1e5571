"""What the capture script for VTK writes, without VTK: its files and its cameras mean to the engine what they say."""

import json
import sys
from types import SimpleNamespace

import numpy as np
import overlook
import pytest
from overlook import vtk_capture as script

SIZE = (40, 30)
CENTER, RADIUS = np.array([0.3, -0.2, 0.1]), 0.8


def traced(view):
    """Planar depth and normals of a sphere at the pixels' centers, and what is seen of it."""
    pose, lens = view.pose(), view.lens(SIZE)
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    local = np.stack([(x - lens["cx"]) / lens["fl_x"], (lens["cy"] - y) / lens["fl_y"], -np.ones_like(x)], -1)
    ray, away = local @ pose[:3, :3].T, pose[:3, 3] - CENTER
    a, b = np.sum(ray * ray, -1), ray @ away
    inside = b * b - a * (away @ away - RADIUS**2)
    depth = np.where(inside > 0, (-b - np.sqrt(np.maximum(inside, 0))) / a, script.MISS).astype(np.float32)
    normal = np.where(depth[..., None] < script.MISS, (away + depth[..., None] * ray) / RADIUS, 0)
    return depth, normal.astype(np.float16)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("vtk")
    views = script.viewpoints("ring:3", SIZE, (-1, 1, -1, 1, -1, 1))
    stage = SimpleNamespace(size=SIZE, up=(0, 0, 1), is_antialiased=True)
    shades = script.LINEAR[np.arange(SIZE[0] * SIZE[1]).reshape(SIZE[1], SIZE[0]) % 256].astype(np.float16)
    for view in views:
        depth, normal = traced(view)
        channels = {"R": shades, "G": shades.T.reshape(shades.shape), "B": shades[::-1], "Z": depth}
        channels.update(zip(("N.X", "N.Y", "N.Z"), np.moveaxis(normal, -1, 0)))
        script.write_exr(str(folder / view.name / "0007.exr"), channels)
    planned = script.manifest(views, [7], [0.25], stage)
    (folder / "transforms.json").write_text(json.dumps(planned))
    return folder, views, planned, shades


def test_pictures_are_read_to_the_last_bit_and_cameras_as_they_stand(recorded):
    folder, views, _, shades = recorded
    capture = overlook.open(folder)
    assert (capture.warnings, capture.frame_numbers) == ([], [7])
    for camera, view in zip(capture.cameras, views):
        frame, (depth, normal) = capture.frame(camera.name), traced(view)
        np.testing.assert_array_equal(frame.color[..., 0], shades.astype(np.float32))
        np.testing.assert_array_equal(frame.color[..., 2], shades[::-1].astype(np.float32))
        hit = depth < script.MISS
        assert 0.1 < hit.mean() < 0.9
        np.testing.assert_allclose(frame.depth[hit], depth[hit], rtol=1e-6)
        assert np.all(np.isinf(frame.depth[~hit]))
        np.testing.assert_allclose(frame.normal_in_world[hit], normal[hit], atol=2e-3)
        # The points of every camera lie on one sphere: poses and lenses are those that they were traced with.
        x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
        lens = camera.lens
        local = np.stack([(x - lens.cx) / lens.fx, (y - lens.cy) / lens.fy, np.ones_like(x)], -1)[hit] * frame.depth[hit][:, None]
        points = local @ camera.pose[:3, :3].T + camera.pose[:3, 3]
        np.testing.assert_allclose(np.linalg.norm(points - CENTER, axis=1), RADIUS, atol=1e-4)


def test_pictures_of_other_cameras_are_not_mixed_with_those_that_are_there(recorded, tmp_path):
    folder, views, planned, _ = recorded
    assert script.begin(str(folder), planned, views, False) == []
    (folder / views[1].name / "0007.exr").unlink()
    missing = script.begin(str(folder), planned, views, False)
    assert [(frame, view.name) for frame, view, _ in missing] == [(7, views[1].name)]
    other = json.loads(json.dumps(planned))
    other["frames"][0]["fl_x"] += 1
    with pytest.raises(script.CaptureError, match="other cameras"):
        script.begin(str(folder), other, views, False)
    assert len(script.begin(str(folder), other, views, True)) == 3


@pytest.mark.parametrize("layout", ["ring:6", "sphere:12", "sphere:1", 4])
def test_placed_cameras_see_all_corners_of_the_bounds(layout):
    bounds = np.array([-1, 3, 2, 2.5, -4, 0.0])
    corners = np.stack(np.meshgrid(*bounds.reshape(3, 2)), -1).reshape(-1, 3)
    for size in ((64, 48), (48, 64)):
        for view in script.viewpoints(layout, size, bounds, up=(0, 1, 0)):
            x, y, back = ((corners - view.position) @ view.pose()[:3, :3]).T
            lens = view.lens(size)
            assert np.all(back < 0)
            assert np.all(np.abs(lens["fl_x"] * x / back) < size[0] / 2) and np.all(np.abs(lens["fl_y"] * y / back) < size[1] / 2)


def test_cameras_inside_look_into_every_direction():
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(2000, 3))
    for number in (6, 8, 14):
        views = script.viewpoints(f"inside:{number}", (64, 64), (-1, 1, -1, 1, -1, 1))
        seen = np.zeros(len(directions), bool)
        for view in views:
            x, y, back = (directions @ view.pose()[:3, :3]).T
            half = view.lens((64, 64))["fl_x"] / 32
            seen |= (back < 0) & (np.maximum(np.abs(x), np.abs(y)) * half < -back)
        assert seen.mean() > 0.98, number


def test_recording_without_vtk_or_of_something_else_is_one_line(tmp_path, monkeypatch):
    # As Python has it of what is not installed.
    monkeypatch.setitem(sys.modules, "vtkmodules", None)
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(script.CaptureError, match="pip install pyvista") as raised:
        overlook.record_pyvista(object(), tmp_path / "capture", cameras=2)
    assert "\n" not in str(raised.value) and not (tmp_path / "capture").exists()
    with pytest.raises(script.CaptureError, match="pip install pyvista"):
        script.scene_of_files(["scene.vtp"], SimpleNamespace())


def test_a_manifest_of_poses_gives_its_cameras_back(recorded, tmp_path):
    folder, views, planned, _ = recorded
    for given, expected in zip(script.viewpoints(planned, SIZE, None), views, strict=True):
        assert given.name == expected.name and np.allclose(given.pose(), expected.pose(), atol=1e-9)
        assert given.lens(SIZE) == pytest.approx(expected.lens(SIZE))
    placed = overlook.place(overlook.open(folder), 2)
    placed.save(tmp_path / "placed.json")
    for given, camera in zip(script.viewpoints(json.loads((tmp_path / "placed.json").read_text()), SIZE, None), placed.cameras, strict=True):
        np.testing.assert_allclose(given.pose() @ np.diag([1, -1, -1, 1]), camera.pose, atol=1e-6)
        assert given.lens(SIZE)["fl_y"] == pytest.approx(camera.lens.fy)
    shifted = {"frames": [{**planned["frames"][0], "cx": 3}]}
    for wrong, said in (({"frames": [{"camera": "a"}]}, "no pose"), (shifted, "shifted lens")):
        with pytest.raises(script.CaptureError, match=said):
            script.viewpoints(wrong, SIZE, None)


def test_values_are_asked_for_by_names_units_or_what_the_manifest_says(recorded):
    _, views, _, _ = recorded
    assert script.checked_values("p") == [{"name": "p"}] and script.checked_values(None) == []
    assert script.checked_values({"p": "Pa", "grain": None}) == [{"name": "p", "unit": "Pa"}, {"name": "grain"}]
    assert script.checked_values(["p", {"name": "q", "range": [0, 1]}]) == [{"name": "p"}, {"name": "q", "range": [0, 1]}]
    for wrong, said in ((list("abcde"), "up to 4"), (["p", "p"], "each once"), ([{"unit": "m"}], "needs a name"), ([{"name": "p", "min": 0}], "may have")):
        with pytest.raises(script.CaptureError, match=said):
            script.checked_values(wrong)
    stage = SimpleNamespace(size=SIZE, up=(0, 0, 1), is_antialiased=True)
    assert script.manifest(views, [7], [None], stage, [{"name": "p"}])["values"] == [{"name": "p"}]
    assert "values" not in script.manifest(views, [7], [None], stage)


def test_corners_share_what_lies_on_triangles_lines_and_points():
    rng = np.random.default_rng(1)
    corners, given = rng.normal(size=(50, 3, 3)), rng.dirichlet([1, 1, 1], 50)
    np.testing.assert_allclose(script.shares(corners, np.sum(corners * given[..., None], 1)), given, atol=1e-9)
    line = corners[:, [0, 1, 0]]
    np.testing.assert_allclose(script.shares(line, 0.25 * line[:, 0] + 0.75 * line[:, 1])[:, 1], 0.75)
    point = corners[:, [0, 0, 0]]
    assert np.all(script.shares(point, point[:, 0]) == [1, 0, 0])
    # Beside the triangle, the nearer corners alone count.
    assert np.all(script.shares(corners[:1], corners[:1, 0] + 3 * (corners[:1, 0] - corners[:1, 1])) >= 0)


def test_recorded_values_are_those_of_the_points_that_pixels_show(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    ball = pyvista.Sphere(radius=RADIUS, center=CENTER, theta_resolution=60, phi_resolution=60)
    ball["height [m]"] = ball.points[:, 2].astype(np.float64)
    ball.cell_data["face"] = np.arange(ball.n_cells)
    plotter = pyvista.Plotter(off_screen=True, window_size=(160, 120))
    plotter.add_mesh(ball, show_edges=True)
    plotter.add_mesh(pyvista.Cube(center=(0.3, -0.2, 2), x_length=0.5, y_length=0.5, z_length=0.5), color="red")
    plotter.add_actor(script.spheres([[2.0, 0, 0]], 0.4, [1.0, 0, 0], {"face": [-7.0]}))
    script.record(plotter, tmp_path / "capture", 3, values={"height [m]": "m", "face": None})
    capture = overlook.open(tmp_path / "capture")
    assert [(it.name, it.unit) for it in capture.values] == [("height [m]", "m"), ("face", "")]
    np.testing.assert_allclose(capture.values[0].range, (ball.bounds[4], ball.bounds[5]), atol=1e-6)
    centers, of_others = ball.cell_centers().points, []
    for camera in capture.cameras:
        frame = capture.frame(camera.name)
        x, y = np.meshgrid(np.arange(160) + 0.5, np.arange(120) + 0.5)
        lens, hit = camera.lens, np.isfinite(frame.depth)
        local = np.stack([(x - lens.cx) / lens.fx, (y - lens.cy) / lens.fy, np.ones_like(x)], -1)[hit] * frame.depth[hit][:, None]
        points = local @ camera.pose[:3, :3].T + camera.pose[:3, 3]
        height, face = (frame.values[name] for name in ("height [m]", "face"))
        assert np.all(np.isnan(height[~hit])) and np.all(np.isnan(face[~hit]))
        on_ball = np.linalg.norm(points - CENTER, axis=1) < RADIUS + 0.01
        np.testing.assert_allclose(height[hit][on_ball], points[on_ball][:, 2], atol=1e-4)
        assert np.all(np.linalg.norm(centers[face[hit][on_ball].astype(int)] - points[on_ball], axis=1) < 0.1)
        # What lacks an array has no value, and a sphere that of its point.
        assert np.all(np.isnan(height[hit][~on_ball]))
        assert np.array_equal(face[hit][~on_ball] == -7, points[~on_ball, 0] > 1.5)
        of_others.append(face[hit][~on_ball])
    assert set(np.nan_to_num(np.concatenate(of_others))) == {0, -7}
    for wrong, said in (("no", "face, height"), ("Normals", "3 components")):
        with pytest.raises(script.CaptureError, match=said) as raised:
            script.record(plotter, tmp_path / "other", 3, values=[wrong])
        assert "\n" not in str(raised.value) and not (tmp_path / "other").exists()
