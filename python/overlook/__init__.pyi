from collections.abc import Callable, Iterable, Mapping
from os import PathLike
from typing import Any, Literal, final

import numpy as np
from numpy.typing import NDArray

__version__: str

Path = str | PathLike[str]
Settings = Mapping[str, str | float | bool]
"""Settings by the names that `overlook settings` prints: {"pruning.depth_tolerance": 2, "render.kernel": "block"}."""
Progress = Callable[[str, int, int], object]
"""Called with the stage, the units done and their total, about twenty times a second; what it raises stops the work."""

class Error(Exception):
    """What is wrong, where, and what to do about it: the line that the command line prints."""

@final
class Lens:
    """Size and projection of a camera, in pixels. The principal point is measured from the top left corner. `fx` and `fy` of an orthographic
    camera are pixels per world unit."""

    def __new__(
        cls,
        width: int,
        height: int,
        fx: float,
        fy: float | None = None,
        cx: float | None = None,
        cy: float | None = None,
        orthographic: bool = False,
    ) -> Lens:
        """`fy` is `fx` if it is not given, the principal point the middle of the picture."""

    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def fx(self) -> float: ...
    @property
    def fy(self) -> float: ...
    @property
    def cx(self) -> float: ...
    @property
    def cy(self) -> float: ...
    @property
    def orthographic(self) -> bool: ...

@final
class Camera:
    """A camera of a capture."""

    @property
    def name(self) -> str: ...
    @property
    def lens(self) -> Lens: ...
    @property
    def pose(self) -> NDArray[np.float64]:
        """World from camera, (4, 4)."""

@final
class ValueChannel:
    """What the numbers of one channel of scalar values mean."""

    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str:
        """Empty where there is none."""

    @property
    def range(self) -> tuple[float, float]:
        """Between which values colors run; values may lie outside."""

    @property
    def tolerance(self) -> float:
        """Values that differ by no more are the same to pruning."""

@final
class Frame:
    """One frame of one camera, as the engine understood its files."""

    @property
    def color(self) -> NDArray[np.float32]:
        """Linear Rec.709, (height, width, 3)."""

    @property
    def depth(self) -> NDArray[np.float32]:
        """Planar z in the capture's unit, (height, width); infinite at the sky, NaN without depth."""

    @property
    def normal_in_world(self) -> NDArray[np.float32] | None:
        """Unit vectors toward the camera, (height, width, 3), zero without a normal; None if the capture has no normals."""

    @property
    def values(self) -> dict[str, NDArray[np.float32]]:
        """Scalar values by the names of their channels, (height, width); NaN where one is missing. Empty if the capture has none."""

@final
class Capture:
    """What was recorded. A frame is decoded when it is used."""

    @property
    def name(self) -> str: ...
    @property
    def cameras(self) -> list[Camera]: ...
    @property
    def frame_numbers(self) -> list[int]:
        """The number of each frame in the capture, ascending. All other calls take the index in this list."""

    @property
    def warnings(self) -> list[str]:
        """Problems found while opening that did not stop it."""

    @property
    def values(self) -> list[ValueChannel]:
        """The channels of scalar values; empty if the capture has none."""

    def frame(self, camera: str | int, frame: int = 0) -> Frame:
        """One frame of one camera, by its name or index.

        Raises Error with the name of an unreadable file; KeyError or IndexError for an unknown camera or frame."""

    def preprocess(
        self, settings: Settings | None = None, progress: Progress | None = None, *, edits: Path | None = None
    ) -> Store:
        """Removes each sample that another one shows better. The kept samples stay in memory.

        `edits` is an edit list, by its path or as its text, as `overlook preprocess --edits` takes it.
        Raises Error, also for an unknown setting or one out of range, and for a list that is wrong."""

@final
class Samples:
    """Kept samples, one row each: n rows."""

    @property
    def camera(self) -> NDArray[np.uint32]:
        """Index of the camera, (n,)."""

    @property
    def pixel(self) -> NDArray[np.uint32]:
        """Column and row in its picture, (n, 2)."""

    @property
    def span(self) -> NDArray[np.uint32]:
        """First frame over which the sample holds, and one past the last, (n, 2)."""

    @property
    def color(self) -> NDArray[np.float32]:
        """Linear Rec.709, (n, 3)."""

    @property
    def depth(self) -> NDArray[np.float32]:
        """Planar z in the camera, (n,); infinite at the sky."""

    @property
    def point_in_world(self) -> NDArray[np.float64]:
        """(n, 3); infinite along its direction where depth is."""

    @property
    def normal_in_world(self) -> NDArray[np.float32] | None:
        """Unit vectors, (n, 3); None unless the setting store.normals keeps them."""

    @property
    def values(self) -> dict[str, NDArray[np.float32]]:
        """Scalar values by the names of their channels, (n,), those of the first frame of the span; NaN where one is missing."""

    def __len__(self) -> int: ...

