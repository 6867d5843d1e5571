# SPDX-License-Identifier: MIT OR Apache-2.0
"""Mitsuba 3: renders cameras over frames as a capture that Overlook opens.

    import mitsuba as mi; mi.set_variant("llvm_ad_rgb")     # or scalar_rgb, cuda_ad_rgb
    from overlook_capture import render_capture
    render_capture(lambda frame: mi.load_dict(scene(frame)), {"left": left, "right": right}, "FOLDER", frames=range(4), spp=256)

Cameras are `perspective` sensors that stand still; `frames` are the numbers that the first argument makes scenes of. Color is what the
scene's integrator gives. `sensors(manifest)` makes them of a manifest of poses, as `overlook place` writes it. Depth and normals are not taken from its `aov` integrator, whose film filter blends them across silhouettes:
a ray is cast through the center of every pixel. Written are `FOLDER/CAMERA/0000.exr` with channels R G B Z N.X N.Y N.Z, and
`FOLDER/transforms.json`. Render true views the same way into `FOLDER/novel`.
"""

import json
import os

import mitsuba as mi
import numpy as np


def render_capture(scene_of_frame, cameras, folder, frames=(0,), spp=64, up=(0, 0, 1)):
    """Renders every camera at every frame; `up` is the world's."""
    if not cameras:
        raise ValueError("there is no camera")
    entries = []
    for frame in frames:
        scene = scene_of_frame(frame)
        for name, sensor in cameras.items():
            pose = camera_to_world(sensor)
            lens = pinhole(name, sensor, pose)
            color = np.array(mi.render(scene, sensor=sensor, spp=spp, seed=frame))[..., :3]
            depth, normal = geometry(scene, sensor, pose, lens)
            path = f"{name}/{frame:04d}.exr"
            os.makedirs(os.path.join(folder, name), exist_ok=True)
            write(os.path.join(folder, path), color, depth, normal)
            entries.append(
                {"camera": name, "frame": frame, "file_path": path, "transform_matrix": pose.tolist(), **lens}
            )
    manifest = {
        "depth_kind": "planar_z",
        "depth_channel": "Z",
        "depth_miss_value": 1e10,
        "normal_space": "world",
        "antialiased_color": True,
        "up": list(up),
        "frames": entries,
    }
    with open(os.path.join(folder, "transforms.json"), "w", encoding="utf-8") as file:
        json.dump(manifest, file, indent=1)


def sensors(manifest):
    """The cameras of a manifest of poses, each once, by their names: `sensors(json.load(file))`."""
    found = {}
    for entry in manifest["frames"]:
        width, height = int(entry["w"]), int(entry["h"])
        to_world = np.array(entry["transform_matrix"], dtype=np.float64) @ np.diag([-1.0, 1.0, -1.0, 1.0])
        sensor = {
            "type": "perspective",
            "fov_axis": "x",
            "fov": float(np.degrees(2 * np.arctan(width / (2 * entry["fl_x"])))),
            "principal_point_offset_x": 0.5 - entry["cx"] / width,
            "principal_point_offset_y": 0.5 - entry["cy"] / height,
            "to_world": mi.ScalarTransform4f(to_world.tolist()),
            "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "gaussian"}},
        }
        found.setdefault(entry["camera"], sensor)
    return {name: mi.load_dict(sensor) for name, sensor in found.items()}


def camera_to_world(sensor):
    """The pose with x right, y up, looking along -z: Mitsuba's cameras have x left, y up and look along z."""
    matrix = np.array(sensor.world_transform().matrix, dtype=np.float64).reshape(4, 4)
    pose = matrix @ np.diag([-1.0, 1.0, -1.0, 1.0])
    pose[:3, :3] /= np.linalg.norm(pose[:3, :3], axis=0)
    return pose


def pinhole(name, sensor, pose):
    """The lens in pixels, told from rays through two corners of the picture: the sensor's own word for field of view and offsets."""
    if "x_fov" not in mi.traverse(sensor):
        raise ValueError(f"camera '{name}' is no perspective sensor")
    width, height = (int(side) for side in sensor.film().crop_size())
    if (width, height) != tuple(int(side) for side in sensor.film().size()):
        raise ValueError(f"the film of camera '{name}' is cropped; render it whole")

    def slope(corner):
        ray, _ = sensor.sample_ray(0, 0.5, mi.Point2f(corner, corner), mi.Point2f(0.5, 0.5))
        x, y, z = np.array(ray.d, dtype=np.float64).ravel() @ pose[:3, :3]
        return np.array([x / -z, -y / -z])

    first, last = slope(0.0), slope(1.0)
    focal = np.array([width, height]) / (last - first)
    center = -first * focal
    return {
        "w": width,
        "h": height,
        "fl_x": float(focal[0]),
        "fl_y": float(focal[1]),
        "cx": float(center[0]),
        "cy": float(center[1]),
    }


def geometry(scene, sensor, pose, lens):
    """Planar z (1e10 where nothing is hit) and normals toward the camera (0 there) at the center of every pixel."""
    width, height = lens["w"], lens["h"]
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    local = np.stack([(x - lens["cx"]) / lens["fl_x"], -(y - lens["cy"]) / lens["fl_y"], -np.ones_like(x)], -1)
    directions = local.reshape(-1, 3) @ pose[:3, :3].T
    eye = np.broadcast_to(pose[:3, 3], directions.shape)
    depth, normal = np.full(len(directions), 1e10, np.float32), np.zeros((len(directions), 3), np.float32)
    if "scalar" in mi.variant():
        for index, direction in enumerate(directions):
            hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(eye[index].tolist()), mi.Vector3f(direction.tolist())))
            if hit.is_valid():
                depth[index], normal[index] = hit.t, np.array(hit.sh_frame.n)
    else:
        ray = mi.Ray3f(mi.Point3f(*np.float32(eye).T.copy()), mi.Vector3f(*np.float32(directions).T.copy()))
        hit = scene.ray_intersect(ray)
        valid = np.array(hit.is_valid())
        # The directions' planar length is 1: their parameter is planar z.
        depth = np.where(valid, np.array(hit.t), 1e10).astype(np.float32)
        normal = np.where(valid, np.array(hit.sh_frame.n).reshape(3, -1), 0).T.astype(np.float32)
    normal[np.sum(normal * directions, axis=1) > 0] *= -1
    return depth.reshape(height, width), normal.reshape(height, width, 3)


def write(path, color, depth, normal):
    """One EXR file of 32-bit floats."""
    channels = np.concatenate([color, depth[..., None], normal], axis=-1).astype(np.float32)
    names = ["R", "G", "B", "Z", "N.X", "N.Y", "N.Z"]
    mi.Bitmap(channels, pixel_format=mi.Bitmap.PixelFormat.MultiChannel, channel_names=names).write(path)
