//! Preprocessing: samples redundant in space and time, the reason for each, and the promises that hold for every capture.

#[path = "../common/coverage.rs"]
mod coverage;
#[path = "../common/draws.rs"]
mod draws;
#[path = "../common/moving.rs"]
mod moving;
#[path = "../common/scene.rs"]
mod scene;
#[expect(dead_code, reason = "views serve other tests")]
#[path = "../common/small_capture.rs"]
mod small_capture;

mod agreement;
mod edits;
mod orthographic;
mod paper_levels;
mod pixel_account;
mod pixel_argument;
mod preprocessing_promises;
mod pruning_properties;
mod random_captures;
mod repeated_frames;
mod scalar_values;
mod selections;
mod span_tree;
mod value_regions;
mod view_dependence;
