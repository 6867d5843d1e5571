"""See, prune and explore animated scenes recorded as color and depth by several cameras.

    capture = overlook.open("capture")              # any folder that `overlook info` understands
    store = capture.preprocess()                    # keeps the best-sampled pixel of every surface point
    camera = capture.cameras[0]
    color, depth, coverage = store.render(camera.pose, camera.lens, frame=0)
    store.page()                                    # plays in a notebook; export_page writes it to a file

Camera space: x right, y down, z forward. World space: right-handed, meters unless the capture says otherwise. Pixel (x, y) is
column x and row y, its center at +0.5; arrays are indexed [y, x]. Color is linear Rec.709. Depth is planar z: infinite at the
sky, NaN without depth. A call may run for long: it lets other threads run, and Ctrl-C stops it.
"""

from ._engine import (
    Camera,
    Capture,
    Error,
    Frame,
    Lens,
    Page,
    Placement,
    Samples,
    Splats,
    Store,
    ValueChannel,
    __version__,
    demo,
    evaluate,
    open,
    open_store,
    place,
)

__all__ = [
    "Camera",
    "Capture",
    "Error",
    "Frame",
    "Lens",
    "Page",
    "Placement",
    "Samples",
    "Splats",
    "Store",
    "ValueChannel",
    "demo",
    "evaluate",
    "open",
    "open_store",
    "place",
    "record_pyvista",
]


def record_pyvista(plotter, out, *arguments, **options):
    """Records a pyvista.Plotter, a vtkRenderWindow or a vtkRenderer as a capture; see `overlook.vtk_capture.record`."""
    # Nobody else needs it, and `python -m overlook.vtk_capture` runs it once.
    from .vtk_capture import record

    record(plotter, out, *arguments, **options)
