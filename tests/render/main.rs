//! Rendering: its promises, its quality, and the same pictures on the processor and on graphics cards.

#[path = "../common/boxes.rs"]
mod boxes;
#[path = "../common/draws.rs"]
mod draws;
#[path = "../common/moving.rs"]
mod moving;
#[path = "../common/samples.rs"]
mod samples;
#[path = "../common/scene.rs"]
mod scene;
#[path = "../common/skip.rs"]
mod skip;
#[path = "../common/small_capture.rs"]
mod small_capture;

mod extreme_vantages;
mod free_space;
mod gpu_extremes;
mod gpu_finish;
mod gpu_parity;
mod gpu_window;
mod hole_filling;
mod rendering_promises;
mod rendering_quality;
mod zoom;
