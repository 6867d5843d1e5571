//! What adapters and fixed point are worst at, painted as on the CPU: nothing at all, and samples that fill the picture.
//!
//! Where the machine has no adapter, not even a software one, each test says so and passes; with `OVERLOOK_REQUIRE_GPU=1` it
//! fails instead.

use std::sync::Arc;

use crate::samples::{plain_camera, samples};
use crate::skip::skip;
use glam::DVec3;
use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::job::Job;
use overlook_engine::render::gpu::{AdapterChoice, GpuRenderer};
use overlook_engine::render::{CpuRenderer, Picture, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Fill, Kernel, RenderSettings};

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

/// A wall of coarse checks that bulges, so that footprints are slanted.
fn wall() -> Arc<SampleSet> {
    samples(front(), |x, y| {
        let color = if (x / 2 + y / 2) % 2 == 0 { [0.75, 0.25, 0.0625] } else { [0.125, 0.5, 0.25] };
        Some((color, 0.25 + 0.0005 * ((x as f32 - 32.0).powi(2) + (y as f32 - 24.0).powi(2)).sqrt()))
    })
}

/// The camera of the wall with a lens so many times as long, shifted so that a sample lies near the middle of the picture.
fn zoomed(times: f64, (width, height): (u32, u32)) -> Camera {
    let plain = plain_camera("zoomed", DVec3::ZERO, width, height);
    let focal = times * front().intrinsics.fx;
    let [cx, cy] = [width, height].map(|size| f64::from(size) / 2.0 + 17.3 - times / 2.0);
    Camera { intrinsics: Intrinsics { fx: focal, fy: focal, cx, cy, ..plain.intrinsics }, ..plain }
}

/// The picture of the CPU, and of the GPU, with holes left.
fn both(
    gpu: &mut GpuRenderer,
    samples: &Arc<SampleSet>,
    camera: &Camera,
    kernel: Kernel,
) -> [Arc<Picture>; 2] {
    let settings = RenderSettings { kernel, fill: Fill::None, ..RenderSettings::default() };
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

#[test]
fn surfels_are_blended_as_on_the_cpu_however_close_the_vantage() {
    let Some(mut gpu) = gpu() else { return };
    for times in [5.0, 20.0, 50.0, 100.0, 200.0, 1e3, 1e4, 2e4] {
        let [cpu, gpu] = both(&mut gpu, &wall(), &zoomed(times, (200, 200)), Kernel::Surfel);
        let pixels = cpu.color.as_slice().iter().zip(gpu.color.as_slice());
        let off = pixels.map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max));
        // The border of a footprint may fall to either side of a pixel.
        let count = off.filter(|off| *off > 1e-3).count();
        assert!(count * 1000 < 200 * 200, "{count} pixels differ at a lens {times} times as long");
    }
}

#[test]
fn a_sample_that_fills_the_picture_leaves_no_hole() {
    let Some(mut gpu) = gpu() else { return };
    for kernel in [Kernel::Surfel, Kernel::Gather] {
        for times in [400.0, 2000.0] {
            let [cpu, gpu] = both(&mut gpu, &wall(), &zoomed(times, (640, 480)), kernel);
            assert_eq!((cpu.holes(), gpu.holes()), (0, 0), "{kernel}, a lens {times} times as long");
        }
    }
}
