//! The GPU renderer finds and fills holes as the CPU renderer does: what follows on a painted picture, apart and together with
//! painting.
//!
//! Where the machine has no adapter, not even a software one, each test says so and passes; with `OVERLOOK_REQUIRE_GPU=1` it
//! fails instead.

use std::sync::Arc;

use crate::boxes::{Block, Blocks, block, eye};
use crate::gpu_parity::{close, distant, gpu, novel, samples, samples_pruned_by};
use crate::moving::moving_capture;
use glam::DVec3;
use overlook_engine::capture::Camera;
use overlook_engine::job::Job;
use overlook_engine::render::fill::fill;
use overlook_engine::render::gpu::GpuRenderer;
use overlook_engine::render::{CpuRenderer, NO_IMAGE, Picture, Renderer, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Backend, Fill, Kernel, PruningMethod, RenderSettings};

/// Pixels of two pictures that differ.
#[derive(Debug, Default)]
struct Differing {
    /// In the image whose sample they show, or in whether they are holes.
    image: usize,
    /// In inverse depth, by more than 10⁻⁴ of it.
    depth: usize,
    /// In color, by more than 10⁻³ where image and depth are the same.
    color: usize,
    pixels: usize,
}

impl Differing {
    fn between(a: &Picture, b: &Picture) -> Self {
        let mut found = Self { pixels: a.image.len(), ..Self::default() };
        for pixel in 0..found.pixels {
            let depths = [a, b].map(|picture| picture.inverse_depth.as_slice()[pixel]);
            let colors = [a, b].map(|picture| picture.color.as_slice()[pixel]);
            let off = (0..3).map(|channel| (colors[0][channel] - colors[1][channel]).abs());
            if a.image.as_slice()[pixel] != b.image.as_slice()[pixel] {
                found.image += 1;
            } else if (depths[0] - depths[1]).abs() > 1e-4 * depths[0].abs() {
                found.depth += 1;
            } else if off.fold(0.0, f32::max) > 1e-3 {
                found.color += 1;
            }
        }
        found
    }

    /// Whether no more than this share of the pixels differ in anything.
    fn is_within(&self, share: f64) -> bool {
        (self.image + self.depth + self.color) as f64 <= share * self.pixels as f64
    }
}

fn paint(
    gpu: &mut GpuRenderer,
    samples: &Arc<SampleSet>,
    vantage: &Vantage,
    settings: &RenderSettings,
) -> Picture {
    (*gpu.render(samples, vantage, settings, &Job::new()).unwrap().0).clone()
}

fn on_cpu(samples: &Arc<SampleSet>, vantage: &Vantage, settings: &RenderSettings) -> Arc<Picture> {
    CpuRenderer::new().render(samples, vantage, settings, &Job::new()).unwrap().0
}

/// Filled by the CPU, and by the GPU, from the same painted picture.
fn both_filled(
    gpu: &mut GpuRenderer,
    samples: &Arc<SampleSet>,
    camera: Camera,
    kernel: Kernel,
) -> [Picture; 3] {
    let vantage = Vantage { camera, frame: 1 };
    let filled = RenderSettings { kernel, free_space: false, ..RenderSettings::default() };
    let plain = paint(gpu, samples, &vantage, &RenderSettings { fill: Fill::None, ..filled.clone() });
    let mut by_cpu = plain.clone();
    fill(&mut by_cpu, &vantage.camera, &filled);
    [plain, by_cpu, paint(gpu, samples, &vantage, &filled)]
}

/// Share of filled pixels that may differ: a surface that is at a limit to the last bits counts for one and not for the other. It is of
/// the filled pixels alone. Of all pixels it is less than 5·10⁻⁴ wherever holes take less than half of a picture.
const DIFFERING_FILLED: f64 = 1e-3;

fn holes(picture: &Picture) -> usize {
    picture.image.as_slice().iter().filter(|image| **image == NO_IMAGE).count()
}

/// Whether no more pixels differ than may, of those that were holes in a picture.
fn fills_alike(plain: &Picture, found: &Differing) -> bool {
    found.image == 0 && (found.depth + found.color) as f64 <= DIFFERING_FILLED * holes(plain) as f64
}

#[test]
fn holes_are_filled_as_on_the_cpu_in_pictures_of_any_size() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&moving_capture());
    let mut cameras = vec![novel(), close(), distant()];
    for (width, height) in [(1, 1), (17, 5), (3, 70), (131, 97)] {
        let mut odd = novel();
        (odd.intrinsics.width, odd.intrinsics.height) = (width, height);
        (odd.intrinsics.cx, odd.intrinsics.cy) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
        cameras.push(odd);
    }
    let mut filled = 0;
    for kernel in [Kernel::Point, Kernel::Gather] {
        for camera in &cameras {
            let [plain, cpu, gpu] = both_filled(&mut gpu, &samples, camera.clone(), kernel);
            let found = Differing::between(&cpu, &gpu);
            assert!(fills_alike(&plain, &found), "{kernel}: {found:?}");
            assert_eq!(plain.image, gpu.image, "filled pixels stay marked");
            filled += holes(&plain);
        }
    }
    assert!(filled > 5000, "there must be something to fill, not {filled} pixels");
}

#[test]
fn filling_from_what_is_a_hundredth_farther_does_not_pass_for_the_same_filling() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&moving_capture());
    let [plain, _, gpu] = both_filled(&mut gpu, &samples, close(), Kernel::Point);
    let mut other = plain.clone();
    other.inverse_depth.as_mut_slice().iter_mut().for_each(|depth| *depth *= 0.99);
    let settings = RenderSettings { kernel: Kernel::Point, ..RenderSettings::default() };
    fill(&mut other, &close(), &settings);
    for (pixel, painted) in plain.inverse_depth.as_slice().iter().enumerate().filter(|(_, w)| **w >= 0.0) {
        other.inverse_depth.as_mut_slice()[pixel] = *painted;
    }
    let found = Differing::between(&other, &gpu);
    assert!(found.image == 0 && !fills_alike(&plain, &found), "{found:?}");
}

