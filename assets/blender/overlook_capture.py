# SPDX-License-Identifier: MIT OR Apache-2.0
"""Blender add-on: renders cameras over the frame range as a capture that Overlook opens.

Install it under Edit > Preferences > Add-ons > Install from Disk. The panel is in the properties of the output, "Overlook Capture".
Cameras are marked there: as recording cameras, or as true views, which Overlook measures its accuracy against. Written are

    FOLDER/transforms.json, FOLDER/CAMERA/0001.exr ...       color, planar depth and world-space normals of recording cameras
    FOLDER/novel/transforms.json, FOLDER/novel/CAMERA/...    the same of true views

Depth is planar z in Blender's units, taken at each pixel's center; color is linear and filtered. "Add Cameras of a Manifest" makes recording
cameras of the poses that `overlook place` writes. From a script:

    import overlook_capture
    cameras = overlook_capture.add_cameras(scene, json.load(open("placed.json")))
    overlook_capture.render_capture(scene, folder, cameras, truth=others)
"""

import json
import os
import re

import bpy
from mathutils import Matrix

bl_info = {
    "name": "Overlook Capture",
    "author": "The Overlook authors",
    "version": (1, 0, 0),
    "blender": (4, 5, 0),
    "location": "Properties > Output > Overlook Capture",
    "description": "Render cameras with color, depth and normals as a capture that Overlook opens",
    "category": "Render",
}

ROLES = (
    ("NONE", "Not used", "This camera is not rendered"),
    ("RECORD", "Recording camera", "Its pictures are the capture"),
    ("TRUTH", "True view", "Its pictures are what Overlook's are compared with"),
)


class CaptureError(Exception):
    """What keeps a capture from being rendered, in one line."""


class Changed:
    """Sets attributes of Blender's data, and restores them at the end, last first."""

    def __init__(self):
        self.before = []

    def set(self, owner, name, value):
        """Sets an attribute; one that this version of Blender does not have is passed over."""
        if hasattr(owner, name) and getattr(owner, name) != value:
            self.before.append((owner, name, getattr(owner, name)))
            setattr(owner, name, value)

    def restore(self):
        for owner, name, value in reversed(self.before):
            setattr(owner, name, value)
        self.before.clear()


def camera_files(cameras):
    """A folder's name for each camera, of letters that every file system takes; no two are alike."""
    names = {}
    for camera in cameras:
        base = re.sub(r"[^\w.-]+", "_", camera.name).strip("._") or "camera"
        name, number = base, 1
        while name.lower() in (other.lower() for other in names.values()):
            number += 1
            name = f"{base}_{number}"
        names[camera] = name
    return names


def lens(scene, camera):
    """The camera's lens in pixels of the rendered picture, whatever its sensor fit, shift and pixel aspect."""
    render = scene.render
    width = int(render.resolution_x * render.resolution_percentage / 100)
    height = int(render.resolution_y * render.resolution_percentage / 100)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    matrix = camera.evaluated_get(depsgraph).calc_matrix_camera(
        depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y
    )
    return {
        "w": width,
        "h": height,
        "fl_x": 0.5 * width * matrix[0][0],
        "fl_y": 0.5 * height * matrix[1][1],
        "cx": 0.5 * width * (1 - matrix[0][2]),
        "cy": 0.5 * height * (1 + matrix[1][2]),
    }


def pose(camera):
    """Camera to world without the object's scale: x right, y up, looking along -z."""
    location, rotation, _ = camera.matrix_world.decompose()
    return Matrix.Translation(location) @ rotation.to_matrix().to_4x4()


def check(scene, cameras, frames):
    """Refuses what a capture cannot hold: other than perspective cameras, and cameras that move or zoom."""
    if not cameras:
        raise CaptureError("no camera is marked as a recording camera")
    for camera in cameras:
        if camera.data.type != "PERSP":
            raise CaptureError(f"camera '{camera.name}' is not perspective")
    current, seen = scene.frame_current, {}
    try:
        for frame in frames:
            scene.frame_set(frame)
            for camera in cameras:
                numbers = [value for row in pose(camera) for value in row] + list(lens(scene, camera).values())
                first = seen.setdefault(camera, numbers)
                if any(abs(a - b) > 1e-5 * max(1.0, abs(a)) for a, b in zip(first, numbers)):
                    raise CaptureError(f"camera '{camera.name}' moves or zooms at frame {frame}; cameras have to stand still")
    finally:
        scene.frame_set(current)


