//! Stores: written samples come back, damage is refused, a second reader reads the same, and playback reads only what it needs.

#[path = "../common/builder.rs"]
mod builder;
#[path = "../common/draws.rs"]
mod draws;

mod contract;
mod playback;
mod second_reader;
mod trust;
mod verdicts;
