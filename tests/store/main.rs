//! Stores: what is written comes back, damage is refused, and a second reader reads the same.

#[path = "../common/builder.rs"]
mod builder;
#[path = "../common/draws.rs"]
mod draws;

mod contract;
mod playback;
mod second_reader;
mod trust;
