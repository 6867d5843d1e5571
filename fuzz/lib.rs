//! The layers of Overlook that read files, without those that draw: what is fuzzed is built in a minute rather than in twenty.
#![allow(missing_docs, dead_code, clippy::all, clippy::pedantic, rustdoc::broken_intra_doc_links)]

#[path = "../src/color.rs"]
pub mod color;
#[path = "../src/error.rs"]
pub mod error;
#[path = "../src/grid.rs"]
pub mod grid;
#[path = "../src/job.rs"]
pub mod job;
#[path = "../src/plural.rs"]
mod plural;
#[path = "../src/settings/mod.rs"]
pub mod settings;
#[path = "../src/simd.rs"]
mod simd;
#[path = "../src/whole_file.rs"]
mod whole_file;

#[path = "../src/capture/mod.rs"]
pub mod capture;
#[path = "../src/samples/mod.rs"]
pub mod samples;
#[path = "../src/store/mod.rs"]
pub mod store;
