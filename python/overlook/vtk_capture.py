# SPDX-License-Identifier: MIT OR Apache-2.0
"""VTK and PyVista: records a scene over its time steps as a capture that Overlook opens.

    import overlook
    overlook.record_pyvista(plotter, "FOLDER", cameras="ring:6", frames=20, size=(640, 480), step=lambda frame: move(frame))

    python -m overlook.vtk_capture SCENE.pvd --out FOLDER --cameras 6 --color-by pressure --values pressure=Pa

The first takes a `pyvista.Plotter`, a `vtkRenderWindow` or a `vtkRenderer`; `step(frame)` changes it before each frame. The second takes
what PyVista reads; several files are time steps. Neither needs a display. This file also works alone, without the rest of the package: it
is `from vtk_capture import record`, and `python vtk_capture.py`, there. Written are

    FOLDER/transforms.json, FOLDER/CAMERA/0000.exr ...       color, planar depth and world-space normals
    FOLDER/novel/transforms.json, FOLDER/novel/CAMERA/...    the same of true views (`truth`), which Overlook measures its accuracy against

Color is linear, with the window's own multisampling. Depth and normals are drawn in a pass of their own without it: they are those at
each pixel's center. So are `values`, the numbers of arrays of what is drawn. Lights that follow the camera would color a surface otherwise from each camera: while recording, lights that stand in
the scene take their place (`lights="as_set"` keeps them). Left out is what turns with the camera or lies on the picture: texts, scalar
bars, axes. What is translucent and volumes have no depth of their own: their color counts as that of what is behind them. A surface that
scalars make translucent in part, as `nan_opacity=0` does, has depth where it is opaque.

Recording may be stopped and started again: pictures that are there are kept, and the manifest is written when all are.
"""

import argparse
import contextlib
import itertools
import json
import math
import os
import re
import struct
import sys
import time
import zlib
from dataclasses import dataclass

import numpy as np

MISS = 1e10
"""The depth of a pixel where nothing is."""
TURNS_WITH_THE_CAMERA = ("Follower", "CubeAxes", "AxisActor", "AxesActor", "BillboardText", "GridAxes")
# What VTK calls normalVCVSOutput is the normal in camera space. It is folded into an octahedron, whose two coordinates take 12 bits each.
# Black would be the normal that points straight away from the camera: it says that there is none.
NORMAL_AS_COLOR = """//VTK::Picking::Impl
  {
    vec3 unit = normalize(normalVCVSOutput);
    unit /= abs(unit.x) + abs(unit.y) + abs(unit.z);
    vec2 side = vec2(unit.x >= 0.0 ? 1.0 : -1.0, unit.y >= 0.0 ? 1.0 : -1.0);
    vec2 place = unit.z >= 0.0 ? unit.xy : (1.0 - abs(unit.yx)) * side;
    vec2 level = floor((place * 0.5 + 0.5) * 4095.0 + 0.5);
    float mixed = mod(level.x, 16.0) * 16.0 + floor(level.y / 256.0);
    gl_FragData[0] = vec4(floor(level.x / 16.0), mixed, mod(level.y, 256.0), 255.0) / 255.0;
  }
"""
MOST_VALUES = 4
"""Overlook takes so many values a pixel."""
MOST_PARTS = (1 << 24) - 1
"""As many numbers as colors of three bytes tell apart; black is none."""
RADIUS, COLOR = "radius of spheres", "color of spheres"
BLACK = "//VTK::Picking::Impl\n  gl_FragData[0] = vec4(0.0, 0.0, 0.0, 1.0);\n"
OPAQUE_ALONE = "//VTK::Picking::Impl\n  if (gl_FragData[0].a < 0.999) { discard; }\n"


# Directions and intensities along the axes of an icosahedron: mostly from above and one side. No surface gets more than 1 in sum.
LIGHTS = (
    ((0, 1, 1.618), 0.2),
    ((0, 1, -1.618), 0.46),
    ((1, 1.618, 0), 0.03),
    ((1, -1.618, 0), 0.19),
    ((1.618, 0, 1), 0.47),
    ((-1.618, 0, 1), 0.03),
)


class CaptureError(ValueError):
    """What keeps a capture from being recorded, in one line."""


@dataclass
class Viewpoint:
    """A camera; positions in the scene's units, `view_angle` from top to bottom in degrees, as in VTK; where lines of sight are parallel,
    `parallel_scale` is half of the scene's units from top to bottom."""

    name: str
    position: tuple
    focal_point: tuple
    up: tuple = (0.0, 0.0, 1.0)
    view_angle: float = 30.0
    parallel_scale: float | None = None

    def pose(self):
        """Camera to world, (4, 4): x right, y up, looking along -z."""
        position, focal_point, up = (np.array(it, dtype=np.float64) for it in (self.position, self.focal_point, self.up))
        back = position - focal_point
        right = np.cross(up, back)
        for vector, wrong in ((back, "looks at the place where it stands"), (right, "looks along its up direction")):
            if not np.all(np.isfinite(vector)) or np.linalg.norm(vector) < 1e-9 * (1 + np.abs(position).max()):
                raise CaptureError(f"camera '{self.name}' {wrong}")
        back, right = back / np.linalg.norm(back), right / np.linalg.norm(right)
        pose = np.eye(4)
        pose[:3] = np.stack([right, np.cross(back, right), back, position], axis=1)
        return pose

    def lens(self, size):
        """The lens of a picture of `size` (columns, rows), in pixels."""
        if not 0 < self.view_angle < 180:
            raise CaptureError(f"camera '{self.name}' has a view angle of {self.view_angle} degrees; it must be between 0 and 180")
        width, height = size
        if self.parallel_scale is not None and not 0 < self.parallel_scale < math.inf:
            raise CaptureError(f"camera '{self.name}' has a parallel scale of {self.parallel_scale}; it must be above 0")
        focal = height / (2 * (self.parallel_scale or math.tan(math.radians(self.view_angle) / 2)))
        model = {"camera_model": "ORTHOGRAPHIC"} if self.parallel_scale else {}
        return {"w": width, "h": height, "fl_x": focal, "fl_y": focal, "cx": width / 2, "cy": height / 2, **model}


def viewpoints(cameras, size, bounds, up=(0, 0, 1), view_angle=30.0, turned=0.0):
    """A list of Viewpoint of what is asked for: a number or "ring:6", "sphere:12", "inside:6", which are placed around `bounds` (xmin,
    xmax, ymin ...); a list, or an object by names, of (position, focal point[, up[, view angle]]), of objects with these keys, or of
    vtkCamera; or what a manifest holds, as `overlook place` writes it. What is placed is `turned` by a share of a full turn."""
    if isinstance(cameras, (int, str)):
        layout, _, number = str(cameras).rpartition(":")
        layout = layout or "ring"
        if layout not in ("ring", "sphere", "inside") or not number.isdigit() or int(number) == 0:
            raise CaptureError(f"cameras '{cameras}' are neither a number nor ring:N, sphere:N or inside:N")
        return placed(layout, int(number), size, bounds, up, view_angle, turned)
    if isinstance(cameras, dict) and isinstance(cameras.get("frames"), list):
        return viewpoints_of_manifest(cameras)
    named = cameras.items() if isinstance(cameras, dict) else ((None, it) for it in cameras)
    found = []
    for index, (name, camera) in enumerate(named):
        if name is None:
            name = camera.get("name") if isinstance(camera, dict) else None
        found.append(viewpoint(name or f"camera{index + 1}", camera, size, up, view_angle))
    if not found:
        raise CaptureError("there is no camera")
    return found


