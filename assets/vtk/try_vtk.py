# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tries `python/overlook/vtk_capture.py` for real: records a small scene with `pyvista`, and opens it in Overlook.

    pip install pyvista OpenEXR && python try_vtk.py OVERLOOK FOLDER

Two cameras record four frames of balls over a textured floor; a third one between them is the truth. What Overlook renders there from the
other two has to score above 30 dB, and above the picture of either of them; nothing may be asked or warned of. Depth and normals of a ball
are compared with those of the sphere that it is: they have to be within 0.1 pixels on its surface, and 0.2 degrees. A recording that was
stopped has to go on with what is missing alone, and mistakes have to be one line. Needs no display.
"""

import math
import os
import subprocess
import sys

import numpy as np
import OpenEXR
import pyvista

HERE = os.path.dirname(os.path.abspath(__file__))
SCRIPT = os.path.join(HERE, "..", "..", "python", "overlook", "vtk_capture.py")
sys.path[:0] = [os.path.dirname(SCRIPT), os.path.dirname(HERE)]
import vtk_capture
from score_capture import score_capture
from vtk_capture import CaptureError, record, spheres

FRAMES = 4
RADIUS = 0.8
SIZE = (320, 240)
LEFT, BETWEEN, RIGHT = (((x, -6.0, 2.5), (0.0, 0.0, 0.6), (0, 0, 1), 40.0) for x in (-0.5, 0.0, 0.5))


def center(frame):
    return np.array([0.15 * (frame - 1.5), 0.0, RADIUS])


def build():
    """A plotter of a floor, a wall, glyphs and exact spheres, and what steps it."""
    plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
    plotter.set_background("lightblue")
    for middle, normal, name in (((0, 0, 0), (0, 0, 1), "floor"), ((0, 4, -4), (0, 1, 0), "wall")):
        plane = pyvista.Plane(center=middle, direction=normal, i_size=12, j_size=12, i_resolution=200, j_resolution=200)
        plane["waves"] = np.sin(3 * plane.points[:, 0]) * np.cos(3 * (plane.points[:, 1] + plane.points[:, 2]))
        plotter.add_mesh(plane, scalars="waves", cmap="cividis", name=name)
    cone = pyvista.Cone(center=(1.6, 0.5, 0.6), direction=(0, 0, 1), height=1.2, radius=0.5, resolution=60)
    plotter.add_mesh(cone, color="salmon", name="cone")
    plotter.add_axes()
    plotter.add_text("texts are left out")

    def step(frame):
        places = np.array([center(frame), [-1.7, 0.6, 0.5]])
        balls = spheres(places, [RADIUS, 0.5], [[1.0, 0.55, 0.1], [0.2, 0.7, 0.5]])
        plotter.add_actor(balls, name="balls", reset_camera=False, render=False)

    return plotter, step


def channels(path):
    with OpenEXR.File(path, separate_channels=True) as file:
        return {name: it.pixels.astype(np.float64) for name, it in file.channels().items()}


def check_sphere(folder, camera, frame):
    """Depth against the sphere's own, in pixels on its surface, and normals in degrees."""
    view = vtk_capture.viewpoint("left", camera, SIZE, (0, 0, 1), 30.0)
    lens, pose = view.lens(SIZE), view.pose()
    found = channels(os.path.join(folder, "left", f"{frame:04d}.exr"))
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    ray = np.stack([(x - lens["cx"]) / lens["fl_x"], -(y - lens["cy"]) / lens["fl_y"], -np.ones_like(x)], -1) @ pose[:3, :3].T
    away = pose[:3, 3] - center(frame)
    a, b = np.sum(ray * ray, axis=-1), ray @ away
    inside = b * b - a * (away @ away - RADIUS**2)
    is_in = np.pad(inside > 0, 1)
    # VTK's own outline of a sphere is some pixels short: depth is compared one pixel within it.
    hit = np.all([is_in[1 + dy : 1 + dy + SIZE[1], 1 + dx : 1 + dx + SIZE[0]] for dx in (-1, 0, 1) for dy in (-1, 0, 1)], axis=0)
    truth = (-b - np.sqrt(np.maximum(inside, 0))) / a
    apart = np.abs(found["Z"] - truth)[hit] * lens["fl_x"] / truth[hit]
    normal = (away + truth[..., None] * ray) / RADIUS
    drawn = np.stack([found[name] for name in ("N.X", "N.Y", "N.Z")], -1)
    angle = np.degrees(np.arccos(np.clip(np.sum(normal * drawn, -1)[hit] / np.linalg.norm(drawn[hit], axis=-1), -1, 1)))
    print(f"sphere, {hit.sum()} pixels: depth within {apart.max():.4f} footprints, normals within {angle.max():.3f} degrees")
    assert apart.max() < 0.1 and angle.max() < 0.2


def check_sky(folder):
    found = channels(os.path.join(folder, "left", "0000.exr"))
    sky = found["Z"] >= 1e9
    assert 0 < sky.mean() < 0.5 and np.ptp(found["R"][:5, :5]) == 0, "the sky is the background, without text"


