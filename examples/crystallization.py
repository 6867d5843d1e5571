# SPDX-License-Identifier: MIT OR Apache-2.0
"""From a simulation to a page that plays it: a drop of melt freezes around a seed, seen from any side in any browser.

    pip install numpy pyvista
    python examples/crystallization.py FOLDER                       a minute or two on two cores; OVERLOOK names the program
    python examples/crystallization.py FOLDER --atoms 400 --frames 6 --size 240x180

FOLDER then holds the capture, `crystal.ovl` and `crystal.html`.
"""

import argparse
import os
import subprocess
import sys

import numpy as np
import pyvista

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "python", "overlook"))
from vtk_capture import record, spheres

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder")
parser.add_argument("--atoms", type=int, default=900)
parser.add_argument("--frames", type=int, default=20)
parser.add_argument("--size", default="480x360", metavar="WxH")
options = parser.parse_args()
overlook = os.environ.get("OVERLOOK", "overlook")


# 1. The simulation. Lennard-Jones units: lengths in atom diameters, a time step of 0.005, temperatures in well depths.

CUTOFF, SKIN, STEP = 2.5, 0.4, 0.005
rng = np.random.default_rng(7)


def drop_of_lattice(count):
    """The `count` lattice places nearest to the middle; the first ones are the seed."""
    edge = (4 / 1.03) ** (1 / 3)
    cell = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]])
    corners = np.stack(np.meshgrid(*[np.arange(-9, 10)] * 3, indexing="ij"), -1).reshape(-1, 1, 3)
    places = ((corners + cell) * edge).reshape(-1, 3)
    order = np.argsort(np.round(np.sum(places**2, axis=1), 6), kind="stable")
    return places[order[:count]]


def squares_apart(places):
    """Squared distances of all pairs, (n, n)."""
    square = np.sum(places**2, axis=1)
    return square[:, None] + square - 2 * places @ places.T


def forces(places, pairs):
    one, other = pairs
    between = [axis[one] - axis[other] for axis in places.T]
    inverse = 1 / (between[0] ** 2 + between[1] ** 2 + between[2] ** 2)
    sixth = inverse * inverse * inverse
    push = 24 * inverse * sixth * (2 * sixth - 1) * (inverse > CUTOFF**-2)
    total = [np.bincount(one, push * axis, len(places)) - np.bincount(other, push * axis, len(places)) for axis in between]
    # A soft wall keeps what evaporates.
    radius = np.linalg.norm(places, axis=1)
    return np.stack(total, axis=1) - (20 * np.maximum(radius - wall, 0) / np.maximum(radius, 1e-9))[:, None] * places


def run(steps, temperature, friction):
    """Langevin dynamics; the seed stays where it is."""
    global places, speeds
    fade = np.exp(-friction * STEP)
    for step in range(steps):
        if step % 10 == 0:
            pairs = np.nonzero(np.triu(squares_apart(places) < (CUTOFF + SKIN) ** 2, 1))
            push = forces(places, pairs)
        speeds[seed:] += 0.5 * STEP * push[seed:]
        places += 0.5 * STEP * speeds
        speeds[seed:] = fade * speeds[seed:] + np.sqrt(temperature * (1 - fade**2)) * rng.normal(size=speeds[seed:].shape)
        places += 0.5 * STEP * speeds
        push = forces(places, pairs)
        speeds[seed:] += 0.5 * STEP * push[seed:]


def order():
    """How regular the surroundings of each atom are, 0 to 1: in a crystal neighbors lie opposite each other."""
    nearest = np.argsort(squares_apart(places), axis=1)[:, 1:13]
    arms = places[nearest] - places[:, None]
    arms /= np.linalg.norm(arms, axis=-1, keepdims=True)
    opposite = np.sum(arms @ arms.transpose(0, 2, 1) < -0.94, axis=(1, 2)) / 2
    own = np.clip((opposite - 1) / 4, 0, 1)
    # Averaged with the neighbors, which steadies it.
    return 0.4 * own + 0.6 * own[nearest].mean(axis=1)


places = drop_of_lattice(options.atoms)
speeds = np.zeros_like(places)
seed = 43 if options.atoms > 200 else 13
wall = np.linalg.norm(places, axis=1).max() + 1.0
run(1200, 1.1, 1.0)  # melts all but the seed


# 2. The scene, and how it goes on.

LIQUID, CRYSTAL = np.array([0.16, 0.42, 0.75]), np.array([1.0, 0.72, 0.2])
plotter = pyvista.Plotter(off_screen=True)
plotter.set_background("white")


def step(frame):
    if frame > 0:
        run(300, 0.3, 0.2)
    regular = order()
    share = np.clip((regular - 0.2) / 0.4, 0, 1)[:, None]
    # Atoms of the melt are drawn small, so that the crystal in it is seen.
    atoms = spheres(places, 0.2 + 0.3 * share[:, 0], (1 - share) * LIQUID + share * CRYSTAL)
    plotter.add_actor(atoms, name="atoms", reset_camera=False, render=False)
    print(f"frame {frame}: {100 * np.mean(regular > 0.5):.0f} % crystal", file=sys.stderr)


# 3. The recording: six cameras around all of it, and two true views between them to measure the accuracy with.

room = 0.78 * wall  # of a box whose corners would be outside of the drop
size = tuple(int(side) for side in options.size.split("x"))
record(plotter, options.folder, "ring:6", options.frames, size, step, truth="ring:2", bounds=[-room, room] * 3)


# 4. The page.

store, page = (os.path.join(options.folder, name) for name in ("crystal.ovl", "crystal.html"))
# What is simulated has no noise: what seems to stand still for a while then really does.
subprocess.run([overlook, "preprocess", options.folder, "--out", store], check=True)
subprocess.run([overlook, "export", "page", store, "--out", page, "--title", "A drop freezes", "--fps", "8"], check=True)
