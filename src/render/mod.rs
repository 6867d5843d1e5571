//! Rendering (the paper, §3.3): paints the kept samples into a vantage.
//!
//! ```text
//! SampleSet ─ frame_samples ─▶ tiles of the frame ─ cull ─▶ bands ─ project, footprint ─▶ surface ─▶ keys ─▶ blend ─▶ sums
//!                                                                                          │                        │
//!      Picture ◀─ fill ◀─ resolve ◀─ gather ◀─ lookup, window: into cameras ◀─ silhouette ─┴────────────────────────┘
//! ```
//!
//! The *surface* stage finds the nearest sample of every pixel. What follows depends on the kernel: `point` shows that
//! sample; `block` and `surfel` *blend* all samples of its surface; `gather` looks its surface point up in the cameras.
//! The background depends on the vantage alone and is kept while the vantage is still; the foreground of each frame is
//! painted over it by depth, as the paper does, where it is and where it was.

mod cpu;
pub mod fill;
pub mod film;
pub mod gather;
pub mod geometry;
pub mod gpu;
pub mod input;
pub mod output;
mod renderer;
pub mod resolve;
pub mod splat;
mod supersample;
mod vantage;

pub use cpu::CpuRenderer;
pub use renderer::{Painter, Renderer, WindowPicture};
pub use vantage::{MAX_PIXELS, NO_IMAGE, Picture, RenderStats, Vantage};

#[cfg(test)]
mod tests {
    use crate::demo::{Demo, DemoSpec};
    use crate::job::Job;
    use crate::preprocess::preprocess;
    use crate::render::cpu::CpuRenderer;
    use crate::render::vantage::Vantage;
    use crate::settings::{CaptureSettings, Kernel, RenderSettings, Settings};
    use crate::simd;

    #[test]
    fn every_instruction_set_paints_the_same_bits() {
        let spec = DemoSpec::new("orrery").frames(2).size((72, 50));
        let demo = Demo::new(&spec).unwrap();
        let capture = demo.capture(&CaptureSettings::default());
        let samples = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples;
        let vantage = Vantage { camera: demo.home(), frame: 1 };
        for &kernel in Kernel::ALL {
            let settings = RenderSettings { kernel, ..RenderSettings::default() };
            let pictures = crate::simd::at_every_level(|| {
                CpuRenderer::new().render(&samples, &vantage, &settings, &Job::new()).unwrap().0
            });
            assert!(pictures[0].holes() < pictures[0].image.len() as u64 / 2);
            assert!(pictures.iter().all(|picture| *picture == pictures[0]), "{kernel}");
        }
    }
}