@final
class Splats:
    """The samples of a frame as flat Gaussians, one row each: n rows."""

    @property
    def center_in_world(self) -> NDArray[np.float64]:
        """In the capture's unit, (n, 3)."""

    @property
    def rotation(self) -> NDArray[np.float32]:
        """Unit quaternions w x y z, (n, 4), from the axes of the Gaussian to those of the world. The third axis is the normal of the
        surface, on the side that was seen."""

    @property
    def scale(self) -> NDArray[np.float32]:
        """Standard deviations along these axes in the capture's unit, (n, 3): the longest, the other on the surface, the thickness."""

    @property
    def color(self) -> NDArray[np.float32]:
        """Linear Rec.709, 0 to 1, (n, 3), the same from everywhere."""

    @property
    def opacity(self) -> NDArray[np.float32]:
        """0 to 1, (n,); lower for samples that no other camera confirms."""

    def __len__(self) -> int: ...

@final
class Page:
    """One HTML file that plays a scene. A notebook shows it."""

    @property
    def html(self) -> str: ...
    def save(self, path: Path) -> None:
        """Writes it to a file."""

    def _repr_html_(self) -> str:
        """A sentence, and the page in a frame."""

@final
class Placement:
    """Cameras that were placed. Shares are of all surface that the coarse capture saw, 0 to 1; a surface counts in proportion to the
    rate that is asked for."""

    @property
    def cameras(self) -> list[Camera]:
        """By what each adds. Principal points are in the middle."""

    @property
    def adds(self) -> NDArray[np.float64]:
        """What each adds to those before it, (n,)."""

    @property
    def seen(self) -> float:
        """What all of them see."""

    @property
    def coarse_cameras_see(self) -> float:
        """What the cameras of the coarse capture see."""

    @property
    def unseen(self) -> float:
        """What none of the placed cameras sees at all."""

    @property
    def unseen_points_in_world(self) -> NDArray[np.float64]:
        """Points of that surface, (m, 3)."""

    def save(self, path: Path) -> None:
        """Writes the poses as a manifest, which `record_pyvista` and the scripts for Blender and Mitsuba take for cameras."""

@final
class Store:
    """The kept samples of a capture, in memory or played from a file."""

    @property
    def name(self) -> str: ...
    @property
    def cameras(self) -> list[Camera]: ...
    @property
    def frame_numbers(self) -> list[int]: ...
    @property
    def warnings(self) -> list[str]:
        """What looks wrong in the capture, or is damaged in the file."""

    @property
    def values(self) -> list[ValueChannel]:
        """The channels of scalar values; empty if the samples have none."""

    @property
    def report(self) -> dict[str, Any]:
        """The report of preprocessing, as `overlook preprocess --json` prints it."""

    def save(self, path: Path) -> int:
        """Writes the store to a file, rounded by the setting store.precision, and returns its size in bytes.

        An existing file is replaced once the new one is whole."""

    def export_page(
        self, path: Path, *, title: str | None = None, text: str | None = None, fps: float = 24.0, at_most: int | None = None
    ) -> int:
        """Writes one HTML file that plays the scene in any browser, as `overlook export page` does, and returns its size in bytes.

        `title` is the name of the capture if it is not given; empty lines part the paragraphs of `text`. Beyond `at_most` bytes, samples
        are merged where that shows least. Raises Error if no page is as small, or if the store holds no sample."""

    def page(
        self,
        *,
        title: str | None = None,
        text: str | None = None,
        fps: float = 24.0,
        at_most: int = 8_000_000,
        height: int = 480,
    ) -> Page:
        """The same page for a notebook, `height` CSS pixels high. The notebook keeps what it shows: hence the budget."""

    def splats(self, frame: int = 0, *, at_most: int | None = None, sky: Literal["out", "dome"] = "out") -> Splats:
        """The samples that show one frame as flat Gaussians, in world space.

        Beyond `at_most` rows, samples are merged where that loses least. Samples at infinity are left out, or become a far dome.
        Raises IndexError for an unknown frame, Error if the file is damaged or so few cannot be had."""

    def samples(self, frame: int | None = None, camera: int | None = None) -> Samples:
        """The samples that show one frame, or of all spans; of one camera, or of all.

        Raises IndexError for an unknown frame or camera, Error if the file is damaged."""

    def render(
        self,
        pose: NDArray[np.float64],
        lens: Lens,
        frame: int = 0,
        settings: Settings | None = None,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_]]:
        """A picture from any place: color, depth and coverage.

        `pose` is world from camera, (4, 4) or (3, 4). Color is linear Rec.709, (height, width, 3); depth is planar z, (height,
        width), infinite at the sky, NaN in holes that were not filled; coverage is True where a sample was seen, and False where
        the picture was filled.

        Raises Error if the viewpoint is not a valid camera, ValueError if the pose is not a rigid motion."""

    def render_values(
        self,
        pose: NDArray[np.float64],
        lens: Lens,
        frame: int = 0,
        settings: Settings | None = None,
    ) -> dict[str, NDArray[np.float32]]:
        """The scalar values that the same picture shows, by the names of their channels, (height, width): in each pixel those of the
        nearest sample, never blended; NaN in holes, filled or not, and where one is missing.

        Raises as `render`."""

