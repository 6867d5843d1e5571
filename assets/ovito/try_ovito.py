# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tries the script for real: records a pipeline of `ovito` with bonds, and opens it in Overlook.

    pip install ovito pyvista OpenEXR && python try_ovito.py OVERLOOK FOLDER

The outline of each recorded picture has to be that of OVITO's own picture from the same place, the views have to agree, and nothing may be
warned of. Needs no display.
"""

import json
import math
import os
import subprocess
import sys

import numpy as np
import OpenEXR

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]
from ovito.io import import_file
from ovito.modifiers import CreateBondsModifier
from ovito.vis import TachyonRenderer, Viewport
from overlook_ovito import record_pipeline
from score_capture import run
from vtk_capture import Viewpoint

SIZE = (240, 180)
BOX = 12.0


def write_trajectory(path):
    """Two frames of two kinds of atoms around the corners of a lattice; bonds go across the border of the box."""
    places = np.stack(np.meshgrid(*[np.arange(4) * 3.0 + 1.0] * 3), -1).reshape(-1, 3)
    rng = np.random.default_rng(1)
    with open(path, "w", encoding="utf-8") as file:
        for frame in range(2):
            moved = places + rng.normal(size=places.shape) * 0.15
            file.write(f'{len(places)}\nLattice="{BOX} 0 0 0 {BOX} 0 0 0 {BOX}" pbc="T T T" Properties=species:S:1:pos:R:3\n')
            for index, (x, y, z) in enumerate(moved):
                file.write(f"{'Cu' if index % 3 else 'O'} {x} {y} {z}\n")


def grown(mask):
    """The mask and what lies beside it."""
    wide = np.pad(mask, 1)
    return np.any([wide[1 + y : 1 + y + SIZE[1], 1 + x : 1 + x + SIZE[0]] for x in (-1, 0, 1) for y in (-1, 0, 1)], axis=0)


def main():
    overlook, folder = sys.argv[1], os.path.abspath(sys.argv[2])
    os.makedirs(folder, exist_ok=True)
    trajectory = os.path.join(folder, "atoms.xyz")
    write_trajectory(trajectory)
    pipeline = import_file(trajectory)
    pipeline.modifiers.append(CreateBondsModifier(cutoff=3.4))
    pipeline.compute().cell_.vis.enabled = False
    pipeline.add_to_scene()
    capture = os.path.join(folder, "capture")
    sides = np.array([[0.9, 0.0, 0.43], [0.6, 0.7, 0.4], [0.0, 0.9, 0.43], [-0.6, 0.7, 0.4]])
    views = [Viewpoint(f"view{index}", tuple(6 + 32 * side), (6, 6, 6)) for index, side in enumerate(sides)]
    record_pipeline(pipeline, capture, {it.name: (it.position, it.focal_point, it.up, it.view_angle) for it in views}, size=SIZE)
    for frame in range(2):
        for view in views:
            look = np.subtract(view.focal_point, view.position)
            window = Viewport(type=Viewport.Type.Perspective, camera_pos=view.position, camera_dir=look, camera_up=view.up)
            window.fov = math.radians(view.view_angle)
            picture = window.render_image(size=SIZE, frame=frame, alpha=True, renderer=TachyonRenderer(antialiasing=False))
            bits = np.frombuffer(picture.constBits(), np.uint8).reshape(SIZE[1], picture.bytesPerLine())[:, : 4 * SIZE[0]]
            theirs = bits.reshape(SIZE[1], SIZE[0], 4)[..., 3] > 127
            with OpenEXR.File(os.path.join(capture, view.name, f"{frame:04d}.exr"), separate_channels=True) as file:
                ours = file.channels()["Z"].pixels < 1e9
            # OVITO's pixels lie half a pixel aside.
            apart = (ours & ~grown(theirs)).sum() + (theirs & ~grown(ours)).sum()
            print(f"frame {frame}, {view.name}: {ours.sum()} pixels show something, {apart} lie farther than a pixel from OVITO's or ours")
            assert apart <= 0.001 * ours.sum()
    info = json.loads(run(overlook, "info", capture, "--json"))
    assert not info["warnings"] and not info["conventions"]["is_warning"], info


if __name__ == "__main__":
    main()