def viewpoints_of_manifest(manifest):
    """The cameras of a manifest of poses, each once. Their view angles are the manifest's; the size of pictures is the recording's."""
    found = {}
    for index, entry in enumerate(manifest["frames"]):
        name = entry.get("camera") or f"camera{index + 1}"
        try:
            pose = np.array(entry["transform_matrix"], dtype=np.float64)[:3]
            width, height, across, down, x, y = (float(entry.get(it, manifest.get(it))) for it in ("w", "h", "fl_x", "fl_y", "cx", "cy"))
        except (KeyError, TypeError, ValueError) as error:
            raise CaptureError(f"camera '{name}' of the manifest has no pose and lens: {first_line(error)}") from error
        is_centered = abs(2 * x - width) < 1e-3 * width and abs(2 * y - height) < 1e-3 * height
        if pose.shape != (3, 4) or abs(across / down - 1) > 1e-3 or not is_centered:
            raise CaptureError(f"camera '{name}' of the manifest has a shifted lens, or pixels that are not square")
        eye, angle = pose[:, 3], math.degrees(2 * math.atan(height / (2 * down)))
        is_parallel = entry.get("camera_model", manifest.get("camera_model")) == "ORTHOGRAPHIC"
        lens = (30.0, height / (2 * down)) if is_parallel else (angle,)
        found.setdefault(name, Viewpoint(name, tuple(eye), tuple(eye - pose[:, 2]), tuple(pose[:, 1]), *lens))
    return list(found.values())


def viewpoint(name, camera, size, up, view_angle):
    """One camera in any of the forms of `viewpoints`."""
    if hasattr(camera, "GetViewAngle"):
        if camera.GetUseOffAxisProjection() or camera.GetUseExplicitProjectionTransformMatrix() or any(camera.GetWindowCenter()):
            raise CaptureError(f"camera '{name}' is shifted off its axis")
        angle = camera.GetViewAngle()
        if camera.GetUseHorizontalViewAngle():
            angle = math.degrees(2 * math.atan(math.tan(math.radians(angle) / 2) * size[1] / size[0]))
        scale = camera.GetParallelScale() if camera.GetParallelProjection() else None
        return Viewpoint(name, camera.GetPosition(), camera.GetFocalPoint(), camera.GetViewUp(), angle, scale)
    if isinstance(camera, dict):
        camera = [camera.get(key) for key in ("position", "focal_point", "up", "view_angle")]
    try:
        place, target, upward, angle = [*camera, None, None, None, None][:4]
        places = [tuple(float(number) for number in it) for it in (place, target, up if upward is None else upward)]
        angle = float(view_angle if angle is None else angle)
    except (TypeError, ValueError):
        places = [()]
    if any(len(it) != 3 for it in places):
        raise CaptureError(f"camera '{name}' needs a position, a focal point and an up direction of three numbers each")
    return Viewpoint(name, *places, angle)


def placed(layout, number, size, bounds, up, view_angle, turned):
    """`ring`: around the scene, from above and below in turn; `sphere`: from all sides; `inside`: from the middle outward."""
    low, high = np.array(bounds[0::2], dtype=np.float64), np.array(bounds[1::2], dtype=np.float64)
    if not np.all(np.isfinite(low)) or np.any(high < low) or not np.any(high > low):
        raise CaptureError("the scene shows nothing that cameras could be placed around; give its bounds, or the cameras")
    middle, radius = (low + high) / 2, np.linalg.norm(high - low) / 2
    first, second, up = upright(up)
    count = np.arange(number)
    if layout == "ring" or number < 5:
        turn, tilt = count / number, np.radians(25.0 if layout == "ring" else 0.0) * np.where(count % 2 == 0, 1.0, -1.0)
        needed = 400 / number
    else:
        # Evenly over the sphere, along a spiral.
        turn, tilt = count * (1 + 5**0.5) / 2, np.arcsin(1 - (2 * count + 1) / number)
        needed = 2.6 * np.degrees(np.arccos(1 - 2 / number))
    turn = 2 * np.pi * (turn + turned)
    sideways = np.cos(tilt)[:, None] * (np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second)
    directions = sideways + np.sin(tilt)[:, None] * up
    slope = math.tan(math.radians(view_angle) / 2)
    corners = np.array(list(itertools.product(*zip(low, high)))) - middle
    found = []
    for index, direction in enumerate(directions):
        # At a pole another direction is up.
        upward = up if abs(direction @ up) < 0.99 else first
        if layout == "inside":
            # They stand across the middle, so that neighbors see a surface from two places.
            position, target = middle - 0.1 * radius * direction, middle + radius * direction
            angle = min(max(view_angle, needed), 110.0)
        else:
            # As close as the corners of the bounds allow, with a margin.
            right = np.cross(upward, direction) / np.linalg.norm(np.cross(upward, direction))
            across = np.abs(corners @ np.stack([right * size[1] / size[0], np.cross(direction, right)], axis=1)).max(axis=1)
            position, target = middle + direction * np.max(1.06 * across / slope + corners @ direction), middle
            angle = view_angle
        found.append(Viewpoint(f"{layout}{index + 1}", tuple(position), tuple(target), tuple(upward), angle))
    return found


def upright(up):
    """Three axes at right angles, the last one of them up."""
    up = np.array(up, dtype=np.float64) / np.linalg.norm(up)
    first = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    first /= np.linalg.norm(first)
    return first, np.cross(up, first), up


