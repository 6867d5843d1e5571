# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tries the add-on for real: builds a small scene with `bpy`, renders it through the add-on's own operator, and opens it in Overlook.

    pip install bpy && python try_blender.py OVERLOOK FOLDER

Two cameras record four frames of a ball that rolls over a textured floor; a third one between them is the truth. What Overlook renders
there from the other two has to score above 30 dB, and nothing may be asked or warned of.
"""

import json
import os
import subprocess
import sys

import bpy
from mathutils import Vector

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]
import overlook_capture
from score_capture import score_capture

FRAMES = 4


def material(name, scale):
    """A diffuse material with a smooth texture."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    output, diffuse = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    noise, place = nodes.new("ShaderNodeTexNoise"), nodes.new("ShaderNodeTexCoord")
    noise.inputs["Scale"].default_value = scale
    links.new(place.outputs["Object"], noise.inputs["Vector"])
    links.new(noise.outputs["Color"], diffuse.inputs["Color"])
    links.new(diffuse.outputs["BSDF"], output.inputs["Surface"])
    return made


def camera(name, x, role):
    """A camera at the height of a person that looks at the ball."""
    made = bpy.data.objects.new(name, bpy.data.cameras.new(name))
    made.location = (x, -6.0, 2.5)
    made.rotation_euler = (Vector((0, 0, 0.6)) - made.location).to_track_quat("-Z", "Y").to_euler()
    made.data.overlook_role = role
    made.data.shift_x = 0.02
    bpy.context.scene.collection.objects.link(made)
    return made


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    overlook_capture.register()
    scene = bpy.context.scene
    for name, location, rotation in (("Floor", (0, 0, 0), (0, 0, 0)), ("Wall", (0, 4, 0), (1.5708, 0, 0))):
        bpy.ops.mesh.primitive_plane_add(size=40, location=location, rotation=rotation)
        bpy.context.object.name = name
        bpy.context.object.data.materials.append(material(name, 0.7))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.8, location=(0, 0, 0.8))
    ball = bpy.context.object
    bpy.ops.object.shade_smooth()
    ball.data.materials.append(material("Ball", 1.5))
    for frame in range(1, FRAMES + 1):
        ball.location.x = 0.15 * (frame - 2.5)
        ball.keyframe_insert("location", frame=frame)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 3.0, 0.0, (0.7, 0.2, 0.0)
    scene.collection.objects.link(sun)
    camera("Left", -0.5, "RECORD")
    camera("Right eye", 0.5, "RECORD")
    camera("Between", 0.0, "TRUTH")
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 320, 240, 100
    # Light that comes straight from a sharp sun: no noise.
    scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.use_denoising = 32, 0, False
    return scene


def check_placed(overlook, folder, scene):
    """Poses that are placed by the capture become cameras that stand and look as the manifest says."""
    placed = os.path.join(folder, "placed.json")
    subprocess.run([overlook, "place", folder, "--cameras", "2", "--size", "400x200", "--out", placed], check=True)
    assert bpy.ops.overlook.add_cameras(filepath=placed) == {"FINISHED"}
    with open(placed, encoding="utf-8") as file:
        entries = json.load(file)["frames"]
    bpy.context.view_layer.update()
    for entry in entries:
        added = scene.objects[entry["camera"]]
        found = [value for row in overlook_capture.pose(added) for value in row]
        assert all(abs(a - b) < 1e-5 for a, b in zip(found, sum(entry["transform_matrix"], []))), added.name
        lens = overlook_capture.lens(scene, added)
        assert all(abs(lens[key] - entry[key]) < 1e-3 * entry["w"] for key in lens), (lens, entry)
        assert added.data.overlook_role == "RECORD"


def main():
    overlook, folder = sys.argv[1], os.path.abspath(sys.argv[2])
    scene = build()
    scene.overlook_folder = folder
    before = (scene.render.filepath, scene.render.image_settings.file_format, scene.camera)
    assert bpy.ops.overlook.render() == {"FINISHED"}
    assert before == (scene.render.filepath, scene.render.image_settings.file_format, scene.camera), "settings are restored"
    score_capture(overlook, folder, f"Blender {bpy.app.version_string}", FRAMES)
    check_placed(overlook, folder, scene)


if __name__ == "__main__":
    main()
