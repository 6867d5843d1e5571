//! What adapters and fixed point are worst at, painted as on the CPU.
//!
//! Where the machine has no adapter, not even a software one, each test says so and passes; with `OVERLOOK_REQUIRE_GPU=1` it
//! fails instead.

mod samples;
#[path = "common/skip.rs"]
mod skip;

use std::sync::Arc;

use glam::DVec3;
use overlook::capture::Camera;
use overlook::job::Job;
use overlook::preprocess::SampleSet;
use overlook::render::{AdapterChoice, CpuRenderer, GpuRenderer, Picture, Vantage};
use overlook::settings::{Kernel, RenderSettings};
use samples::{plain_camera, samples};
use skip::skip;

/// A renderer, or `None` where the machine cannot have one.
fn gpu() -> Option<GpuRenderer> {
    let opened = GpuRenderer::new(AdapterChoice::Any);
    opened
        .inspect_err(|error| {
            skip(Some("OVERLOOK_REQUIRE_GPU"), &format!("nothing was compared: {error}"));
        })
        .ok()
}

fn front() -> Camera {
    plain_camera("front", DVec3::ZERO, 64, 48)
}

/// The picture of the CPU, and of the GPU.
fn both(
    gpu: &mut GpuRenderer,
    samples: &Arc<SampleSet>,
    camera: &Camera,
    kernel: Kernel,
) -> [Arc<Picture>; 2] {
    let settings = RenderSettings { kernel, ..RenderSettings::default() };
    let vantage = Vantage { camera: camera.clone(), frame: 0 };
    let cpu = CpuRenderer::new().render(samples, &vantage, &settings, &Job::new()).unwrap().0;
    [cpu, gpu.render(samples, &vantage, &settings, &Job::new()).unwrap().0]
}

#[test]
fn a_frame_without_samples_is_a_picture_of_holes() {
    let Some(mut gpu) = gpu() else { return };
    for kernel in Kernel::ALL {
        let [cpu, gpu] = both(&mut gpu, &samples(front(), |_, _| None), &front(), *kernel);
        assert!(cpu == gpu, "{kernel}");
        assert_eq!(gpu.holes(), 64 * 48);
    }
}
