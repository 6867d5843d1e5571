"""The module against the command line on one small capture. OVERLOOK names the program to compare with."""

import html
import json
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import OpenEXR
import overlook
import pytest

PROGRAM = os.environ.get("OVERLOOK", "overlook")


def run(*arguments):
    subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("capture") / "orrery"
    run("demo", "orrery", "--size", "96x72", "--frames", "3", "--cameras", "4", "--out", folder)
    return folder


@pytest.fixture(scope="module")
def store(folder):
    # Saved bit for bit, so that what is read again equals it.
    return overlook.open(folder).preprocess({"store.precision": "lossless"})


def channels(path):
    """The float channels of a picture by name, each (height, width)."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for name, channel in file.channels().items()}


def lens_and_pose(view, manifest):
    value = lambda key: view.get(key, manifest.get(key))
    lens = overlook.Lens(int(value("w")), int(value("h")), value("fl_x"), value("fl_y"), value("cx"), value("cy"))
    pose = np.array(view["transform_matrix"], dtype=np.float64)
    # Manifests look along -z with y up, as OpenGL does.
    pose[:, 1:3] *= -1
    return lens, pose


def test_frames_are_those_of_the_files(folder):
    capture = overlook.open(folder)
    assert [camera.name for camera in capture.cameras][:2] == ["front", "left"]
    assert capture.frame_numbers == [0, 1, 2] and capture.warnings == []
    frame = capture.frame("left", 1)
    assert frame.color.shape == (72, 96, 3) and frame.color.dtype == np.float32
    manifest = json.loads((folder / "transforms.json").read_text())
    picture = next(f for f in manifest["frames"] if f["file_path"].startswith("left") and f.get("time") == 1)
    recorded = channels(folder / picture["file_path"])
    for nth, name in enumerate("RGB"):
        assert np.array_equal(frame.color[..., nth], recorded[name].astype(np.float32))
    depth = recorded[next(name for name in ("Z", "depth.Z", "Depth.Z", "V") if name in recorded)].astype(np.float64)
    near = np.isfinite(frame.depth)
    assert near.mean() > 0.5
    assert np.allclose(frame.depth[near], depth[near], rtol=1e-6)
    lengths = np.linalg.norm(frame.normal_in_world, axis=2)
    assert np.allclose(lengths[lengths > 0], 1.0, atol=1e-3)
    assert np.array_equal(capture.frame(1, 1).color, frame.color)


def test_cameras_carry_points_of_one_into_the_other(folder):
    capture = overlook.open(folder)
    first, second = capture.cameras[:2]
    samples = capture.preprocess().samples(frame=0, camera=0)
    assert len(samples) == len(samples.depth) > 500
    near = np.isfinite(samples.depth)
    homogeneous = np.c_[samples.point_in_world[near], np.ones(near.sum())]
    in_camera = homogeneous @ np.linalg.inv(first.pose).T
    u = first.lens.cx + first.lens.fx * in_camera[:, 0] / in_camera[:, 2]
    v = first.lens.cy + first.lens.fy * in_camera[:, 1] / in_camera[:, 2]
    assert np.allclose(np.c_[u, v], samples.pixel[near] + 0.5, atol=1e-3)
    assert np.allclose(in_camera[:, 2], samples.depth[near], rtol=1e-4)
    assert not np.allclose(first.pose, second.pose)


def test_a_picture_is_that_of_the_command_line_bit_by_bit(folder, store, tmp_path):
    saved = tmp_path / "python.ovl"
    assert store.save(saved) == saved.stat().st_size
    views = folder / "novel" / "transforms.json"
    run("render", saved, "--views", views, "--out", tmp_path / "pictures", "--backend", "cpu")
    manifest = json.loads(views.read_text())
    played = overlook.open_store(saved)
    for view in manifest["frames"][:2]:
        lens, pose = lens_and_pose(view, manifest)
        frame = store.frame_numbers.index(view["time"])
        pictures = [s.render(pose, lens, frame, {"render.backend": "cpu"}) for s in (store, played)]
        written = channels((tmp_path / "pictures" / view["file_path"]).with_suffix(".exr"))
        for color, depth, coverage in pictures:
            assert color.shape == (72, 96, 3) and coverage.dtype == bool and 0.9 < coverage.mean() <= 1.0
            for nth, name in enumerate("RGB"):
                # Pictures are written in half floats.
                assert np.array_equal(color[..., nth].astype(np.float16), written[name])
            assert np.isfinite(depth[coverage]).mean() > 0.5


def test_samples_are_those_that_the_command_line_exports(store, tmp_path):
    saved, points = tmp_path / "a.ovl", tmp_path / "a.ply"
    store.save(saved)
    run("export", "points", saved, "--frame", "1", "--out", points)
    header, _, body = points.read_bytes().partition(b"end_header\n")
    kinds = {"float": "<f4", "uchar": "u1"}
    fields = [line.split()[1:] for line in header.decode().splitlines() if line.startswith("property")]
    exported = np.frombuffer(body, dtype=[(name, kinds[kind]) for kind, name in fields])
    theirs = np.c_[exported["x"], exported["y"], exported["z"]]
    for samples in (store.samples(frame=1), overlook.open_store(saved).samples(frame=1)):
        ours = samples.point_in_world[np.isfinite(samples.depth)]
        assert np.allclose(ours, theirs, atol=1e-5)
    assert len(store.samples()) > len(store.samples(frame=1)) > len(store.samples(frame=1, camera=2)) > 0


def test_edits_are_those_of_the_command_line_by_path_and_as_text(folder, tmp_path):
    text = 'version = 1\n[[edit]]\ndo = "delete"\nregion = { sphere = { center = [0, 0, 0.5], radius = 0.8 } }\n'
    edits = tmp_path / "edits.toml"
    edits.write_text(text)
    run("preprocess", folder, "--edits", edits, "--out", tmp_path / "expected.ovl")
    overlook.open(folder).preprocess(edits=edits).save(tmp_path / "store.ovl")
    assert (tmp_path / "store.ovl").stat().st_size > 0
    expected = overlook.open_store(tmp_path / "expected.ovl").report
    assert overlook.open_store(tmp_path / "store.ovl").report["cut"] == expected["cut"] != []

    overlook.open(folder).preprocess().save(tmp_path / "all.ovl")
    run("export", "page", tmp_path / "all.ovl", "--edits", edits, "--out", tmp_path / "expected.html")
    for given in (edits, text):
        overlook.open_store(tmp_path / "all.ovl", edits=given).export_page(tmp_path / "scene.html")
        assert (tmp_path / "scene.html").read_bytes() == (tmp_path / "expected.html").read_bytes()
    with pytest.raises(overlook.Error, match="leave_out needs"):
        wrong = 'version = 1\n[[edit]]\ndo = "leave_out"\nregion = "doubtful"\n'
        overlook.open_store(tmp_path / "all.ovl", edits=wrong)


def test_settings_are_those_of_the_command_line_and_mistakes_are_one_line(folder, store):
    capture = overlook.open(folder)
    assert len(capture.preprocess({"pruning.method": "off"}).samples()) > len(store.samples())
    for mistake in ({"pruning.nonsense": 1}, {"pruning.depth_tolerance": -1}):
        with pytest.raises(overlook.Error) as raised:
            capture.preprocess(mistake)
        assert "\n" not in str(raised.value) and next(iter(mistake)) in str(raised.value)
    with pytest.raises(overlook.Error, match="no such file or folder"):
        overlook.open(folder / "nothing")
    with pytest.raises(KeyError, match="no such camera"):
        capture.frame("nobody")
    with pytest.raises(IndexError):
        capture.frame(0, 99)
    with pytest.raises(overlook.Error, match="there is no frame 99"):
        store.render(capture.cameras[0].pose, capture.cameras[0].lens, frame=99)
    with pytest.raises(ValueError, match="right angles"):
        store.render(2 * np.eye(4), capture.cameras[0].lens)


def test_progress_is_told_and_what_it_raises_stops_the_work():
    capture = overlook.demo("nine-cameras", frames=12, size=(160, 120))
    stages = []
    capture.preprocess(progress=lambda stage, done, total: stages.append((stage, done, total)))
    assert len({stage for stage, _, _ in stages}) > 1 and all(done <= total for _, done, total in stages if total)

    def refuse(stage, done, total):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        overlook.demo("nine-cameras", frames=12, size=(160, 120)).preprocess(progress=refuse)


def test_control_c_stops_a_long_call_and_other_threads_run_meanwhile():
    capture = overlook.demo("nine-cameras", size=(640, 480))
    ticks = []
    over = threading.Event()

    def tick():
        while not over.wait(0.01):
            ticks.append(time.monotonic())

    watcher = threading.Thread(target=tick)
    watcher.start()
    timer = threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    started = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        capture.preprocess()
    took = time.monotonic() - started
    over.set()
    watcher.join()
    assert took < 30.0, "the whole scene was preprocessed"
    assert len(ticks) > 20


def test_evaluation_gives_the_numbers_of_the_command_line(folder):
    ours = overlook.evaluate(overlook.open(folder), settings={"render.backend": "cpu"})
    told = subprocess.run(
        [PROGRAM, "evaluate", str(folder), "--json", "--backend", "cpu"], check=True, capture_output=True, text=True
    )
    theirs = json.loads(told.stdout)
    assert ours["as_set"]["mean"]["psnr_db"] == theirs["mean"]["psnr_db"] > 15
    assert ours["no_pruning"]["samples_kept"] == theirs["no_pruning"]["samples_kept"]
    held_out = overlook.evaluate(overlook.open(folder), hold_out=["left"])
    assert held_out["as_set"]["samples_kept"] < ours["as_set"]["samples_kept"]


def test_a_page_is_that_of_the_command_line_and_a_notebook_shows_it_within_its_budget(store, tmp_path):
    saved, theirs = tmp_path / "a.ovl", tmp_path / "theirs.html"
    store.save(saved)
    words = {"title": "Small <orrery>", "text": "One.\n\nTwo."}
    run("export", "page", saved, "--out", theirs, "--title", words["title"], "--text", words["text"])
    for played in (store, overlook.open_store(saved)):
        ours = tmp_path / "ours.html"
        assert played.export_page(ours, **words) == ours.stat().st_size
        assert ours.read_bytes() == theirs.read_bytes()
    page = store.page(**words)
    assert page.html == theirs.read_text(encoding="utf-8")
    shown = page._repr_html_()
    sentence, _, frame = shown.partition("<iframe")
    assert sentence.startswith("<p>'Small &lt;orrery&gt;' as a page of") and "<" not in sentence[3:-4]
    srcdoc = frame.split('srcdoc="')[1].split('"')[0]
    assert html.unescape(srcdoc) == page.html and 'height="480"' in frame
    most = len(page.html) * 3 // 4
    smaller = store.page(**words, at_most=most, height=300)
    assert len(smaller.html) <= most and "merged from" in smaller._repr_html_()
    smaller.save(tmp_path / "smaller.html")
    assert (tmp_path / "smaller.html").read_text(encoding="utf-8") == smaller.html
    with pytest.raises(overlook.Error, match="more than the 9"):
        store.page(at_most=9)
    with pytest.raises(ValueError, match="fps"):
        store.page(fps=0)


def test_splats_lie_on_the_samples_and_cover_their_pixels(store, tmp_path):
    saved = tmp_path / "a.ovl"
    store.save(saved)
    for played in (store, overlook.open_store(saved)):
        splats, samples = played.splats(1), played.samples(frame=1)
        near = np.isfinite(samples.depth)
        assert len(splats) == near.sum() and splats.center_in_world.dtype == np.float64
        assert np.allclose(splats.center_in_world, samples.point_in_world[near], atol=1e-5)
        assert np.allclose(splats.color, np.clip(samples.color[near], 0, 1)) and np.all((splats.opacity > 0) & (splats.opacity <= 1))
        w, x, y, z = splats.rotation.astype(np.float64).T
        normal = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
        assert np.allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-5)
        eyes = np.stack([camera.pose[:3, 3] for camera in played.cameras])[samples.camera[near]]
        assert np.all(np.sum((eyes - splats.center_in_world) * normal, axis=1) > -1e-6)
        # The shorter radius is half of a pixel at this depth, off the axis somewhat more.
        focal = np.array([camera.lens.fx for camera in played.cameras])[samples.camera[near]]
        pixels = splats.scale[:, 1] / (0.5 * samples.depth[near] / focal)
        assert np.all(pixels < 1.6) and np.median(np.abs(pixels - 1)) < 0.1
    few = store.splats(1, at_most=len(splats) // 2)
    assert len(splats) // 8 < len(few) <= len(splats) // 2
    assert len(store.splats(1, sky="dome")) > len(splats)
    with pytest.raises(IndexError):
        store.splats(99)
    with pytest.raises(ValueError, match="sky"):
        store.splats(sky="blue")
    with pytest.raises(overlook.Error, match="allow more"):
        store.splats(at_most=1)


def test_cameras_are_placed_as_by_the_command_line_and_their_manifest_holds_them(folder, tmp_path):
    ours = overlook.place(overlook.open(folder), 3, ring=True, size=(192, 144))
    command = [PROGRAM, "place", folder, "--cameras", "3", "--ring", "--size", "192x144", "--out", tmp_path / "theirs.json", "--json"]
    told = subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True)
    theirs = json.loads(told.stdout)
    assert [one["adds"] for one in theirs["cameras"]] == list(ours.adds) and theirs["unseen"] == ours.unseen
    assert np.all(np.diff(ours.adds) <= 0) and np.isclose(ours.adds.sum(), ours.seen) and 0.5 < ours.seen <= 1
    assert 0.5 < ours.coarse_cameras_see <= 1 and ours.unseen_points_in_world.shape[1] == 3
    ours.save(tmp_path / "ours.json")
    assert (tmp_path / "ours.json").read_text() == (tmp_path / "theirs.json").read_text()
    manifest = json.loads((tmp_path / "ours.json").read_text())
    for camera, view in zip(ours.cameras, manifest["frames"], strict=True):
        lens, pose = lens_and_pose(view, manifest)
        assert (camera.name, lens.width, lens.height) == (view["camera"], 192, 144)
        assert np.allclose(pose, camera.pose) and np.isclose(lens.fx, camera.lens.fx)
    with pytest.raises(overlook.Error, match="no camera"):
        overlook.place(overlook.open(folder), 0)
    with pytest.raises(ValueError, match="one of them"):
        overlook.place(overlook.open(folder), ring=True, within=((0, 0, 0), (1, 1, 1)))


def test_values_are_those_of_the_arrays_in_frames_in_samples_and_in_rendered_pictures(folder, tmp_path):
    copy = tmp_path / "valued"
    subprocess.run(["cp", "-r", str(folder), str(copy)], check=True)
    manifest = json.loads((copy / "transforms.json").read_text())
    rows, columns = np.mgrid[0:72, 0:96].astype(np.float32)
    plane = (columns + 100 * rows).astype(np.float32)
    plane[0, :] = np.nan
    np.save(copy / "pressure.npy", plane)
    manifest["values"] = [{"name": "pressure", "unit": "Pa", "range": [0, 8000], "tolerance": 1e9}]
    for entry in manifest["frames"]:
        entry["value_file_paths"] = {"pressure": "pressure.npy"}
    (copy / "transforms.json").write_text(json.dumps(manifest))
    capture = overlook.open(copy)
    (channel,) = capture.values
    assert (channel.name, channel.unit, channel.range) == ("pressure", "Pa", (0.0, 8000.0))
    assert np.array_equal(capture.frame(0).values["pressure"], plane, equal_nan=True)
    store = capture.preprocess()
    saved = tmp_path / "valued.ovl"
    store.save(saved)
    for one in (store, overlook.open_store(saved)):
        samples = one.samples()
        x, y = samples.pixel.T
        assert np.array_equal(samples.values["pressure"], plane[y, x], equal_nan=True)
        camera = capture.cameras[0]
        shown = one.render_values(camera.pose, camera.lens)["pressure"]
        known = shown[np.isfinite(shown)]
        assert shown.shape == plane.shape and known.size > plane.size // 2
        # Never blended: every value is some pixel's.
        assert np.isin(known, plane).all()
    assert overlook.open(folder).values == [] and overlook.open(folder).frame(0).values == {}


def test_a_value_that_there_is_not_is_named_in_one_line(folder, tmp_path):
    manifest = json.loads((folder / "transforms.json").read_text())
    manifest["values"] = [{"name": "pressure"}]
    wrong = folder / "wrong_values.json"
    wrong.write_text(json.dumps(manifest))
    with pytest.raises(overlook.Error, match="no channel 'pressure'"):
        overlook.open(wrong)


def test_pycinema_shows_the_colors_of_a_database_and_not_its_depth(folder, tmp_path):
    # Installing it takes minutes, as it brings a toolkit for windows: it is tested where it is there.
    filters = pytest.importorskip("pycinema.filters")
    image = pytest.importorskip("PIL.Image")
    run("preprocess", folder, "--out", tmp_path / "scene.ovl")
    database = tmp_path / "scene.cdb"
    run("export", "cinema", tmp_path / "scene.ovl", "--out", database, "--phi=-20,20,2", "--theta", "10,20,2", "--size", "80x60")
    reader, pictures = filters.CinemaDatabaseReader(), filters.ImageReader()
    reader.inputs.path.set(str(database))
    pictures.inputs.table.set(reader.outputs.table)
    pictures.update()
    columns, *rows = reader.outputs.table.get()
    shown = pictures.outputs.images.get()
    assert len(shown) == len(rows) == 12
    for row, picture in zip(rows, shown):
        with image.open(row[columns.index("FILE")]) as file:
            assert np.array_equal(picture.channels["rgba"], np.array(file.convert("RGBA")))