def prepare(scene, layer, changed):
    """Sets up the passes of the view layer and the files, and switches off what would change the picture after rendering."""
    for name in ("use_pass_combined", "use_pass_z", "use_pass_normal"):
        changed.set(layer, name, True)
    for other in scene.view_layers:
        changed.set(other, "use", other == layer)
    render = scene.render
    for name in ("use_compositing", "use_sequencer", "use_motion_blur", "use_border", "use_multiview", "use_overwrite"):
        changed.set(render, name, name == "use_overwrite")
    changed.set(render, "use_file_extension", True)
    settings = render.image_settings
    # Blender 5 asks for the kind of media before its format.
    changed.set(settings, "media_type", "MULTI_LAYER_IMAGE")
    changed.set(settings, "file_format", "OPEN_EXR_MULTILAYER")
    changed.set(settings, "color_depth", "32")
    changed.set(settings, "exr_codec", "ZIP")


def rendering(scene, folder, cameras, truth=(), frames=None):
    """Renders picture by picture, and yields the share that is done before each. The manifests are written at the end."""
    frames = list(range(scene.frame_start, scene.frame_end + 1, scene.frame_step)) if frames is None else list(frames)
    cameras, truth = list(cameras), list(truth)
    check(scene, cameras, frames)
    check(scene, truth or cameras, frames)
    folder = bpy.path.abspath(folder)
    layer = bpy.context.view_layer if bpy.context.scene == scene else scene.view_layers[0]
    changed, current = Changed(), scene.frame_current
    jobs = [(folder, camera) for camera in cameras] + [(os.path.join(folder, "novel"), camera) for camera in truth]
    names = {**camera_files(cameras), **camera_files(truth)}
    entries = {}
    try:
        prepare(scene, layer, changed)
        changed.set(scene, "camera", scene.camera)
        before = (scene.camera, scene.render.filepath)
        done = 0
        for frame in frames:
            scene.frame_set(frame)
            for root, camera in jobs:
                yield done / (len(frames) * len(jobs))
                path = os.path.join(names[camera], f"{frame:04d}.exr")
                depth_of_field = camera.data.dof.use_dof
                camera.data.dof.use_dof = False
                scene.camera, scene.render.filepath = camera, os.path.join(root, path)
                try:
                    bpy.ops.render.render(write_still=True, scene=scene.name, layer=layer.name)
                finally:
                    camera.data.dof.use_dof = depth_of_field
                    scene.camera, scene.render.filepath = before
                entries.setdefault(root, []).append(
                    {
                        "camera": camera.name,
                        "frame": frame,
                        "file_path": path.replace(os.sep, "/"),
                        "transform_matrix": [list(row) for row in pose(camera)],
                        **lens(scene, camera),
                    }
                )
                done += 1
    finally:
        changed.restore()
        scene.frame_set(current)
    for root, pictures in entries.items():
        manifest = {
            "depth_kind": "planar_z",
            "depth_miss_value": 1e10,
            "normal_space": "world",
            "antialiased_color": True,
            "up": [0, 0, 1],
            "frames": pictures,
        }
        with open(os.path.join(root, "transforms.json"), "w", encoding="utf-8") as file:
            json.dump(manifest, file, indent=1)


def render_capture(scene, folder, cameras, truth=(), frames=None):
    """Renders all of it; raises CaptureError with what is wrong."""
    for _ in rendering(scene, folder, cameras, truth, frames):
        pass


def add_cameras(scene, manifest):
    """Makes cameras of a manifest of poses, each once, marks them as recording cameras, and sets the size of the scene's pictures."""
    made = {}
    for entry in manifest["frames"]:
        name = entry["camera"]
        if name in made:
            continue
        width, height = int(entry["w"]), int(entry["h"])
        if abs(entry["cx"] / width - 0.5) > 1e-3 or abs(entry["cy"] / height - 0.5) > 1e-3 or abs(entry["fl_x"] / entry["fl_y"] - 1) > 1e-3:
            raise CaptureError(f"camera '{name}' has a shifted lens, or pixels that are not square")
        data = bpy.data.cameras.new(name)
        data.sensor_fit = "HORIZONTAL"
        data.lens = entry["fl_x"] / width * data.sensor_width
        made[name] = bpy.data.objects.new(name, data)
        made[name].matrix_world = Matrix(entry["transform_matrix"])
        scene.collection.objects.link(made[name])
        if hasattr(data, "overlook_role"):
            data.overlook_role = "RECORD"
        render = scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    return list(made.values())


