//! The GPU renderer paints what the CPU renderer paints, stage by stage, on scenes whose shapes are known.
//!
//! Where the machine has no adapter, not even a software one, each test says so and passes; with `OVERLOOK_REQUIRE_GPU=1` it
//! fails instead, so that a check that is meant to run them cannot pass without.

use std::sync::Arc;

use crate::boxes::{Blocks, block, eye};
use crate::moving::moving_capture;
use crate::scene::{Scene, arc, camera};
use crate::skip::skip;
use glam::DVec3;
use overlook_engine::capture::{Camera, Capture};
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::render::gpu::{GpuOptions, GpuRenderer};
use overlook_engine::render::{CpuRenderer, Picture, RenderStats, Vantage};
use overlook_engine::samples::{SampleSet, TILE, TileMask};
use overlook_engine::settings::{Fill, Kernel, PruningMethod, RenderSettings, Settings};

/// A renderer, or `None` where the machine cannot have one.
fn gpu_with(options: &GpuOptions) -> Option<GpuRenderer> {
    match GpuRenderer::with_options(options) {
        Ok(renderer) => Some(renderer),
        Err(error) => {
            skip(Some("OVERLOOK_REQUIRE_GPU"), &format!("nothing was compared: {error}"));
            None
        }
    }
}

pub(super) fn gpu() -> Option<GpuRenderer> {
    gpu_with(&GpuOptions::default())
}

pub(super) fn samples(capture: &Capture) -> Arc<SampleSet> {
    samples_pruned_by(PruningMethod::HighestRate, capture)
}

pub(super) fn samples_pruned_by(method: PruningMethod, capture: &Capture) -> Arc<SampleSet> {
    let mut settings = Settings::default();
    settings.pruning.method = method;
    preprocess(capture, &settings, &Job::new()).unwrap().samples
}

/// A place where no camera stood.
pub(super) fn novel() -> Camera {
    camera("novel", DVec3::new(-0.6, -4.2, 1.6), DVec3::new(0.3, 0.2, 0.3), 90)
}

/// So near that footprints cover many pixels.
pub(super) fn close() -> Camera {
    camera("close", DVec3::new(0.3, -1.6, 0.7), DVec3::new(0.3, 0.2, 0.3), 80)
}

/// So far that many samples fall into one pixel.
pub(super) fn distant() -> Camera {
    camera("distant", DVec3::new(-2.0, -16.0, 6.0), DVec3::new(0.3, 0.2, 0.3), 72)
}

/// Holes stay: filling would carry a difference beyond its pixel.
fn settings(kernel: Kernel) -> RenderSettings {
    RenderSettings { kernel, fill: Fill::None, ..RenderSettings::default() }
}

fn on_cpu(
    samples: &Arc<SampleSet>,
    camera: &Camera,
    frame: usize,
    kernel: Kernel,
) -> (Arc<Picture>, RenderStats) {
    let vantage = Vantage { camera: camera.clone(), frame };
    CpuRenderer::new().render(samples, &vantage, &settings(kernel), &Job::new()).unwrap()
}

fn on_gpu(
    renderer: &mut GpuRenderer,
    samples: &Arc<SampleSet>,
    camera: &Camera,
    frame: usize,
    kernel: Kernel,
) -> (Arc<Picture>, RenderStats) {
    let vantage = Vantage { camera: camera.clone(), frame };
    renderer.render(samples, &vantage, &settings(kernel), &Job::new()).unwrap()
}

/// Shares of the pixels that differ.
#[derive(Debug)]
struct Difference {
    /// In the image whose sample is nearest, or in whether there is one.
    image: f64,
    /// In inverse depth, by more than 10⁻⁵ of it.
    depth: f64,
    /// In color, by more than 10⁻³ (a quarter of an 8-bit step of light) where image and depth are the same.
    color: f64,
    /// The largest difference in color where image and depth are the same.
    worst: f32,
}

impl Difference {
    fn between(a: &Picture, b: &Picture) -> Self {
        let count = a.image.as_slice().len();
        let mut found = Self { image: 0.0, depth: 0.0, color: 0.0, worst: 0.0 };
        for pixel in 0..count {
            let depths = [a, b].map(|picture| picture.inverse_depth.as_slice()[pixel]);
            let colors = [a, b].map(|picture| picture.color.as_slice()[pixel]);
            if a.image.as_slice()[pixel] != b.image.as_slice()[pixel] {
                found.image += 1.0 / count as f64;
            } else if (depths[0] - depths[1]).abs() > 1e-5 * depths[0].abs() {
                found.depth += 1.0 / count as f64;
            } else {
                let off =
                    (0..3).map(|channel| (colors[0][channel] - colors[1][channel]).abs()).fold(0.0, f32::max);
                found.worst = found.worst.max(off);
                found.color += f64::from(u8::from(off > 1e-3)) / count as f64;
            }
        }
        found
    }

