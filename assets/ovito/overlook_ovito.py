# SPDX-License-Identifier: MIT OR Apache-2.0
"""OVITO: records a pipeline over its trajectory as a capture that Overlook opens.

    pip install ovito pyvista
    python overlook_ovito.py TRAJECTORY --out FOLDER --cameras 6        what OVITO reads; "dump.*" for several files

    from overlook_ovito import record_pipeline                          # a pipeline with its modifiers
    record_pipeline(pipeline, "FOLDER", cameras="sphere:12", size=(640, 480))

OVITO's renderers return pictures of 8 bits without depth. So what a pipeline computes is drawn by VTK: particles as exact spheres with
their colors and radii, bonds as cylinders, the cell as lines. Particles of other shapes, surfaces, vectors and other visual elements are
not drawn. It needs `python/overlook/vtk_capture.py`, beside this file or there; see there for what else can be chosen.
"""

import argparse
import os
import sys

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "..", "python", "overlook")]
from vtk_capture import CaptureError, add_options, chosen_frames, first_line, record, record_by_options, run, spheres

WHITE = (1.0, 1.0, 1.0)


def particles_of(data):
    """Positions (n, 3), radii (n,) and colors (n, 3) as OVITO shows them: of each particle, else of its type, else of all."""
    particles = data.particles
    count, vis = particles.count, particles.vis
    radii, colors = np.full(count, 0.0), np.tile(WHITE, (count, 1))
    types = particles.particle_types
    if types is not None:
        for kind in types.types:
            of_kind = np.asarray(types) == kind.id
            radii[of_kind], colors[of_kind] = kind.radius, kind.color
    if particles.get("Radius") is not None:
        own = np.asarray(particles["Radius"])
        radii = np.where(own > 0, own, radii)
    if particles.colors is not None:
        colors = np.asarray(particles.colors)
    return np.asarray(particles.positions), np.where(radii > 0, radii, vis.radius) * vis.scaling, colors


def tubes(starts, ends, colors, radius):
    """A mesh of cylinders from points to points, (n, 3) each; None if there are none."""
    import pyvista

    if not len(starts):
        return None
    points = np.stack([starts, ends], axis=1).reshape(-1, 3)
    cells = np.column_stack([np.full(len(starts), 2), np.arange(2 * len(starts)).reshape(-1, 2)]).ravel()
    lines = pyvista.PolyData(points, lines=cells)
    lines.cell_data["colors"] = np.uint8(np.clip(colors, 0, 1) * 255 + 0.5)
    return lines.tube(radius=radius, n_sides=12)


def bonds_of(data, positions, colors):
    """Starts, ends and colors of half bonds, each in the color of its particle; those across periodic borders end at them."""
    bonds = data.particles.bonds
    pairs = np.asarray(bonds.topology)
    across = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    if bonds.get("Periodic Image") is not None:
        across = across + np.asarray(bonds["Periodic Image"]) @ np.asarray(data.cell)[:, :3].T
    middle = across / 2
    starts = np.concatenate([positions[pairs[:, 0]], positions[pairs[:, 1]]])
    ends = starts + np.concatenate([middle, -middle])
    shown = np.concatenate([colors[pairs[:, 0]], colors[pairs[:, 1]]])
    if bonds.colors is not None:
        shown = np.tile(np.asarray(bonds.colors), (2, 1))
    elif str(bonds.vis.coloring_mode).endswith("Uniform"):
        shown = np.tile(bonds.vis.color, (len(starts), 1))
    return starts, ends, shown


def cell_edges(cell):
    """Starts and ends of the twelve edges."""
    matrix = np.asarray(cell)
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    edges = [(a, b) for a in corners for b in corners if sum(b) - sum(a) == 1 and sum(p != q for p, q in zip(a, b)) == 1]
    place = lambda corner: matrix[:, :3] @ corner + matrix[:, 3]
    return np.array([place(a) for a, _ in edges]), np.array([place(b) for _, b in edges])


def scene_of_pipeline(pipeline, size, background="white"):
    """A plotter of what the pipeline computes, and `step(frame)` that draws a frame of it."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=size)
    plotter.set_background(background)

    def draw(mesh, name):
        if mesh is None:
            plotter.remove_actor(name, render=False)
        else:
            plotter.add_mesh(mesh, scalars="colors", rgb=True, name=name, reset_camera=False, render=False)

    def step(frame):
        data = pipeline.compute(frame)
        if data.particles is None or not data.particles.count:
            raise CaptureError(f"the pipeline has no particles at frame {frame}")
        positions, radii, colors = particles_of(data)
        if data.particles.vis.enabled:
            plotter.add_actor(spheres(positions, radii, colors), name="particles", reset_camera=False, render=False)
        bonds = data.particles.bonds
        if bonds is not None and bonds.vis.enabled:
            draw(tubes(*bonds_of(data, positions, colors), bonds.vis.width / 2), "bonds")
        if data.cell is not None and data.cell.vis.enabled and data.cell.vis.render_cell:
            starts, ends = cell_edges(data.cell)
            # Lines thinner than two pixels have no depth of their own in most of them.
            radius = max(data.cell.vis.line_width / 2, 0.004 * np.linalg.norm(np.ptp(ends, axis=0)))
            draw(tubes(starts, ends, np.tile(data.cell.vis.rendering_color, (len(starts), 1)), radius), "cell")

    return plotter, step


def record_pipeline(pipeline, out, cameras=6, frames=None, size=(640, 480), background="white", **options):
    """Records a pipeline; `frames` are all of it or their numbers, everything else is as in `vtk_capture.record`."""
    plotter, step = scene_of_pipeline(pipeline, size, background)
    record(plotter, out, cameras, range(pipeline.num_frames) if frames is None else frames, size, step, step_jumps=True, **options)


def main():
    parser = argparse.ArgumentParser(description="Record what OVITO reads as a capture that Overlook opens.")
    parser.add_argument("trajectory", help="a file, or several by a pattern with *")
    add_options(parser)
    options = parser.parse_args()

    def work():
        from ovito.io import import_file

        try:
            pipeline = import_file(options.trajectory)
        except RuntimeError as error:
            raise CaptureError(f"OVITO does not read {options.trajectory}: {first_line(error)}") from error
        frames = chosen_frames(options.frames, pipeline.num_frames)
        plotter, step = scene_of_pipeline(pipeline, options.size, options.background)
        record_by_options(options, plotter, frames, None, step)

    run(work)


if __name__ == "__main__":
    main()