def cameras_of(scene, role):
    """The scene's cameras of a role, by name."""
    found = [it for it in scene.objects if it.type == "CAMERA" and it.data.overlook_role == role]
    return sorted(found, key=lambda camera: camera.name)


class OVERLOOK_OT_mark_all(bpy.types.Operator):
    """Mark every camera of the scene as a recording camera"""

    bl_idname = "overlook.mark_all"
    bl_label = "Mark All Cameras"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        for it in context.scene.objects:
            if it.type == "CAMERA":
                it.data.overlook_role = "RECORD"
        return {"FINISHED"}


class OVERLOOK_OT_add_cameras(bpy.types.Operator):
    """Add recording cameras at the poses of a manifest, as `overlook place` writes it"""

    bl_idname = "overlook.add_cameras"
    bl_label = "Add Cameras of a Manifest"
    bl_options = {"REGISTER", "UNDO"}

    filepath: bpy.props.StringProperty(subtype="FILE_PATH")
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def execute(self, context):
        try:
            with open(bpy.path.abspath(self.filepath), encoding="utf-8") as file:
                made = add_cameras(context.scene, json.load(file))
        except (CaptureError, OSError, ValueError, KeyError, TypeError) as error:
            self.report({"ERROR"}, f"{self.filepath}: {error}")
            return {"CANCELLED"}
        self.report({"INFO"}, f"Added {len(made)} cameras")
        return {"FINISHED"}

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}


class OVERLOOK_OT_render(bpy.types.Operator):
    """Render the marked cameras over the frame range. Esc stops after the current picture"""

    bl_idname = "overlook.render"
    bl_label = "Render Capture"

    def begin(self, context):
        scene = context.scene
        cameras, truth = (cameras_of(scene, role) for role in ("RECORD", "TRUTH"))
        self.work = rendering(scene, scene.overlook_folder, cameras, truth)

    def execute(self, context):
        self.begin(context)
        try:
            for _ in self.work:
                pass
        except (CaptureError, OSError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Rendered to {bpy.path.abspath(context.scene.overlook_folder)}")
        return {"FINISHED"}

    def invoke(self, context, event):
        self.begin(context)
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self.timer = manager.event_timer_add(0.01, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.work.close()
            return self.end(context, {"WARNING"}, "Stopped; no manifest was written", {"CANCELLED"})
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            context.window_manager.progress_update(100 * next(self.work))
        except StopIteration:
            folder = bpy.path.abspath(context.scene.overlook_folder)
            return self.end(context, {"INFO"}, f"Rendered to {folder}", {"FINISHED"})
        except (CaptureError, OSError, RuntimeError) as error:
            return self.end(context, {"ERROR"}, str(error), {"CANCELLED"})
        return {"RUNNING_MODAL"}

    def end(self, context, level, text, result):
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        self.report(level, text)
        return result


class OVERLOOK_PT_capture(bpy.types.Panel):
    """Which cameras are rendered, and where to"""

    bl_label = "Overlook Capture"
    bl_idname = "OVERLOOK_PT_capture"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "output"

    def draw(self, context):
        scene, column = context.scene, self.layout.column()
        column.prop(scene, "overlook_folder")
        for it in sorted(scene.objects, key=lambda it: it.name):
            if it.type == "CAMERA":
                row = column.row()
                row.label(text=it.name, icon="CAMERA_DATA")
                row.prop(it.data, "overlook_role", text="")
        column.operator(OVERLOOK_OT_mark_all.bl_idname)
        column.operator(OVERLOOK_OT_add_cameras.bl_idname)
        pictures = len(range(scene.frame_start, scene.frame_end + 1, scene.frame_step))
        pictures *= sum(len(cameras_of(scene, role)) for role in ("RECORD", "TRUTH"))
        column.label(text=f"{pictures} pictures")
        column.operator(OVERLOOK_OT_render.bl_idname, icon="RENDER_ANIMATION")


CLASSES = (OVERLOOK_OT_mark_all, OVERLOOK_OT_add_cameras, OVERLOOK_OT_render, OVERLOOK_PT_capture)


def register():
    for it in CLASSES:
        bpy.utils.register_class(it)
    bpy.types.Camera.overlook_role = bpy.props.EnumProperty(name="Role", items=ROLES, default="NONE")
    bpy.types.Scene.overlook_folder = bpy.props.StringProperty(name="Folder", subtype="DIR_PATH", default="//capture")


def unregister():
    del bpy.types.Scene.overlook_folder
    del bpy.types.Camera.overlook_role
    for it in reversed(CLASSES):
        bpy.utils.unregister_class(it)


if __name__ == "__main__":
    register()