def spheres(centers, radii, colors, values=None):
    """A vtkActor of exact spheres, drawn ray by ray: rounder than glyphs, and for thousands of them much faster. `colors` are (n, 3), bytes
    or from 0 to 1; radii and colors may also be one for all. `values` are arrays of n numbers by name, which `record` takes. With PyVista:
    `plotter.add_actor(spheres(...), name="atoms")`."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkRenderingCore import vtkActor
    from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLSphereMapper

    centers, colors = np.asarray(centers, dtype=np.float64).reshape(-1, 3), np.asarray(colors)
    if colors.dtype != np.uint8:
        colors = np.uint8(np.clip(colors, 0, 1) * 255 + 0.5)
    radii, colors = np.broadcast_to(radii, len(centers)), np.broadcast_to(colors, centers.shape)
    values = {name: np.asarray(it) for name, it in (values or {}).items()}
    if len(centers):
        # The mapper's bounds are those of centers: two more spheres without size lie at the corners of what all fill.
        corners = [(centers - radii[:, None]).min(axis=0), (centers + radii[:, None]).max(axis=0)]
        centers, radii, colors = np.vstack([centers, corners]), np.append(radii, [0, 0]), np.vstack([colors, colors[:1], colors[:1]])
        values = {name: np.append(it, it[[0, 0]]) for name, it in values.items()}
    points, cells, data, mapper, actor = vtkPoints(), vtkCellArray(), vtkPolyData(), vtkOpenGLSphereMapper(), vtkActor()
    points.SetData(numpy_to_vtk(centers, deep=True))
    cells.SetData(1, numpy_to_vtk(np.arange(len(centers), dtype=np.int64), deep=True))
    data.SetPoints(points)
    data.SetVerts(cells)
    # The mapper reads radii of 32 bits only.
    for array, name in ((np.float32(radii), RADIUS), (colors, COLOR), *((it, name) for name, it in values.items())):
        made = numpy_to_vtk(np.ascontiguousarray(array), deep=True)
        made.SetName(name)
        data.GetPointData().AddArray(made)
    data.GetPointData().SetActiveScalars(COLOR)
    mapper.SetInputData(data)
    mapper.SetScaleArray(RADIUS)
    actor.SetMapper(mapper)
    return actor


def actors_of(renderer):
    """All actors of a renderer, those in assemblies too."""
    found = renderer.GetActors()
    return [found.GetItemAsObject(index) for index in range(found.GetNumberOfItems())]


def bounds_of(renderer):
    """What the visible things of a renderer fill, (xmin, xmax, ymin, ymax, zmin, zmax); (inf, -inf ...) if there are none."""
    low, high, volumes = np.full(3, np.inf), np.full(3, -np.inf), renderer.GetVolumes()
    things = actors_of(renderer) + [volumes.GetItemAsObject(index) for index in range(volumes.GetNumberOfItems())]
    for prop in things:
        around = prop.GetBounds() if prop.GetVisibility() and not turns_with_the_camera(prop) else None
        if around is not None and around[0] <= around[1]:
            low, high = np.minimum(low, around[0::2]), np.maximum(high, around[1::2])
    return tuple(np.stack([low, high], axis=1).ravel())


def has_normals(actor):
    """Whether VTK knows a normal wherever it draws an actor: points and lines have some only as spheres and tubes, or if they are given."""
    from vtkmodules.vtkCommonDataModel import vtkCellTypes

    look, mapper = actor.GetProperty(), actor.GetMapper()
    if mapper is None or any(part in mapper.GetClassName() for part in ("Sphere", "Stick", "Glyph")):
        return True
    for part in blocks_of(mapper.GetInputDataObject(0, 0)):
        if part.GetPointData().GetNormals() is not None and look.GetInterpolation() > 0:
            continue
        # The numbers are those of VTK's cells with one point, some points, one line, some lines.
        kinds = vtkCellTypes()
        part.GetCellTypes(kinds)
        as_points = look.GetRepresentation() == 0 or kinds.IsType(1) or kinds.IsType(2)
        as_lines = look.GetRepresentation() == 1 or kinds.IsType(3) or kinds.IsType(4)
        if as_points and not look.GetRenderPointsAsSpheres() or as_lines and not look.GetRenderLinesAsTubes():
            return False
    return True


def is_opaque_in_part(actor):
    """Whether nothing but the colors of its scalars makes an actor translucent: where these are opaque, as all but what is not a number
    with `nan_opacity=0`, it is a surface like any other."""
    mapper = actor.GetMapper()
    is_plain = actor.GetProperty().GetOpacity() >= 1 and actor.GetTexture() is None and not actor.GetForceTranslucent()
    return is_plain and mapper is not None and mapper.GetScalarVisibility()


def alpha_of(mapper, data):
    """How opaque a mapper's colors of scalars are, as bytes, of points or of cells; and whether of cells. None without scalars."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import reference
    from vtkmodules.vtkRenderingCore import vtkAbstractMapper

    of_cells, ways = reference(0), ("ScalarMode", "ArrayAccessMode", "ArrayId", "ArrayName")
    array = vtkAbstractMapper.GetScalars(data, *(getattr(mapper, f"Get{way}")() for way in ways), of_cells)
    if array is None or not array.GetNumberOfTuples():
        return None, False
    colors = mapper.GetLookupTable().MapScalars(array, mapper.GetColorMode(), mapper.GetArrayComponent())
    return vtk_to_numpy(colors)[:, -1], bool(of_cells.get())


def is_seen_or_not(actor):
    """Whether all of an actor that is opaque in part is either opaque or invisible."""
    mapper = actor.GetMapper()
    mapper.Update()
    alpha = [alpha_of(mapper, block)[0] for block in blocks_of(mapper.GetInputDataObject(0, 0))]
    return all(it is None or np.all((it == 0) | (it == 255)) for it in alpha)


def turns_with_the_camera(prop):
    return any(part in prop.GetClassName() for part in TURNS_WITH_THE_CAMERA)


def window_and_renderer(plotter):
    """The window and the renderer of a pyvista.Plotter, a vtkRenderWindow or a vtkRenderer, which gets a window if it has none."""
    try:
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (without it VTK draws nothing)
        from vtkmodules.vtkRenderingCore import vtkRenderWindow
    except ImportError as error:
        raise CaptureError(f"recording needs VTK: pip install pyvista ({first_line(error)})") from error

    if hasattr(plotter, "GetRenderers"):
        drawn = plotter.GetRenderers()
        drawn = [drawn.GetItemAsObject(index) for index in range(drawn.GetNumberOfItems())]
        drawn = [it for it in drawn if it.GetLayer() == 0] if len(drawn) > 1 else drawn
        if len(drawn) != 1:
            raise CaptureError(f"the window has {len(drawn)} renderers; give the renderer that is to be recorded")
        window, renderer = plotter, drawn[0]
    elif hasattr(plotter, "GetRenderWindow"):
        window, renderer = plotter.GetRenderWindow(), plotter
        if window is None:
            window = vtkRenderWindow()
            window.SetOffScreenRendering(True)
            window.AddRenderer(renderer)
    elif hasattr(plotter, "render_window"):
        if plotter.render_window is None:
            raise CaptureError("the plotter was closed; record before show(), or show(auto_close=False)")
        window, renderer = plotter.render_window, plotter.renderer
    else:
        raise CaptureError(f"{type(plotter).__name__} is neither a pyvista.Plotter nor a vtkRenderWindow nor a vtkRenderer")
    if not window.GetMapped():
        window.SetOffScreenRendering(True)
    return window, renderer


