# SPDX-License-Identifier: MIT OR Apache-2.0
"""ParaView: records a state over its time steps as a capture that Overlook opens.

    pvpython overlook_paraview.py STATE.pvsm --out FOLDER --cameras ring:6       a state, as File > Save State writes it
    pvpython overlook_paraview.py DATA.pvd --out FOLDER --cameras sphere:12      what ParaView reads, as it shows it at first

    from overlook_paraview import record_view                                    # in ParaView's Python shell: the active view
    record_view("FOLDER", cameras=6, size=(640, 480))

Rendering happens in the process that runs this: pvpython and pvbatch without a server. It needs `python/overlook/vtk_capture.py`, beside
this file or there; see there for what else can be chosen. Written after the documentation of `paraview.simple` 5.11 and later.
"""

import argparse
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "..", "python", "overlook")]
from vtk_capture import CaptureError, add_options, chosen_frames, first_line, record, record_by_options, run


def time_steps(simple):
    """The times that the data has, ascending; one of None where it stands still."""
    found = simple.GetTimeKeeper().TimestepValues
    found = [] if found is None else [found] if isinstance(found, (int, float)) else list(found)
    return found or [None]


def stepping(simple, view, times):
    """`step(frame)`, which shows the data at a time step."""
    scene = simple.GetAnimationScene()

    def step(frame):
        if times[frame] is not None:
            scene.AnimationTime = times[frame]
        simple.Render(view)

    return step


def window_of(view):
    """The vtkRenderer of the data of a render view; its window draws annotations in others."""
    if not hasattr(view, "GetRenderer"):
        raise CaptureError("the view that is active is no render view: charts and tables have nothing to stand around")
    return view.GetRenderer()


def record_view(out, cameras=6, view=None, frames=None, size=(640, 480), **options):
    """Records a render view, the active one by default; `frames` are all time steps or their numbers, everything else is as in
    `vtk_capture.record`."""
    from paraview import simple

    view = view or simple.GetActiveViewOrCreate("RenderView")
    prepare(view, size)
    times = time_steps(simple)
    frames = list(range(len(times)) if frames is None else frames)
    step = stepping(simple, view, times)
    record(window_of(view), out, cameras, frames, size, step, step_jumps=True, times=times_of(frames, times), **options)


def prepare(view, size):
    """Gives a view its size. Axes and the center of rotation are no part of the scene."""
    for name in ("OrientationAxesVisibility", "CenterAxesVisibility"):
        if hasattr(view, name):
            setattr(view, name, 0)
    view.ViewSize = list(size)


def times_of(frames, times):
    """The times of some time steps; None where nothing moves."""
    return None if times == [None] else [times[frame] for frame in frames]


def opened(simple, path):
    """The render view of a state, or of data that is shown as ParaView does at first."""
    if not os.path.exists(path):
        raise CaptureError(f"there is no file {path}")
    if path.endswith((".pvsm", ".png")):
        simple.LoadState(path)
        return simple.GetActiveViewOrCreate("RenderView")
    try:
        source = simple.OpenDataFile(path)
    except RuntimeError as error:
        raise CaptureError(f"ParaView does not read {path}: {first_line(error)}") from error
    if source is None:
        raise CaptureError(f"ParaView does not read {path}")
    view = simple.GetActiveViewOrCreate("RenderView")
    simple.Show(source, view)
    simple.ResetCamera(view)
    return view


def main():
    parser = argparse.ArgumentParser(description="Record what ParaView shows as a capture that Overlook opens.")
    parser.add_argument("state", help="a state (.pvsm), or data that ParaView reads")
    add_options(parser)
    options = parser.parse_args()

    def work():
        try:
            from paraview import simple
        except ImportError as error:
            raise CaptureError(f"this needs ParaView's Python: run it with pvpython ({first_line(error)})") from error

        view = opened(simple, options.state)
        prepare(view, options.size)
        times = time_steps(simple)
        frames = chosen_frames(options.frames, len(times))
        record_by_options(options, window_of(view), frames, times_of(frames, times), stepping(simple, view, times))

    run(work)


if __name__ == "__main__":
    main()
