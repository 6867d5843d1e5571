//! Rendering (the paper, §3.3): paints the kept samples into a vantage.
//!
//! ```text
//! SampleSet ─ input ─▶ tiles of the frame ─ geometry: cull ─▶ bands ─ splat: surface ─▶ keys ─ splat: blend ─▶ sums
//!                                                                                        │                      │
//!      Picture ◀─ fill ◀─ free_space ◀─ resolve ◀─ gather: color of surface points ◀─ silhouette ──┴────────────┘
//! ```
//!
//! The *surface* stage finds the nearest sample of every pixel. What follows depends on the kernel: `point` shows that
//! sample; `block` and `surfel` *blend* all samples of its surface; `gather` looks its surface point up in the cameras.
//! The background depends on the vantage alone and is kept while the vantage is still; the foreground of each frame is
//! painted over it by depth, as the paper does. [`Renderer`] chooses between [`CpuRenderer`] and [`gpu`].

pub mod fill;
pub mod film;
pub mod gpu;
pub mod output;

mod carried_picture;
mod coarser_samples;
mod cpu;
mod environment;
mod equirectangular;
mod finish;
mod free_space;
mod gather;
mod geometry;
mod input;
mod magnified;
mod orthographic;
mod painter;
mod recorded_rates;
mod renderer;
mod resolve;
mod splat;
mod stage_times;
mod supersample;
mod value_colors;
mod vantage;

pub use carried_picture::{CarriedPicture, PictureCarrier, ScreenColor, ScreenPicture};
pub use cpu::CpuRenderer;
pub use environment::background_holes;
pub(crate) use environment::{sky_map, surroundings};
pub use equirectangular::{FACE_COUNT, Projection, equirectangular, faces_around};
pub use orthographic::OrthographicView;
pub use painter::Painter;
pub use renderer::{Renderer, WindowPicture};
pub use stage_times::StageTimes;
pub use value_colors::{BACKGROUND_COLOR, MISSING_COLOR, ValueColors, colored_samples};
pub use vantage::{MAX_PIXELS, NO_IMAGE, Picture, RenderStats, Vantage};

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::job::Job;
    use crate::preprocess::preprocess;
    use crate::samples::SampleSet;
    use crate::settings::{Kernel, RenderSettings, Settings};
    use crate::simd;

    /// The samples of the default scene, with two frames, and its vantage at a frame.
    pub(in crate::render) fn scene(spec: DemoSpec, frame: usize) -> (Arc<SampleSet>, Vantage) {
        let demo = Demo::new(&spec.frames(2)).unwrap();
        let settings = Settings::default();
        let samples = preprocess(&demo.capture(&settings.capture), &settings, &Job::new()).unwrap().samples;
        (samples, Vantage { camera: demo.home(), frame })
    }

    #[test]
    fn every_instruction_set_paints_the_same_bits() {
        let (samples, vantage) = scene(DemoSpec::new("orrery").size((72, 50)), 1);
        for &kernel in Kernel::ALL {
            let settings = RenderSettings { kernel, ..RenderSettings::default() };
            let pictures = simd::at_every_level(|| {
                CpuRenderer::new().render(&samples, &vantage, &settings, &Job::new()).unwrap().0
            });
            assert!(pictures[0].holes() < pictures[0].image.len() as u64 / 2);
            assert!(pictures.iter().all(|picture| *picture == pictures[0]), "{kernel}");
        }
    }
}