def psnr(first, second):
    """Of two pictures as they are shown."""
    shown = [np.stack([it[name] for name in "RGB"], -1) for it in (first, second)]
    shown = [np.clip(np.where(it <= 0.0031308, 12.92 * it, 1.055 * np.maximum(it, 0) ** (1 / 2.4) - 0.055), 0, 1) for it in shown]
    return -10 * math.log10(np.mean((shown[0] - shown[1]) ** 2))


def check_nearest(folder):
    """Overlook's picture at the third camera against the recorded pictures beside it."""
    ours, nearest = [], []
    for frame in range(FRAMES):
        truth = channels(os.path.join(folder, "novel", "between", f"{frame:04d}.exr"))
        ours.append(psnr(truth, channels(os.path.join(folder, "shown", "between", f"{frame:04d}.exr"))))
        nearest.append(max(psnr(truth, channels(os.path.join(folder, it, f"{frame:04d}.exr"))) for it in ("left", "right")))
    print(f"whole pictures: {np.mean(ours):.2f} dB, the nearest recorded picture {np.mean(nearest):.2f} dB")
    assert min(ours) > max(nearest)


def check_resumed(folder, plotter, step, cameras):
    """What is there stays as it is; what is missing comes back the same; other settings are refused."""
    paths = [os.path.join(folder, "left", f"{frame:04d}.exr") for frame in range(FRAMES)]
    before = [open(path, "rb").read() for path in paths]
    os.remove(paths[2])
    kept = os.stat(paths[1]).st_mtime_ns
    record(plotter, folder, cameras, FRAMES, SIZE, step, truth={"between": BETWEEN})
    assert [open(path, "rb").read() for path in paths] == before and os.stat(paths[1]).st_mtime_ns == kept
    assert not [name for _, _, names in os.walk(folder) for name in names if name.endswith(".part") or name == "recording.json"]
    moved = {**cameras, "left": BETWEEN}
    mistakes = ((moved, "other cameras"), ([(0, 0, 0)], "needs a position"), ("cube:6", "neither"), ([], "no camera"))
    for other, said in mistakes:
        try:
            record(plotter, folder, other, FRAMES, SIZE, step)
        except CaptureError as error:
            assert said in str(error) and "\n" not in str(error), error
        else:
            raise AssertionError(f"{other} was taken")


def check_plain_vtk(folder):
    """A renderer alone, without a window and a light, and the window of another."""
    from vtkmodules.vtkFiltersSources import vtkConeSource
    from vtkmodules.vtkRenderingCore import vtkActor, vtkCamera, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow

    cone, mapper, actor, renderer = vtkConeSource(), vtkPolyDataMapper(), vtkActor(), vtkRenderer()
    mapper.SetInputConnection(cone.GetOutputPort())
    actor.SetMapper(mapper)
    renderer.AddActor(actor)
    record(renderer, os.path.join(folder, "renderer"), 3, size=(80, 60))
    window, camera = vtkRenderWindow(), vtkCamera()
    window.SetOffScreenRendering(True)
    window.AddRenderer(renderer)
    camera.SetPosition(0, -5, 0)
    camera.SetViewUp(0, 0, 1)
    record(window, os.path.join(folder, "window"), [camera], size=(80, 60))
    assert (channels(os.path.join(folder, "window", "camera1", "0000.exr"))["Z"] < 1e9).any()


def check_command(folder):
    """A series of files, by the command, and mistakes in one line."""
    scene = os.path.join(folder, "files")
    os.makedirs(scene, exist_ok=True)
    entries = ""
    for frame in range(2):
        mesh = pyvista.Sphere(center=(0.2 * frame, 0, 0))
        mesh["height"] = mesh.points[:, 2]
        mesh.save(os.path.join(scene, f"{frame}.vtp"))
        entries += f'<DataSet timestep="{0.5 * frame}" file="{frame}.vtp"/>'
    series = os.path.join(scene, "series.pvd")
    with open(series, "w", encoding="utf-8") as file:
        file.write(f'<VTKFile type="Collection"><Collection>{entries}</Collection></VTKFile>')
    command = [sys.executable, SCRIPT]
    out = os.path.join(folder, "from_files")
    options = ["--out", out, "--cameras", "3", "--size", "160x120", "--color-by"]
    done = subprocess.run([*command, series, *options, "height"], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and len(os.listdir(os.path.join(out, "ring3"))) == 2, done.stderr
    for words in ([series, *options, "width"], ["none.pvd", *options, "height"], [__file__, *options, "height"]):
        done = subprocess.run([*command, *words], capture_output=True, text=True, check=False)
        assert done.returncode == 1 and done.stderr.splitlines()[-1].startswith("error: ") and "Traceback" not in done.stderr, done.stderr


def main():
    overlook, folder = sys.argv[1], os.path.abspath(sys.argv[2])
    plotter, step = build()
    cameras = {"left": LEFT, "right": RIGHT}
    record(plotter, folder, cameras, FRAMES, SIZE, step, truth={"between": BETWEEN})
    for frame in range(FRAMES):
        check_sphere(folder, LEFT, frame)
    check_sky(folder)
    score_capture(overlook, folder, f"PyVista {pyvista.__version__}", FRAMES)
    check_nearest(folder)
    check_resumed(folder, plotter, step, cameras)
    check_plain_vtk(folder)
    check_command(folder)


if __name__ == "__main__":
    main()