    /// The same shares for `times` as many pixels.
    fn over(&self, times: f64) -> Self {
        Self { image: self.image / times, depth: self.depth / times, color: self.color / times, ..*self }
    }
}

/// Share of pixels that may differ. A shader compiler may contract `a·b + c` and divide with an error of 2.5 units in the last
/// place where the CPU rounds every step: positions move by some 10⁻⁷ of the picture's size, 10⁻⁵ of a pixel here. A sample
/// that stood closer than that to the border of a pixel falls on the other side: one in ten thousand, four borders each, over
/// 8100 pixels; ten times that is let pass.
const DIFFERING: f64 = 1e-3;

/// Colors add the rounding of fixed point, 2⁻²⁹ per sample, over weights of 2⁻¹⁶ and more: where the nearest surface gives a
/// pixel almost nothing its color is uncertain, so that some more may differ. Nor need two cameras that count the same for a
/// block be asked in the same order.
const DIFFERING_COLORS: f64 = 4e-3;

/// How far a color may be off where image and depth are the same, of light that goes up to 0.8. One pixel a sample is no
/// arithmetic: the color is copied. A block's color is a sum in fixed point, each sample rounded by half of 2⁻²⁹, over weights of
/// 2⁻¹⁶ and more: 6·10⁻⁵ a sample, of which some thirty may cover a pixel (2·10⁻⁴ was found on a software adapter). The others move
/// with their positions, by 10⁻⁵ of what a pixel differs from its neighbor, and a few roundings: ten times the 8·10⁻⁶ that were
/// found.
fn worst_color(kernel: Kernel) -> f32 {
    match kernel {
        Kernel::Point => 0.0,
        Kernel::Block => 2e-3,
        Kernel::Surfel | Kernel::Gather => 8e-5,
    }
}

fn agree(found: &Difference) -> bool {
    found.image <= DIFFERING && found.depth <= DIFFERING && found.color <= DIFFERING_COLORS
}

/// Both from places near and far.
fn compare(renderer: &mut GpuRenderer, kernel: Kernel) {
    compare_over(renderer, kernel, &samples(&moving_capture()));
}

fn compare_over(renderer: &mut GpuRenderer, kernel: Kernel, samples: &Arc<SampleSet>) {
    compare_with_borders(renderer, kernel, samples, 1.0);
}

/// The same where `borders` times as many pixels as usual lie at borders of footprints.
fn compare_with_borders(renderer: &mut GpuRenderer, kernel: Kernel, samples: &Arc<SampleSet>, borders: f64) {
    for camera in [novel(), close(), distant()] {
        let (cpu, cpu_stats) = on_cpu(samples, &camera, 2, kernel);
        let (gpu, gpu_stats) = on_gpu(renderer, samples, &camera, 2, kernel);
        let found = Difference::between(&cpu, &gpu);
        assert!(agree(&found.over(borders)), "{kernel} from {}: {found:?}", camera.name);
        assert!(found.worst <= worst_color(kernel), "{kernel} from {}: {found:?}", camera.name);
        assert_eq!(gpu_stats.samples, cpu_stats.samples);
        assert_eq!(gpu_stats.holes, gpu.holes());
        assert!(
            cpu.holes() * 5 < cpu.image.as_slice().len() as u64 * 4,
            "there must be something to compare"
        );
    }
}

#[test]
fn one_pixel_a_sample_is_painted_as_on_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    compare(&mut gpu, Kernel::Point);
}

#[test]
fn blocks_are_painted_and_blended_as_on_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    compare(&mut gpu, Kernel::Block);
}

#[test]
fn surfels_are_painted_and_blended_as_on_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    compare(&mut gpu, Kernel::Surfel);
}

#[test]
fn colors_are_gathered_as_on_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    compare(&mut gpu, Kernel::Gather);
    // Where nothing was pruned, more than one camera is asked.
    compare_over(&mut gpu, Kernel::Gather, &samples_pruned_by(PruningMethod::Off, &moving_capture()));
}