/// A deep shaft before the sky, a bar that moves across it, and cameras around.
fn shaft(cameras: usize, frames: usize) -> Arc<SampleSet> {
    let (z, color) = ([4.0, 8.0], [0.75, 0.125, 0.0625]);
    let bar = Block {
        step: DVec3::new(0.15, 0.0, 0.0),
        ..block([-0.8, -0.6], [-1.2, 1.2], [2.9, 3.0], [0.125, 0.5, 0.25])
    };
    let blocks = vec![
        block([-0.9, 0.9], [-0.9, -0.25], z, color),
        block([-0.9, 0.9], [0.25, 0.9], z, color),
        block([-0.9, -0.25], [-0.25, 0.25], z, color),
        block([0.25, 0.9], [-0.25, 0.25], z, color),
        bar,
    ];
    let scene = Blocks { blocks, sky: |ray| [0.125, 0.25 + 0.25 * ray.x as f32, 0.75] };
    let around = |nth: usize| {
        let angle = std::f64::consts::TAU * nth as f64 / cameras as f64;
        eye(1.2 * angle.cos(), 1.2 * angle.sin(), 96)
    };
    samples_pruned_by(
        PruningMethod::HighestRate,
        &scene.record(&(0..cameras).map(around).collect::<Vec<_>>(), frames),
    )
}

/// Share of pixels that may differ from the CPU's picture once it is finished: what painting lets differ, carried on by filling.
const DIFFERING: f64 = 2e-3;

#[test]
fn pictures_with_all_defaults_are_those_of_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    for (name, samples) in [("still life", samples(&moving_capture())), ("shaft", shaft(4, 3))] {
        for kernel in Kernel::ALL {
            for frame in 0..3 {
                let camera = if name == "shaft" { eye(0.02, 0.01, 96) } else { novel() };
                let vantage = Vantage { camera, frame };
                let settings = RenderSettings { kernel: *kernel, ..RenderSettings::default() };
                let cpu = on_cpu(&samples, &vantage, &settings);
                let found = Differing::between(&cpu, &paint(&mut gpu, &samples, &vantage, &settings));
                assert!(found.is_within(DIFFERING), "{name}, {kernel}, frame {frame}: {found:?}");
                assert!(found.image * 1000 <= found.pixels, "{name}, {kernel}, frame {frame}: {found:?}");
            }
        }
    }
}

#[test]
fn pictures_whose_lines_of_sight_are_not_tested_do_not_pass_for_the_default() {
    let Some(mut gpu) = gpu() else { return };
    let samples = shaft(4, 1);
    let vantage = Vantage { camera: eye(0.02, 0.01, 96), frame: 0 };
    for kernel in [Kernel::Surfel, Kernel::Gather] {
        let settings = RenderSettings { kernel, ..RenderSettings::default() };
        let cpu = on_cpu(&samples, &vantage, &settings);
        let untested = RenderSettings { free_space: false, ..settings };
        let found = Differing::between(&cpu, &paint(&mut gpu, &samples, &vantage, &untested));
        assert!(!found.is_within(DIFFERING), "{kernel}: {found:?}");
    }
}

#[test]
fn what_cameras_saw_is_kept_while_frames_and_vantages_change_and_shows_the_same() {
    let (Some(mut kept), Some(mut fresh)) = (gpu(), gpu()) else { return };
    // More cameras than are asked about a line of sight.
    let (samples, other) = (shaft(16, 3), shaft(4, 1));
    let places = [(0.02, 0.01), (0.4, 0.1), (-0.3, 0.2), (0.02, 0.01)];
    for (nth, (x, y)) in places.into_iter().enumerate() {
        for frame in [0, nth % 3, 2] {
            let vantage = Vantage { camera: eye(x, y, 48), frame };
            let settings = RenderSettings::default();
            // Other samples in between leave nothing that could be kept.
            paint(&mut fresh, &other, &Vantage { frame: 0, ..vantage.clone() }, &settings);
            let again = paint(&mut kept, &samples, &vantage, &settings);
            assert!(again == paint(&mut fresh, &samples, &vantage, &settings), "frame {frame} at {x}, {y}");
        }
    }
}

#[test]
fn pictures_coarser_than_the_recording_are_averaged_as_on_the_cpu() {
    if gpu().is_none() {
        return;
    }
    for (samples, mut camera) in [(samples(&moving_capture()), novel()), (shaft(4, 1), eye(0.02, 0.01, 96))] {
        let lens = &mut camera.intrinsics;
        (lens.width, lens.height) = (lens.width / 3, lens.height / 3);
        for length in [&mut lens.fx, &mut lens.fy, &mut lens.cx, &mut lens.cy] {
            *length /= 3.0;
        }
        let vantage = Vantage { camera, frame: 0 };
        let painted = [Backend::Cpu, Backend::Gpu].map(|backend| {
            let settings = RenderSettings { backend, ..RenderSettings::default() };
            let mut renderer = Renderer::strict(backend).unwrap();
            let (picture, stats) = renderer.render(&samples, &vantage, &settings, &Job::new()).unwrap();
            assert_eq!((renderer.notice(), stats.holes), (None, picture.holes()));
            picture
        });
        let found = Differing::between(&painted[0], &painted[1]);
        assert!(found.is_within(DIFFERING), "{found:?}");
    }
}