class Stage:
    """A window and one of its renderers, made ready for pictures, and put back afterwards."""

    def __init__(self, plotter, size, lights, antialias, up, tell):
        self.window, self.renderer = window_and_renderer(plotter)
        self.keep_alive = plotter
        self.size = tuple(int(side) for side in (size or self.window.GetSize()))
        if len(self.size) != 2 or min(self.size) < 1:
            raise CaptureError(f"the size {size} is not one of columns and rows")
        if lights not in ("fixed", "as_set"):
            raise CaptureError(f"lights '{lights}' are neither fixed nor as_set")
        if np.shape(up) != (3,) or not np.linalg.norm(up) > 0:
            raise CaptureError(f"the up direction {up} is none")
        self.lights, self.up, self.tell = lights, up, tell
        self.samples = self.window.GetMultiSamples() if antialias is None else int(antialias)
        self.is_antialiased = self.samples > 1 or bool(self.renderer.GetUseFXAA()) or self.renderer.GetPass() is not None

    def changed(self, stack, owner, name, *values):
        """Calls `Set` of a property, and sets it back when `stack` is left."""
        before = getattr(owner, f"Get{name}")()
        stack.callback(getattr(owner, f"Set{name}"), *(before if isinstance(before, (tuple, list)) else (before,)))
        getattr(owner, f"Set{name}")(*values)

    @contextlib.contextmanager
    def ready(self):
        """The renderer fills the window alone, with things that stand in the scene alone."""
        with contextlib.ExitStack() as stack:
            window, renderer = self.window, self.renderer
            self.changed(stack, window, "Size", *self.size)
            others = window.GetRenderers()
            for index in range(others.GetNumberOfItems()):
                other = others.GetItemAsObject(index)
                if other is not renderer:
                    self.changed(stack, other, "Draw", False)
            self.changed(stack, renderer, "Viewport", 0.0, 0.0, 1.0, 1.0)
            self.changed(stack, renderer, "Layer", 0)
            self.changed(stack, window, "MultiSamples", self.samples)
            for name in ("GradientBackground", "TexturedBackground"):
                if getattr(renderer, f"Get{name}")():
                    self.tell("the background is a picture or a gradient that moves with the camera: one color takes its place")
                    self.changed(stack, renderer, name, False)
            props = renderer.GetViewProps()
            for index in range(props.GetNumberOfItems()):
                prop = props.GetItemAsObject(index)
                if prop.GetVisibility() and (not prop.IsA("vtkProp3D") or turns_with_the_camera(prop)):
                    self.tell(f"left out, as it lies on the picture or turns with the camera: {prop.GetClassName()}")
                    self.changed(stack, prop, "Visibility", False)
            self.light(stack)
            camera = renderer.GetActiveCamera()
            stack.callback(renderer.SetActiveCamera, camera)
            yield

    def light(self, stack):
        """Lights that stand in the scene, in place of those that follow the camera."""
        if self.lights == "as_set":
            return
        from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer

        renderer, found = self.renderer, self.renderer.GetLights()
        found = [found.GetItemAsObject(index) for index in range(found.GetNumberOfItems())]
        following = [it for it in found if it.GetSwitch() and not it.LightTypeIsSceneLight()]
        if found and not following:
            return
        self.tell("lights follow the camera: while recording, others that stand in the scene take their place")
        for light in following:
            self.changed(stack, light, "Switch", False)
        self.changed(stack, renderer, "AutomaticLightCreation", False)
        basis = np.stack(upright(self.up))
        # Each has one across from it, so that a sheet without thickness has one color, from whichever side it is seen.
        for direction, intensity in LIGHTS:
            for side in (1, -1):
                light = vtkLight()
                light.SetLightTypeToSceneLight()
                light.PositionalOff()
                light.SetPosition(*(side * np.array(direction) @ basis))
                light.SetFocalPoint(0, 0, 0)
                light.SetIntensity(intensity)
                vtkRenderer.AddLight(renderer, light)
                stack.callback(vtkRenderer.RemoveLight, renderer, light)

    @contextlib.contextmanager
    def geometry(self, with_normals):
        """Only what has depth is drawn, without any filter, and in the colors of its normals."""
        with contextlib.ExitStack() as stack:
            renderer = self.renderer
            self.changed(stack, self.window, "MultiSamples", 0)
            for name, value in (("UseFXAA", False), ("UseSSAO", False), ("UseDepthPeeling", False), ("Pass", None)):
                if hasattr(renderer, f"Set{name}"):
                    self.changed(stack, renderer, name, value)
            hidden = [it for it in actors_of(renderer) if it.IsA("vtkSkybox")]
            volumes = renderer.GetVolumes()
            clear = [it for it in actors_of(renderer) if it.GetVisibility() and it.HasTranslucentPolygonalGeometry()]
            partly = [it for it in clear if is_opaque_in_part(it)]
            clear = [it for it in clear if it not in partly]
            for actor in partly:
                self.changed(stack, actor, "ForceOpaque", True)
            clear += [volumes.GetItemAsObject(index) for index in range(volumes.GetNumberOfItems())]
            if clear:
                self.tell("volumes and what is translucent have no depth of their own: their color counts as that of what is behind them")
            for prop in hidden + clear:
                self.changed(stack, prop, "Visibility", False)
            for actor in actors_of(renderer) if with_normals else partly:
                code = OPAQUE_ALONE if actor in partly else ""
                if with_normals:
                    # A surface without lighting would have no normal in its shader.
                    self.changed(stack, actor.GetProperty(), "Lighting", True)
                    drawn = NORMAL_AS_COLOR if has_normals(actor) else BLACK
                    code = code + drawn.split("\n", 1)[1] if code else drawn
                self.shaded(stack, actor, code)
            yield

    @contextlib.contextmanager
    def numbered(self, parts):
        """In place of the scene, draws what its `parts` have numbers, each in the color of its own, before black."""
        from vtkmodules.vtkRenderingCore import vtkRenderer

        with self.geometry(False), contextlib.ExitStack() as stack:
            self.changed(stack, self.renderer, "Background", 0.0, 0.0, 0.0)
            props = self.renderer.GetViewProps()
            for prop in [props.GetItemAsObject(index) for index in range(props.GetNumberOfItems())]:
                self.changed(stack, prop, "Visibility", False)
            for part in parts:
                actor = part.actor(self, stack)
                vtkRenderer.AddActor(self.renderer, actor)
                stack.callback(vtkRenderer.RemoveActor, self.renderer, actor)
            yield

    def values(self, view, depth, parts, names):
        """The values of these names at each pixel, (height, width) each; NaN where nothing is, and where it has no value."""
        self.look(view)
        high, middle, low = np.moveaxis(self.bytes_of_picture().astype(np.int64), -1, 0)
        number, lens = (high << 16 | middle << 8 | low).ravel(), view.lens(self.size)
        number[depth.ravel() >= MISS] = 0
        x, y = np.meshgrid((np.arange(self.size[0]) + 0.5 - lens["cx"]) / lens["fl_x"], (lens["cy"] - np.arange(self.size[1]) - 0.5) / lens["fl_y"])
        place = (np.stack([x, y, -np.ones_like(x)], -1) * np.float64(depth)[..., None]).reshape(-1, 3)
        found = {name: np.full(len(number), np.nan, np.float32) for name in names}
        for part in parts:
            seen = np.flatnonzero((number >= part.first) & (number < part.first + part.count))
            if len(seen):
                in_world = place[seen] @ view.pose()[:3, :3].T + view.pose()[:3, 3]
                for name, values in part.values_at(number[seen] - part.first, in_world, names).items():
                    found[name][seen] = values
        return {name: values.reshape(depth.shape) for name, values in found.items()}

    def look(self, view):
        """Renders from a viewpoint; planes of depth lie close around the scene."""
        from vtkmodules.vtkRenderingCore import vtkCamera

        camera = vtkCamera()
        camera.SetPosition(*view.position)
        camera.SetFocalPoint(*view.focal_point)
        camera.SetViewUp(*view.up)
        camera.SetViewAngle(view.view_angle)
        if view.parallel_scale is not None:
            camera.ParallelProjectionOn()
            camera.SetParallelScale(view.parallel_scale)
        self.renderer.SetActiveCamera(camera)
        around = bounds_of(self.renderer)
        if around[0] <= around[1]:
            self.renderer.ResetCameraClippingRange(around)
        self.window.Render()
        if tuple(self.window.GetSize()) != self.size:
            raise CaptureError(f"the window cannot be {self.size[0]}x{self.size[1]}: use Plotter(off_screen=True)")
        return camera.GetClippingRange()

    def bytes_of_picture(self):
        """What is in the window, (height, width, 3), from the top."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        width, height = self.size
        array = vtkUnsignedCharArray()
        self.window.GetPixelData(0, 0, width - 1, height - 1, 0, array, 0)
        return vtk_to_numpy(array).reshape(height, width, 3)[::-1].copy()

    def color(self, view):
        with contextlib.ExitStack() as stack:
            for actor in actors_of(self.renderer):
                # VTK would draw the far side of what is opaque or invisible over the near one.
                is_clear = actor.GetVisibility() and actor.HasTranslucentPolygonalGeometry()
                if is_clear and is_opaque_in_part(actor) and is_seen_or_not(actor):
                    self.changed(stack, actor, "ForceOpaque", True)
                    self.shaded(stack, actor, OPAQUE_ALONE)
            self.look(view)
            return LINEAR[self.bytes_of_picture()]

    def shaded(self, stack, actor, code):
        """Puts `code` where VTK would write what is picked, until `stack` is left."""
        shader = actor.GetShaderProperty()
        shader.AddFragmentShaderReplacement("//VTK::Picking::Impl", True, code, False)
        stack.callback(shader.ClearFragmentShaderReplacement, "//VTK::Picking::Impl", True)

    def depth(self, view):
        """Planar z of every pixel's center, 1e10 where nothing is."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkFloatArray

        near, far = self.look(view)
        if view.parallel_scale is not None and near <= 0:
            raise CaptureError(f"camera '{view.name}' stands within the scene; move it back, where parallel lines of sight show the same")
        array, (width, height) = vtkFloatArray(), self.size
        self.window.GetZbufferData(0, 0, width - 1, height - 1, array)
        level = vtk_to_numpy(array).astype(np.float64).reshape(height, width)[::-1]
        # Levels of a parallel projection are even in depth.
        depth = near * far / (far - level * (far - near)) if view.parallel_scale is None else near + level * (far - near)
        return np.where(level < 1.0, depth, MISS).astype(np.float32)

    def normal(self, view, depth):
        """World-space unit vectors toward the camera, zero where nothing is, of the picture that `depth` has just drawn."""
        return normals_of(self.bytes_of_picture(), view, self.size, depth < MISS)