#[test]
fn among_many_cameras_the_same_ones_are_asked_as_on_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&Scene::still_life().record(arc(12, 96), 1));
    for camera in [novel(), close(), distant()] {
        let (cpu, _) = on_cpu(&samples, &camera, 0, Kernel::Gather);
        let (gpu, _) = on_gpu(&mut gpu, &samples, &camera, 0, Kernel::Gather);
        let found = Difference::between(&cpu, &gpu);
        assert!(agree(&found) && found.worst <= worst_color(Kernel::Gather), "{}: {found:?}", camera.name);
    }
}

#[test]
fn close_ups_and_colors_outside_of_the_gamut_are_painted_as_on_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    let mut scene = Scene::still_life();
    scene.ground_light = Some(Arc::new(|_, point| -1.0 - point.x.cos() as f32));
    let samples = samples(&scene.record(arc(3, 96), 1));
    let mut close_up = novel();
    (close_up.intrinsics.fx, close_up.intrinsics.fy) = (900.0, 900.0);
    // Where a footprint is about three pixels wide.
    let mut nearer = novel();
    (nearer.intrinsics.fx, nearer.intrinsics.fy) = (290.0, 290.0);
    for kernel in [Kernel::Block, Kernel::Surfel, Kernel::Gather] {
        for camera in [novel(), nearer.clone(), close_up.clone()] {
            let (cpu, _) = on_cpu(&samples, &camera, 0, kernel);
            let (gpu, _) = on_gpu(&mut gpu, &samples, &camera, 0, kernel);
            let found = Difference::between(&cpu, &gpu);
            assert!(agree(&found) && found.worst <= worst_color(kernel), "{kernel}: {found:?}");
            let darkest = cpu.color.as_slice().iter().flatten().fold(0.0_f32, |darkest, &it| darkest.min(it));
            assert!(darkest < -1.0, "{kernel}: {darkest}");
        }
    }
}

#[test]
fn pictures_of_any_size_and_from_inside_of_things_are_painted_as_on_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&moving_capture());
    let mut cameras = vec![
        camera("behind everything", DVec3::new(0.0, 9.0, 1.0), DVec3::new(0.0, 20.0, 1.0), 24),
        camera("inside a sphere", DVec3::new(0.1, 0.0, 0.5), DVec3::new(1.0, 1.0, 0.5), 40),
        camera("on the ground", DVec3::new(-0.5, -1.5, 0.01), DVec3::new(0.3, 0.2, 0.3), 40),
        Camera { name: "where a camera stood".to_owned(), ..samples.cameras[1].clone() },
    ];
    for (width, height) in [(1, 1), (17, 5), (3, 70)] {
        let mut odd = novel();
        (odd.intrinsics.width, odd.intrinsics.height) = (width, height);
        odd.intrinsics.cx = f64::from(width) / 2.0;
        odd.intrinsics.cy = f64::from(height) / 2.0;
        odd.name = format!("{width}×{height}");
        cameras.push(odd);
    }
    for kernel in Kernel::ALL {
        for camera in &cameras {
            let (cpu, _) = on_cpu(&samples, camera, 1, *kernel);
            let (gpu, _) = on_gpu(&mut gpu, &samples, camera, 1, *kernel);
            let found = Difference::between(&cpu, &gpu);
            // In a picture of few pixels a single one is a large share.
            let pixels = cpu.image.as_slice().len() as f64;
            let few = |share: f64| share * pixels <= (DIFFERING * pixels).max(2.0);
            // Of the four sub-pixels of such a pixel one may show another surface, and light goes up to 0.8.
            let worst = if *kernel == Kernel::Gather { 0.25 * 0.8 } else { worst_color(*kernel) };
            let agrees = few(found.image) && few(found.depth) && few(found.color) && found.worst <= worst;
            assert!(agrees, "{kernel} from {}: {found:?}", camera.name);
        }
    }
}

#[test]
fn what_was_moved_by_a_pixel_does_not_pass_for_the_same_picture() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&moving_capture());
    for kernel in Kernel::ALL {
        let (cpu, _) = on_cpu(&samples, &novel(), 2, *kernel);
        let mut moved = novel();
        moved.intrinsics.cx += 1.0;
        let (gpu, _) = on_gpu(&mut gpu, &samples, &moved, 2, *kernel);
        let found = Difference::between(&cpu, &gpu);
        assert!(!agree(&found) && found.image > DIFFERING && found.depth > DIFFERING, "{kernel}: {found:?}");
    }
}

