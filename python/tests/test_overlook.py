"""The module against the command line on one small capture. OVERLOOK names the program to compare with."""

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