def normals_of(picture, view, size, is_hit):
    """Takes apart what NORMAL_AS_COLOR and BLACK wrote."""
    high, mixed, low = np.moveaxis(picture.astype(np.int32), -1, 0)
    place = np.stack([high * 16 + mixed // 16, mixed % 16 * 256 + low], -1) / 4095 * 2 - 1
    unit = np.concatenate([place, 1 - np.abs(place).sum(-1, keepdims=True)], -1)
    fold = np.maximum(-unit[..., 2:], 0)
    unit[..., :2] -= np.where(place >= 0, fold, -fold)
    lens = view.lens(size)
    x, y = np.meshgrid((np.arange(size[0]) + 0.5 - lens["cx"]) / lens["fl_x"], (lens["cy"] - np.arange(size[1]) - 0.5) / lens["fl_y"])
    if view.parallel_scale is not None:
        x, y = 0 * x, 0 * y
    unit[unit[..., 0] * x + unit[..., 1] * y - unit[..., 2] > 0] *= -1
    length = np.linalg.norm(unit, axis=-1, keepdims=True)
    is_known = is_hit & picture.any(axis=-1)
    unit = np.where(is_known[..., None] & (length > 0), unit / np.maximum(length, 1e-9), 0)
    return (unit @ view.pose()[:3, :3].T).astype(np.float32)


class Part:
    """What an actor draws, cut into triangles, lines and points, or its spheres and glyphs. Each of them has a number, drawn as a color of
    its own: so the picture says where a pixel's value comes from, behind what it is hidden, and nothing is blended."""

    def __init__(self, prop, matrix, data, first):
        self.prop, self.mapper, self.first, self.matrix = prop, prop.GetMapper(), first, matrix
        self.is_of_points = is_drawn_as_points(self.mapper)
        if self.is_of_points:
            self.data, self.count = data, data.GetNumberOfPoints()
        else:
            self.data = triangles_of(data, prop.GetProperty().GetRepresentation() == 1)
            # A point and a line have corners more than once.
            self.corners = np.concatenate([it[:, np.arange(3) % it.shape[1]] for it in cells_of(self.data)])
            self.count = len(self.corners)
            self.is_hidden = self.hidden_pieces()

    def hidden_pieces(self):
        """Whether each piece has a corner that is not opaque, of an actor that is opaque in part."""
        is_clear, of_cells = alpha_of(self.mapper, self.data)
        if is_clear is None or not self.prop.HasTranslucentPolygonalGeometry():
            return np.zeros(self.count, bool)
        is_clear = is_clear < 255
        return is_clear[: self.count] if of_cells else is_clear[self.corners].any(axis=1)

    def arrays(self):
        """Its arrays by name: whether each is of points, and the array."""
        of_cells, of_points, found = self.data.GetCellData(), self.data.GetPointData(), {}
        for data in [of_points] if self.is_of_points else [of_cells, of_points]:
            arrays = [data.GetArray(index) for index in range(data.GetNumberOfArrays())]
            found.update({it.GetName(): (data is of_points, it) for it in arrays if it is not None and it.GetName()})
        return found

    def actor(self, stage, stack):
        """What draws the numbers."""
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

        number, mapper, actor = np.arange(self.first, self.first + self.count), self.mapper, vtkActor()
        if self.is_of_points:
            # What the mapper knows of radii and directions stays.
            before = mapper.GetInputConnection(0, 0)
            producer, port = before.GetProducer(), before.GetIndex()
            stack.callback(lambda: mapper.SetInputConnection(producer.GetOutputPort(port)))
            drawn = self.data.NewInstance()
            drawn.ShallowCopy(self.data)
        else:
            drawn, number = apart(self.data, number, self.is_hidden)
            mapper = vtkPolyDataMapper()
            if self.mapper.GetClippingPlanes() is not None:
                mapper.SetClippingPlanes(self.mapper.GetClippingPlanes())
        colors = numpy_to_vtk(np.stack([number >> 16, number >> 8 & 255, number & 255], -1).astype(np.uint8), deep=True)
        colors.SetName("number as color")
        drawn.GetPointData().SetScalars(colors)
        mapper.SetInputData(drawn)
        # Colors of points are 1 of VTK's modes, and bytes as they are 2 of its modes of color.
        for name, value in (("ScalarVisibility", True), ("ScalarMode", 1), ("ColorMode", 2)):
            stage.changed(stack, mapper, name, value)
        actor.SetMapper(mapper)
        actor.SetUserMatrix(self.matrix)
        # Points, lines and what is wide are drawn as before; no light, texture or edge changes a color.
        look = actor.GetProperty()
        look.DeepCopy(self.prop.GetProperty())
        look.RemoveAllTextures()
        settings = {"Lighting": False, "Ambient": 1, "Diffuse": 0, "Interpolation": 0, "EdgeVisibility": False, "VertexVisibility": False, "Opacity": 1}
        for name, value in settings.items():
            getattr(look, f"Set{name}")(value)
        return actor

    def values_at(self, index, in_world, names):
        """Values by name where its pieces of these numbers are seen at places in the world: those of the piece or, interpolated linearly,
        of its corners. Names that it lacks are missing."""
        from vtkmodules.util.numpy_support import vtk_to_numpy

        asked = {name: it for name, it in self.arrays().items() if name in names and it[1].GetNumberOfComponents() == 1}
        found = {name: (is_of_points, vtk_to_numpy(array)) for name, (is_of_points, array) in asked.items()}
        if self.is_of_points or not any(is_of_points for is_of_points, _ in found.values()):
            return {name: array[index] for name, (_, array) in found.items()}
        corners = self.corners[index]
        world = np.array([[self.matrix.GetElement(y, x) for x in range(4)] for y in range(3)])
        places = vtk_to_numpy(self.data.GetPoints().GetData())[corners] @ world[:, :3].T + world[:, 3]
        share = shares(places, in_world)
        # A corner that has no share has no say, even where it is NaN.
        of_corners = lambda array: np.where(share > 0, share * array[corners].astype(np.float64), 0).sum(-1)
        return {name: of_corners(array) if is_of_points else array[index] for name, (is_of_points, array) in found.items()}


def shares(corners, places):
    """How much each of three corners, (n, 3, 3), counts at places near their triangle, (n, 3): from 0 to 1, and 1 in sum. Where two or all
    three corners are one, it is a line or a point."""
    first, second, away = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], places - corners[:, 0]
    dot = lambda a, b: np.sum(a * b, -1)
    a, b, c, p, q = dot(first, first), dot(first, second), dot(second, second), dot(first, away), dot(second, away)
    area, tiny = a * c - b * b, np.finfo(np.float64).tiny
    is_flat = area <= 1e-20 * a * c
    u = np.where(is_flat, p / np.maximum(a, tiny), (c * p - b * q) / np.where(is_flat, 1, area))
    v = np.where(is_flat, 0, (a * q - b * p) / np.where(is_flat, 1, area))
    found = np.clip(np.stack([1 - u - v, u, v], -1), 0, 1)
    return found / found.sum(-1, keepdims=True)


def cells_of(data):
    """The points of each cell of a vtkPolyData of points, lines and triangles, in its order: three arrays, (n, 1), (n, 2) and (n, 3)."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    cells = ((data.GetVerts(), 1), (data.GetLines(), 2), (data.GetPolys(), 3))
    return [vtk_to_numpy(it.GetConnectivityArray()).reshape(-1, many) for it, many in cells]


def apart(data, number, is_hidden):
    """The same points, lines and triangles, none of which shares a corner, and the number of the cell of each corner. Those that are
    hidden have no size."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    cells, made, points = cells_of(data), vtkPolyData(), vtkPoints()
    hidden = np.split(is_hidden, np.cumsum([len(it) for it in cells])[:-1])
    corners = np.concatenate([np.where(no_size[:, None], it[:, :1], it).ravel() for it, no_size in zip(cells, hidden)])
    points.SetData(numpy_to_vtk(vtk_to_numpy(data.GetPoints().GetData())[corners], deep=True))
    made.SetPoints(points)
    first = 0
    for it, put in zip(cells, (made.SetVerts, made.SetLines, made.SetPolys)):
        kept = vtkCellArray()
        kept.SetData(it.shape[1], numpy_to_vtk(np.arange(first, first + it.size, dtype=np.int64), deep=True))
        put(kept)
        first += it.size
    return made, np.repeat(number, np.concatenate([np.full(len(it), it.shape[1]) for it in cells]))


def is_drawn_as_points(mapper):
    """Whether points alone are the data of a mapper: of spheres, sticks, glyphs."""
    return any(part in mapper.GetClassName() for part in ("Sphere", "Stick", "Glyph", "Gaussian"))


def triangles_of(data, is_wireframe):
    """The surface of a dataset as a vtkPolyData of points, lines and triangles, with its arrays; of a wireframe the lines alone."""
    from vtkmodules.vtkFiltersCore import vtkExtractEdges, vtkTriangleFilter
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

    surface, pieces = vtkGeometryFilter(), vtkExtractEdges() if is_wireframe else vtkTriangleFilter()
    surface.SetInputData(data)
    pieces.SetInputConnection(surface.GetOutputPort())
    pieces.Update()
    return pieces.GetOutput()


def blocks_of(data):
    """The datasets of a composite one, or the only one."""
    if data is None or not data.IsA("vtkCompositeDataSet"):
        return [] if data is None else [data]
    walk, found = data.NewIterator(), []
    while not walk.IsDoneWithTraversal():
        found.append(walk.GetCurrentDataObject())
        walk.GoToNextItem()
    return found


def parts_of(renderer):
    """All that the renderer draws and that has depth, as a list of Part."""
    from vtkmodules.vtkCommonMath import vtkMatrix4x4

    parts, first, props = [], 1, renderer.GetViewProps()
    for prop in [props.GetItemAsObject(index) for index in range(props.GetNumberOfItems())]:
        if not prop.GetVisibility() or not prop.IsA("vtkProp3D") or turns_with_the_camera(prop):
            continue
        prop.InitPathTraversal()
        while (path := prop.GetNextPath()) is not None:
            actor, matrix = path.GetLastNode().GetViewProp(), vtkMatrix4x4()
            is_drawn = actor.IsA("vtkActor") and not actor.IsA("vtkSkybox") and actor.GetMapper() is not None and actor.GetVisibility()
            if not is_drawn or actor.HasTranslucentPolygonalGeometry() and not is_opaque_in_part(actor):
                continue
            if path.GetLastNode().GetMatrix() is not None:
                matrix.DeepCopy(path.GetLastNode().GetMatrix())
            actor.GetMapper().Update()
            for block in blocks_of(actor.GetMapper().GetInputDataObject(0, 0)):
                part = Part(actor, matrix, block, first)
                if part.is_of_points and any(it.mapper is part.mapper for it in parts):
                    raise CaptureError("spheres or glyphs of several blocks or actors share a mapper, which values cannot be recorded of")
                first += part.count
                parts += [part] if part.count else []
    if first > MOST_PARTS:
        raise CaptureError(f"the scene has {first} triangles, more than the {MOST_PARTS} whose values can be recorded")
    return parts


def checked_values(values):
    """What is asked for, as a list of {"name", "unit", "range"}: names, such objects, or an object of units by name."""
    values = [values] if isinstance(values, str) else values or ()
    asked = [{"name": name, "unit": unit} for name, unit in values.items()] if isinstance(values, dict) else list(values)
    asked = [dict(it) if isinstance(it, dict) else {"name": str(it)} for it in asked]
    if any(not it.get("name") or set(it) - {"name", "unit", "range", "tolerance", "exact"} for it in asked):
        raise CaptureError("each value needs a name, and may have a unit, a range, a tolerance and exact")
    if len(asked) > MOST_VALUES or len({it["name"] for it in asked}) != len(asked):
        raise CaptureError(f"{len(asked)} values are asked for: there may be up to {MOST_VALUES}, each once")
    return [{key: it for key, it in one.items() if it is not None} for one in asked]


def planned_values(asked, stage):
    """The values as the manifest lists them: their ranges are those of what the first frame draws, if nobody gave one."""
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if not asked:
        return []
    with stage.ready():
        arrays = [part.arrays() for part in parts_of(stage.renderer)]
    planned = []
    for one in asked:
        name, found = one["name"], [it[one["name"]][1] for it in arrays if one["name"] in it]
        if not found:
            single = {name for it in arrays for name, (_, array) in it.items() if array.GetNumberOfComponents() == 1}
            raise CaptureError(f"there is no array '{name}' in what is drawn; there are: {', '.join(sorted(single)) or 'none'}")
        if any(it.GetNumberOfComponents() != 1 for it in found):
            raise CaptureError(f"array '{name}' has {found[0].GetNumberOfComponents()} components; give one of them, or its length, an array of its own")
        numbers = np.concatenate([vtk_to_numpy(it).astype(np.float64) for it in found])
        numbers = numbers[np.isfinite(numbers)]
        if "range" not in one and len(numbers) and numbers.min() < numbers.max():
            one = {**one, "range": [float(numbers.min()), float(numbers.max())]}
        if np.any(np.float32(numbers) != numbers) and all(it.GetDataTypeAsString() not in ("float", "double") for it in found):
            stage.tell(f"'{name}' has whole numbers that are too large for 32-bit floats: they are rounded")
        planned.append({**one, "channel": f"value.{name}"})
    return planned


LINEAR = np.float32([it / 12.92 if it <= 0.04045 else ((it + 0.055) / 1.055) ** 2.4 for it in np.arange(256) / 255])


def write_exr(path, channels):
    """OpenEXR of channels by name, (height, width) of float16 or float32, in zipped blocks of 16 rows. It is there whole, or not at all."""
    names = sorted(channels)
    height, width = channels[names[0]].shape
    kinds = b"".join(it.encode() + b"\0" + struct.pack("<iB3xii", 1 if channels[it].dtype == np.float16 else 2, 0, 1, 1) for it in names)
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = (
        ("channels", "chlist", kinds + b"\0"),
        ("compression", "compression", b"\x03"),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    )
    head = struct.pack("<2i", 20000630, 2)
    for name, kind, value in attributes:
        head += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    head += b"\0"
    little = [np.ascontiguousarray(channels[it]).astype(channels[it].dtype.newbyteorder("<")) for it in names]
    rows = np.concatenate([it.view(np.uint8).reshape(height, -1) for it in little], axis=1)
    blocks = []
    for first in range(0, height, 16):
        plain = rows[first : first + 16].ravel()
        # As the format wants it: every other byte first, then differences.
        halves = np.concatenate([plain[0::2], plain[1::2]]).astype(np.int16)
        halves[1:] = halves[1:] - halves[:-1] + 128
        packed = zlib.compress(halves.astype(np.uint8).tobytes(), 4)
        packed = packed if len(packed) < len(plain) else plain.tobytes()
        blocks.append(struct.pack("<2i", first, len(packed)) + packed)
    places = len(head) + 8 * len(blocks) + np.cumsum([0] + [len(it) for it in blocks[:-1]])
    replace(path, head + places.astype("<u8").tobytes() + b"".join(blocks))


def replace(path, content):
    """Writes a file under another name first, so that it is never there in part."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path + ".part", "wb") as file:
        file.write(content)
    os.replace(path + ".part", path)


def record(
    plotter,
    out,
    cameras=6,
    frames=1,
    size=None,
    step=None,
    *,
    truth=None,
    times=None,
    up=(0, 0, 1),
    view_angle=30.0,
    bounds=None,
    lights="fixed",
    antialias=None,
    normals=True,
    values=None,
    step_jumps=False,
    overwrite=False,
):
    """Records `plotter` (a pyvista.Plotter, vtkRenderWindow or vtkRenderer) into the folder `out`; raises CaptureError with what is wrong.

    `cameras` and `truth` are as in `viewpoints`; those that are placed stand around `bounds`, or else around what the first frame shows.
    `frames` is a number of frames, or their numbers; `times` are their times. `step(frame)` is called before each, also before those that
    are there already, unless `step_jumps` says that it needs no earlier one. `size` is columns and rows, `antialias` the samples per pixel
    of color (both the window's). `values` are up to four arrays of points or cells whose numbers are recorded beside the colors: their
    names, units by names as in {"pressure": "Pa"}, or objects of what the manifest says of each ("name", "unit", "range", "tolerance",
    "exact"). What is drawn without such an array has no value. `overwrite` records anew what is there."""
    frames = list(range(frames)) if isinstance(frames, int) else [int(it) for it in frames]
    times = [None] * len(frames) if times is None else [float(it) for it in times]
    if not frames or len(times) != len(frames) or len(set(frames)) != len(frames):
        raise CaptureError(f"{len(frames)} frames and {len(times)} times: there must be a time for each frame, and no frame twice")
    out, progress = os.path.abspath(out), Progress()
    asked = checked_values(values)
    stage = Stage(plotter, size, lights, antialias, up, progress.note)
    if step is not None:
        step(frames[0])
    views = plan(cameras, truth, stage, bounds, view_angle)
    asked = planned_values(asked, stage)
    roots = [(root, found) for root, found in zip((out, os.path.join(out, "novel")), views) if found]
    jobs = [it for root, found in roots for it in begin(root, manifest(found, frames, times, stage, asked), found, overwrite)]
    jobs.sort(key=lambda job: frames.index(job[0]))
    progress.start(len(jobs), len(frames) * sum(len(found) for found in views))
    for index, frame in enumerate(frames):
        now = [it for it in jobs if it[0] == frame]
        if step is not None and index > 0 and (now or not step_jumps):
            step(frame)
        if now:
            normals = record_frame(stage, now, normals, asked, progress)
        if not jobs or frame == jobs[-1][0]:
            break
    for root, _ in roots:
        os.replace(os.path.join(root, "recording.json"), os.path.join(root, "transforms.json"))
    progress.end(out)


def plan(cameras, truth, stage, bounds, view_angle):
    """The recording cameras and the true views, whose names are the folders of their pictures."""
    bounds = bounds_of(stage.renderer) if bounds is None else bounds
    if len(bounds) != 6:
        raise CaptureError("bounds are six numbers: xmin, xmax, ymin, ymax, zmin, zmax")
    recorded = viewpoints(cameras, stage.size, bounds, stage.up, view_angle)
    # True views that are placed stand halfway between recording cameras.
    turned = 0.5 / len(recorded)
    true = [] if truth is None else viewpoints(truth, stage.size, bounds, stage.up, view_angle, turned)
    for found in (recorded, true):
        for view in found:
            view.name = re.sub(r"[^\w.-]+", "_", str(view.name)).strip("._") or "camera"
        if len({it.name.lower() for it in found}) != len(found):
            raise CaptureError("two cameras have the same name")
    return recorded, true


def manifest(views, frames, times, stage, values=()):
    """What transforms.json will say."""
    entries = []
    for frame, when in zip(frames, times):
        for view in views:
            entry = {"camera": view.name, "frame": frame, "file_path": f"{view.name}/{frame:04d}.exr"}
            entry.update({} if when is None else {"time": when})
            entries.append({**entry, "transform_matrix": view.pose().tolist(), **view.lens(stage.size)})
    return {
        "depth_kind": "planar_z",
        "depth_channel": "Z",
        "depth_miss_value": MISS,
        "normal_space": "world",
        "antialiased_color": stage.is_antialiased,
        "noise_free": True,
        "up": [float(it) for it in stage.up],
        **({"values": list(values)} if values else {}),
        "frames": entries,
    }


def begin(root, planned, views, overwrite):
    """Notes what is to be recorded, and returns the frames and viewpoints whose pictures are missing."""
    if not overwrite:
        for name in ("transforms.json", "recording.json"):
            with contextlib.suppress(FileNotFoundError), open(os.path.join(root, name), encoding="utf-8") as file:
                refuse_another(root, json.load(file), planned)
    replace(os.path.join(root, "recording.json"), json.dumps(planned, indent=1).encode())
    by_name = {it.name: it for it in views}
    missing = []
    for entry in planned["frames"]:
        if overwrite or not os.path.exists(os.path.join(root, entry["file_path"])):
            missing.append((entry["frame"], by_name[entry["camera"]], os.path.join(root, entry["file_path"])))
    return missing


def refuse_another(root, there, planned):
    """Pictures of other cameras or settings must not be mixed with these."""
    old = {it.get("file_path"): it for it in there.get("frames", [])}
    same = all(there.get(key) == value for key, value in planned.items() if key != "frames")
    if not same or any(old.get(it["file_path"], it) != it for it in planned["frames"]):
        raise CaptureError(f"{root} holds pictures of other cameras or settings: choose another folder, or overwrite them")


def record_frame(stage, jobs, normals, values, progress):
    """Records the pictures of one frame; returns whether normals could be drawn."""
    with stage.ready():
        colors = [stage.color(view) for _, view, _ in jobs]
        if normals and not can_draw_normals(stage, jobs[0][1]):
            if progress.done > 0:
                raise CaptureError(f"frame {jobs[0][0]} shows something that cannot be drawn with its normals: record without normals")
            progress.note("something in the scene cannot be drawn with its normals: they are left out")
            normals = False
        pictures = []
        with stage.geometry(normals):
            for (frame, view, _), color in zip(jobs, colors):
                depth = stage.depth(view)
                if np.all(depth == MISS):
                    progress.note(f"camera '{view.name}' shows nothing that has depth, at frame {frame}")
                pictures.append(dict(zip("RGB", np.moveaxis(color, -1, 0).astype(np.float16)), Z=depth))
                if normals:
                    pictures[-1].update(zip(("N.X", "N.Y", "N.Z"), np.moveaxis(stage.normal(view, depth), -1, 0).astype(np.float16)))
        if values:
            parts, names = parts_of(stage.renderer), [it["name"] for it in values]
            with stage.numbered(parts):
                for (_, view, _), channels in zip(jobs, pictures):
                    found = stage.values(view, channels["Z"], parts, names)
                    channels.update({f"value.{name}": it for name, it in found.items()})
        for (_, _, path), channels in zip(jobs, pictures):
            write_exr(path, channels)
            progress.picture()
    return normals


def can_draw_normals(stage, view):
    """Whether VTK draws normals without an error, and depth as without them: what it cannot draw in these colors would be missing."""
    from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow

    with stage.geometry(False):
        plain = stage.depth(view)
    before, said = vtkOutputWindow.GetInstance(), vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(said)
    try:
        with stage.geometry(True):
            drawn = stage.depth(view)
    finally:
        vtkOutputWindow.SetInstance(before)
    return "ERR" not in said.GetOutput().upper() and np.array_equal(plain, drawn)


class Progress:
    """Says on stderr how far it is."""

    def __init__(self):
        self.told, self.done, self.total, self.is_live = set(), 0, 0, sys.stderr.isatty()

    def note(self, text):
        if text not in self.told:
            self.told.add(text)
            print(f"note: {text}", file=sys.stderr)

    def start(self, missing, total):
        self.total, self.begun = missing, time.monotonic()
        if missing < total:
            print(f"{total - missing} of {total} pictures are there", file=sys.stderr)

    def picture(self):
        self.done += 1
        spent = time.monotonic() - self.begun
        if self.is_live or self.done in (1, self.total) or self.done * 10 // self.total > (self.done - 1) * 10 // self.total:
            left = spent / self.done * (self.total - self.done)
            end = "\r" if self.is_live and self.done < self.total else "\n"
            print(f"picture {self.done} of {self.total}, {left:.0f} s left   ", end=end, file=sys.stderr, flush=True)

    def end(self, out):
        print(f"recorded {out}", file=sys.stderr)


def scene_of_files(files, options):
    """A plotter of what PyVista reads, the times of its frames, and what steps it."""
    try:
        import pyvista
    except ImportError as error:
        raise CaptureError(f"reading files needs PyVista: pip install pyvista ({first_line(error)})") from error

    pyvista.OFF_SCREEN = True
    for path in files:
        if not os.path.exists(path):
            raise CaptureError(f"{path} does not exist")
    try:
        readers = [pyvista.get_reader(path) for path in files]
    except (ValueError, OSError) as error:
        raise CaptureError(f"PyVista does not read {files[0]}: {first_line(error)}") from error
    times = getattr(readers[0], "time_values", None) if len(files) == 1 else None
    moments = len(times) if times else len(files)

    def mesh(frame):
        reader = readers[0 if times else frame]
        if times:
            reader.set_active_time_point(frame)
        try:
            read = reader.read()
        except (RuntimeError, ValueError) as error:
            raise CaptureError(f"PyVista does not read {reader.path}: {first_line(error)}") from error
        read = read.combine() if isinstance(read, pyvista.MultiBlock) else read
        if not read.n_points:
            raise CaptureError(f"{reader.path} holds no points")
        return read

    chosen = chosen_frames(options.frames, moments)
    plotter = pyvista.Plotter(off_screen=True, window_size=options.size)
    plotter.set_background(options.background)
    colored = {"color": options.color}
    if options.color_by:
        ends = [mesh(frame) for frame in (chosen[0], chosen[-1])]
        for it in ends:
            names = it.point_data.keys() if options.point_radius else it.array_names
            if options.color_by not in names:
                raise CaptureError(f"there is no array '{options.color_by}'; there are: {', '.join(names) or 'none'}")
        ranges = np.array([it.get_data_range(options.color_by) for it in ends])
        limits = options.range or (float(ranges[:, 0].min()), float(ranges[:, 1].max()))
        table = pyvista.LookupTable(cmap=options.colormap, n_values=256).values[:, :3]
        colored = {"scalars": options.color_by, "cmap": options.colormap, "clim": limits, "show_scalar_bar": False}

    def step(frame):
        now = mesh(frame)
        if options.point_radius:
            colors = pyvista.Color(options.color).float_rgb
            if options.color_by:
                share = (now.point_data[options.color_by] - limits[0]) / max(limits[1] - limits[0], 1e-30)
                colors = table[np.uint8(np.clip(share * 256, 0, 255))]
            values = {name: it for name, it in now.point_data.items() if it.ndim == 1} if options.values else {}
            plotter.add_actor(spheres(now.points, options.point_radius, colors, values), name="scene", reset_camera=False, render=False)
        else:
            plotter.add_mesh(now, name="scene", reset_camera=False, render=False, **colored)

    return plotter, chosen, [times[it] for it in chosen] if times else None, step


def numbers(count, text):
    """Numbers with a comma or an x between them."""
    found = [float(it) for it in re.split("[x,]", text)]
    if len(found) != count:
        raise ValueError
    return found


def add_options(parser):
    """The options of recording, which scripts for other sources share."""
    size = lambda text: tuple(int(it) for it in numbers(2, text))
    add = parser.add_argument
    add("--out", required=True, metavar="FOLDER", help="folder of the capture")
    add("--cameras", default="6", help="N or ring:N, sphere:N, inside:N, or a JSON file: a manifest of poses, as `overlook place` writes it, or as below [ring:6]")
    add("--truth", metavar="CAMERAS", help="true views, in the same words: they go to FOLDER/novel")
    add("--size", type=size, default=(640, 480), metavar="WxH", help="columns and rows [640x480]")
    add("--view-angle", type=float, default=30.0, metavar="DEGREES", help="from top to bottom [30]")
    add("--up", type=lambda text: numbers(3, text), default=[0.0, 0.0, 1.0], metavar="X,Y,Z", help="up direction [0,0,1]")
    add("--bounds", type=lambda text: numbers(6, text), metavar="XMIN,XMAX,...", help="what cameras are placed around [the first frame]")
    add("--frames", default="::", metavar="FIRST:END:STEP", help="which time steps, as Python counts them [all]")
    add("--background", default="white", help="its color [white]")
    add("--lights", choices=("fixed", "as_set"), default="fixed", help="lights that stand in the scene, or those of the renderer [fixed]")
    add("--antialias", type=int, metavar="N", help="samples per pixel of color, 0 for none [the renderer's]")
    add("--no-normals", action="store_true", help="leave normals out")
    units = lambda text: {name: unit or None for name, _, unit in (it.partition("=") for it in text.split(","))}
    add("--values", type=units, metavar="NAME[=UNIT],...", help="arrays whose numbers are recorded beside the colors, up to four")
    add("--overwrite", action="store_true", help="record anew what is there")
    parser.epilog = """Cameras in a file: [{"name": "left", "position": [0, -5, 1], "focal_point": [0, 0, 0], "up": [0, 0, 1],
        "view_angle": 30}, ...]. Then: `overlook info FOLDER`, `overlook preprocess FOLDER --out F.ovl`."""


def chosen_frames(text, count):
    """The numbers of frames that --frames leaves of `count`."""
    found = list(range(count))[slice(*(int(it) if it else None for it in text.split(":")))]
    if not found:
        raise CaptureError(f"--frames {text} leaves none of {count}")
    return found


def record_by_options(options, plotter, frames, times, step):
    """What the command line asks for. Files know every time step: none has to be read for another."""
    def cameras(text):
        if text is None or not text.endswith(".json"):
            return text
        with open(text, encoding="utf-8") as file:
            try:
                return json.load(file)
            except ValueError as error:
                raise CaptureError(f"{text} is not JSON: {error}") from error

    record(
        plotter,
        options.out,
        cameras(options.cameras),
        frames,
        options.size,
        step,
        truth=cameras(options.truth),
        times=times,
        up=options.up,
        view_angle=options.view_angle,
        bounds=options.bounds,
        lights=options.lights,
        antialias=options.antialias,
        normals=not options.no_normals,
        values=options.values,
        step_jumps=True,
        overwrite=options.overwrite,
    )


def main():
    parser = argparse.ArgumentParser(description="Record what PyVista reads as a capture that Overlook opens.")
    parser.add_argument("scene", nargs="+", help="a .pvd series, or .vtu, .vtp, .vti, .ply ...; several are time steps")
    add_options(parser)
    parser.add_argument("--color-by", metavar="ARRAY", help="array whose values become colors")
    parser.add_argument("--range", nargs=2, type=float, metavar=("LOW", "HIGH"), help="range of the colors [of the first and last frame]")
    parser.add_argument("--colormap", default="viridis", help="[viridis]")
    parser.add_argument("--color", default="lightgray", help="color without --color-by [lightgray]")
    parser.add_argument("--point-radius", type=float, metavar="R", help="draw the points as spheres")
    options = parser.parse_args()
    run(lambda: record_by_options(options, *scene_of_files(options.scene, options)))


def first_line(error):
    return next((line.strip() for line in str(error).splitlines() if line.strip()), type(error).__name__)


def run(work):
    """Ends the program with one line on what is wrong."""
    try:
        work()
    except KeyboardInterrupt:
        sys.exit("stopped; the same command goes on from here")
    except (ValueError, OSError, ImportError) as error:
        sys.exit(f"error: {first_line(error)}")


if __name__ == "__main__":
    main()
