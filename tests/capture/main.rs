//! Captures that open and captures that are refused: manifests, pictures, folders of other programs, and the built-in scenes.

#[path = "../common/analytic_scene.rs"]
mod analytic_scene;
#[path = "../common/captures.rs"]
mod captures;
#[path = "../common/command.rs"]
mod command;
#[path = "../common/draws.rs"]
mod draws;
#[path = "../common/folder.rs"]
mod folder;
#[path = "../common/said.rs"]
mod said;
#[path = "../common/scene.rs"]
mod scene;
#[path = "../common/small_capture.rs"]
mod small_capture;

mod asked_or_said;
mod color_files;
mod damage;
mod demo_scenes;
mod depth_buffers;
mod formats;
mod layers;
mod left_out;
mod manifests;
mod miv;
mod names_and_layouts;
mod no_depth;
mod orthographic;
mod other_pictures;
mod parser_damage;
mod png_depth;
mod round_trip;
mod sources;
mod transparency;
