//! The layers of Overlook that read files, without those that draw: what is fuzzed is built in a minute rather than in twenty.
#![allow(missing_docs, dead_code, clippy::all, clippy::pedantic, rustdoc::broken_intra_doc_links)]

#[path = "../src/engine/color.rs"]
pub mod color;
#[path = "../src/engine/error.rs"]
pub mod error;
#[path = "../src/engine/grid.rs"]
pub mod grid;
#[path = "../src/engine/job.rs"]
pub mod job;
#[path = "../src/engine/median.rs"]
mod median;
#[path = "../src/engine/plural.rs"]
mod plural;
#[path = "../src/engine/settings/mod.rs"]
pub mod settings;
#[path = "../src/engine/simd.rs"]
mod simd;
#[path = "../src/engine/whole_file.rs"]
mod whole_file;

#[path = "../src/engine/capture/mod.rs"]
pub mod capture;
#[path = "../src/engine/samples/mod.rs"]
pub mod samples;
#[path = "../src/engine/store/mod.rs"]
pub mod store;
