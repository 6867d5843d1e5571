from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any, final

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
    """Size and projection of a pinhole camera, in pixels. The principal point is measured from the top left corner."""

    def __new__(
        cls,
        width: int,
        height: int,
        fx: float,
        fy: float | None = None,
        cx: float | None = None,
        cy: float | None = None,
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

    def frame(self, camera: str | int, frame: int = 0) -> Frame:
        """One frame of one camera, by its name or index.

        Raises Error with the name of an unreadable file; KeyError or IndexError for an unknown camera or frame."""

    def preprocess(self, settings: Settings | None = None, progress: Progress | None = None) -> Store:
        """Removes each sample that another one shows better. The kept samples stay in memory.

        Raises Error, also for an unknown setting or one out of range."""

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

    def __len__(self) -> int: ...

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
    def report(self) -> dict[str, Any]:
        """The report of preprocessing, as `overlook preprocess --json` prints it."""

    def save(self, path: Path) -> int:
        """Writes the store to a file, rounded by the setting store.precision, and returns its size in bytes.

        An existing file is replaced once the new one is whole."""

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

def open(path: Path, settings: Settings | None = None) -> Capture:
    """Opens a capture: any folder or file that `overlook info` understands.

    Raises Error that names the files searched for, or the fault found."""

def demo(
    name: str, *, cameras: int | None = None, frames: int | None = None, size: tuple[int, int] | None = None
) -> Capture:
    """A built-in scene, "orrery", "nine-cameras" or "four-cameras", whose frames are traced when they are used."""

def open_store(path: Path) -> Store:
    """Opens a store; samples are read from the file when they are used."""

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