#[test]
fn the_sky_that_no_camera_has_seen_through_a_surface_is_left_out_as_on_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    // A deep shaft, into which all cameras look from beside it.
    let (z, color) = ([4.0, 8.0], [0.75, 0.125, 0.0625]);
    let blocks = vec![
        block([-0.9, 0.9], [-0.9, -0.25], z, color),
        block([-0.9, 0.9], [0.25, 0.9], z, color),
        block([-0.9, -0.25], [-0.25, 0.25], z, color),
        block([0.25, 0.9], [-0.25, 0.25], z, color),
    ];
    let scene = Blocks { blocks, sky: |_| [0.125, 0.25, 0.75] };
    let cameras = [(-1.2, 0.0), (1.2, 0.0), (0.0, -1.2), (0.0, 1.2)].map(|(x, y)| eye(x, y, 96));
    let samples = samples(&scene.record(&cameras, 1));
    for kernel in [Kernel::Surfel, Kernel::Gather] {
        let vantage = Vantage { camera: eye(0.02, 0.01, 96), frame: 0 };
        let all = RenderSettings { free_space: false, ..settings(kernel) };
        let (all, _) = CpuRenderer::new().render(&samples, &vantage, &all, &Job::new()).unwrap();
        let (cpu, _) = on_cpu(&samples, &vantage.camera, 0, kernel);
        let (gpu, stats) = on_gpu(&mut gpu, &samples, &vantage.camera, 0, kernel);
        assert!(cpu.holes() > all.holes() + 30, "{kernel}: there must be something to find");
        let found = Difference::between(&cpu, &gpu);
        assert!(agree(&found) && found.worst <= worst_color(kernel), "{kernel}: {found:?}");
        assert_eq!(stats.holes, gpu.holes());
    }
}

#[test]
fn what_was_moved_by_a_hundredth_of_a_pixel_does_not_pass_for_the_same_colors() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&moving_capture());
    for kernel in [Kernel::Block, Kernel::Surfel, Kernel::Gather] {
        let (cpu, _) = on_cpu(&samples, &close(), 2, kernel);
        let mut moved = close();
        moved.intrinsics.cx += 0.01;
        let (gpu, _) = on_gpu(&mut gpu, &samples, &moved, 2, kernel);
        let found = Difference::between(&cpu, &gpu);
        assert!(found.worst > worst_color(kernel), "{kernel}: {found:?}");
    }
}

#[test]
fn blending_over_another_depth_does_not_pass_for_the_same_picture() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&moving_capture());
    for kernel in [Kernel::Block, Kernel::Surfel] {
        let (cpu, _) = on_cpu(&samples, &novel(), 2, kernel);
        let vantage = Vantage { camera: novel(), frame: 2 };
        let shallow = RenderSettings { depth_tolerance: 0.1, ..settings(kernel) };
        let (gpu, _) = gpu.render(&samples, &vantage, &shallow, &Job::new()).unwrap();
        let found = Difference::between(&cpu, &gpu);
        assert!(found.image == 0.0 && !agree(&found), "{kernel}: {found:?}");
    }
}

#[test]
fn two_passes_with_narrow_atomics_paint_what_one_pass_with_wide_ones_paints() {
    let Some(mut wide) = gpu() else { return };
    let Some(mut narrow) = gpu_with(&GpuOptions { wide_atomics: false, ..GpuOptions::default() }) else {
        return;
    };
    assert!(!narrow.has_wide_atomics());
    if !wide.has_wide_atomics() {
        skip(None, &format!("nothing was compared: {} has no 64-bit atomics", wide.adapter_name()));
        return;
    }
    let samples = samples(&moving_capture());
    for kernel in Kernel::ALL {
        for camera in [novel(), close()] {
            let paint = |renderer: &mut GpuRenderer| on_gpu(renderer, &samples, &camera, 3, *kernel).0;
            assert_eq!(paint(&mut wide), paint(&mut narrow), "{kernel}");
        }
    }
}

#[test]
fn a_background_from_the_cache_shows_what_a_fresh_one_shows() {
    let Some(mut still) = gpu() else { return };
    let Some(mut fresh) = gpu() else { return };
    let samples = samples(&moving_capture());
    for kernel in Kernel::ALL {
        for frame in 0..4 {
            let (cached, stats) = on_gpu(&mut still, &samples, &novel(), frame, *kernel);
            assert_eq!(stats.background_reused, frame > 0);
            // A vantage elsewhere in between leaves nothing to reuse.
            on_gpu(&mut fresh, &samples, &close(), frame, *kernel);
            let (anew, all) = on_gpu(&mut fresh, &samples, &novel(), frame, *kernel);
            assert!(!all.background_reused && (frame == 0 || stats.samples * 5 < all.samples));
            assert_eq!(cached, anew, "{kernel}, frame {frame}");
        }
    }
}