def open(path: Path, settings: Settings | None = None) -> Capture:
    """Opens a capture: any folder or file that `overlook info` understands.

    Raises Error that names the files searched for, or the fault found."""

def demo(
    name: str, *, cameras: int | None = None, frames: int | None = None, size: tuple[int, int] | None = None
) -> Capture:
    """A built-in scene, "orrery", "nine-cameras", "four-cameras" or "crystal", whose frames are traced when they are used."""

def place(
    capture: Capture,
    cameras: int = 6,
    *,
    ring: bool = False,
    within: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None,
    size: tuple[int, int] | None = None,
    rate: float | None = None,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> Placement:
    """The poses that together show most of what a first capture of few pixels saw, before the expensive pictures are made.

    They stand between the cameras of the capture, or with `ring` anywhere around, as far and as high as these, or `within` a box, given
    by its lowest and highest coordinates. `size` is columns and rows of their pictures, that of the capture if it is not given; the angle
    of view is the capture's. Surfaces should be seen with `rate` pixels a unit, or else as finely as the finest picture of the capture
    shows them.

    Raises Error where nothing can be placed."""

def open_store(path: Path, *, edits: Path | None = None) -> Store:
    """Opens a store; samples are read from the file when they are used.

    With `edits`, an edit list by its path or as its text, it is what the list leaves: pictures, pages and files that are made of it are
    those of the command line with `--edits`. Raises Error for a list that is wrong, or that asks which cameras confirm samples."""

def evaluate(
    capture: Capture,
    *,
    views: Path | None = None,
    hold_out: list[str] | None = None,
    align_views: bool = False,
    settings: Settings | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Accuracy, speed and size of one setting, beside no pruning and first camera wins.

    The truth is the manifest `views`, or the cameras named in `hold_out`, or else the folder `novel` of the capture. With
    `align_views`, each view is also scored at the pose that its own true picture shows. The keys are `as_set`, `no_pruning` and
    `first_camera`, each as `overlook evaluate --json` prints it."""

Viewpoint = tuple[Any, ...] | Mapping[str, Any] | object
"""A position and a focal point, with up direction and view angle in degrees or without; a mapping with these keys; or a vtkCamera."""

def record_pyvista(
    plotter: object,
    out: Path,
    cameras: int | str | Iterable[Viewpoint] | Mapping[str, Viewpoint] = 6,
    frames: int | Iterable[int] = 1,
    size: tuple[int, int] | None = None,
    step: Callable[[int], object] | None = None,
    *,
    truth: int | str | Iterable[Viewpoint] | Mapping[str, Viewpoint] | None = None,
    times: Iterable[float] | None = None,
    up: tuple[float, float, float] = (0, 0, 1),
    view_angle: float = 30.0,
    bounds: tuple[float, float, float, float, float, float] | None = None,
    lights: Literal["fixed", "as_set"] = "fixed",
    antialias: int | None = None,
    normals: bool = True,
    values: Iterable[str | Mapping[str, Any]] | Mapping[str, str | None] | None = None,
    step_jumps: bool = False,
    overwrite: bool = False,
) -> None:
    """Records a pyvista.Plotter, a vtkRenderWindow or a vtkRenderer as a capture in the folder `out`. Needs VTK, which `pip install
    pyvista` brings.

    `cameras` and true views, `truth`, are given, or placed around the scene: a number or "ring:6", "sphere:12", "inside:6"; or they are
    the content of a manifest, as `place` writes it. `frames` is a
    number of frames, or their numbers; `step(frame)` changes the scene before each. `size` is columns and rows, that of the window if it
    is not given. `values` are up to four arrays of points or cells whose numbers are recorded beside the colors: their names, units by
    names as in {"pressure": "Pa"}, or what the manifest says of each. `overlook.vtk_capture.record` is the same function, and says the rest.

    Raises overlook.vtk_capture.CaptureError, a ValueError, with one line on what is wrong."""
