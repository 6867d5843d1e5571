//! Speed of each stage: `cargo bench --bench stages`, or a part of the names, as in `cargo bench --bench stages -- store`.
//!
//! All threads work unless `RAYON_NUM_THREADS` says how many. A graphics adapter is measured besides where there is one. At the end
//! stands how the time of each default picture is split among its stages.

mod preprocess;
mod render;
mod scene;
mod store;

fn main() {
    divan::Divan::default().sample_size(1).sample_count(10).config_with_args().main();
    render::print_stage_times();
}