#[test]
fn images_cut_into_pieces_and_sent_away_in_between_show_the_same() {
    let Some(mut roomy) = gpu() else { return };
    let samples = samples(&moving_capture());
    // Less than all frames together, and pages smaller than the largest backgrounds.
    let bytes = samples.bytes();
    let Some(mut tight) = gpu_with(&GpuOptions { sample_bytes: bytes, ..GpuOptions::default() }) else {
        return;
    };
    for round in 0..2 {
        for frame in 0..5 {
            let paint =
                |renderer: &mut GpuRenderer| on_gpu(renderer, &samples, &novel(), frame, Kernel::Block).0;
            assert_eq!(paint(&mut roomy), paint(&mut tight), "round {round}, frame {frame}");
        }
    }
    assert!(tight.uploaded_bytes() > roomy.uploaded_bytes(), "nothing was sent away");
    let Some(mut tiny) = gpu_with(&GpuOptions { sample_bytes: 1 << 14, ..GpuOptions::default() }) else {
        return;
    };
    let vantage = Vantage { camera: novel(), frame: 0 };
    let error = tiny.render(&samples, &vantage, &settings(Kernel::Block), &Job::new()).unwrap_err();
    assert!(error.to_string().contains("do not fit"), "{error}");
}

#[test]
fn an_image_is_sent_to_the_adapter_once_and_ahead_of_its_frame() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&moving_capture());
    on_gpu(&mut gpu, &samples, &novel(), 0, Kernel::Point);
    let first = gpu.uploaded_bytes();
    gpu.prefetch(&samples, 1..3).unwrap();
    let ahead = gpu.uploaded_bytes();
    assert!(first > 0 && ahead > first);
    on_gpu(&mut gpu, &samples, &close(), 1, Kernel::Block);
    on_gpu(&mut gpu, &samples, &novel(), 2, Kernel::Surfel);
    assert_eq!(gpu.uploaded_bytes(), ahead);
}

#[test]
fn a_picture_that_cannot_be_painted_is_refused_and_the_next_one_is_painted() {
    let Some(mut gpu) = gpu() else { return };
    let samples = samples(&moving_capture());
    let sized = |width, height| {
        let mut camera = novel();
        (camera.intrinsics.width, camera.intrinsics.height) = (width, height);
        Vantage { camera, frame: 0 }
    };
    for vantage in [sized(0, 8), sized(u32::MAX, 9), Vantage { frame: 9, ..sized(8, 8) }] {
        let error = gpu.render(&samples, &vantage, &settings(Kernel::Block), &Job::new()).unwrap_err();
        assert!(matches!(error, overlook_engine::error::Error::Invalid { .. }), "{error}");
    }
    let job = Job::new();
    job.cancel();
    let cancelled = gpu.render(&samples, &sized(8, 8), &settings(Kernel::Block), &job).unwrap_err();
    assert!(matches!(cancelled, overlook_engine::error::Error::Cancelled));
    compare(&mut gpu, Kernel::Block);
}

#[test]
fn doubtful_samples_stand_back_as_on_the_cpu() {
    let Some(mut renderer) = gpu() else { return };
    let capture = moving_capture();
    for method in [PruningMethod::HighestRate, PruningMethod::Off] {
        let mut set = (*samples_pruned_by(method, &capture)).clone();
        let trusted = Arc::new(set.clone());
        for image in &mut set.images {
            let mut some = (**image).clone();
            // Half of each tile of one camera, and some whole tiles of the others.
            let columns = |tile: usize| match some.camera {
                0 => 0x00ff,
                camera if (tile + camera as usize).is_multiple_of(3) => 0xffff,
                _ => 0,
            };
            let masks = some.tiles.iter().enumerate().map(|(tile, found)| TileMask {
                tile: tile as u32,
                rows: found.rows.map(|row| row & columns(tile)),
            });
            some.doubtful = masks.filter(|mask| mask.rows != [0; TILE]).collect();
            *image = Arc::new(some);
        }
        let set = Arc::new(set);
        for kernel in Kernel::ALL {
            // Trusted samples end where doubtful ones begin: borders within surfaces beside those of surfaces.
            compare_with_borders(&mut renderer, *kernel, &set, 2.0);
            let [with, without] = [&set, &trusted].map(|set| on_cpu(set, &novel(), 2, *kernel).0);
            assert!(with.inverse_depth != without.inverse_depth, "{kernel}: they change the picture");
        }
    }
}
