//! How well the renderer reconstructs: zoomed in, zoomed out, between samples, and with samples pruned.

use std::sync::Arc;

use crate::scene::{Scene, arc, camera, ground_color};
use glam::{DVec2, DVec3};
use overlook_engine::capture::{Camera, Capture, Intrinsics, Projection};
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::render::{CpuRenderer, NO_IMAGE, Picture, Renderer, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{
    Antialias, Backend, Coarse, Kernel, PruningMethod, RenderSettings, Settings,
};

fn samples(capture: &Capture, method: PruningMethod) -> Arc<SampleSet> {
    let mut settings = Settings::default();
    settings.pruning.method = method;
    preprocess(capture, &settings, &Job::new()).unwrap().samples
}

fn paint(samples: &Arc<SampleSet>, camera: &Camera, kernel: Kernel) -> Arc<Picture> {
    let settings = RenderSettings { kernel, ..RenderSettings::default() };
    let vantage = Vantage { camera: camera.clone(), frame: 0 };
    CpuRenderer::new().render(samples, &vantage, &settings, &Job::new()).unwrap().0
}

/// A ground under cameras that look down on it; nothing else.
fn ground() -> Scene {
    Scene { spheres: Vec::new(), ..Scene::still_life() }
}

/// The same view with `zoom` times the focal length, in as many pixels.
fn zoomed(camera: &Camera, zoom: f64) -> Camera {
    let k = camera.intrinsics;
    let intrinsics = Intrinsics { fx: k.fx * zoom, fy: k.fy * zoom, ..k };
    Camera { intrinsics, ..camera.clone() }
}

/// Largest difference to the ground's true color over the pixels that show something, and how many show nothing.
fn worst_error(picture: &Picture, vantage: &Camera) -> (f32, usize) {
    let (mut worst, mut holes) = (0.0_f32, 0);
    for y in 0..picture.color.height() {
        for x in 0..picture.color.width() {
            if picture.image[(x, y)] == NO_IMAGE {
                holes += 1;
                continue;
            }
            let ray = vantage.unproject(DVec2::new(x as f64 + 0.5, y as f64 + 0.5), 1.0);
            let eye = vantage.position_in_world();
            let point = eye + (ray - eye) * (eye.z / (eye.z - ray.z));
            let truth = ground_color(point);
            for channel in 0..3 {
                worst = worst.max((picture.color[(x, y)][channel] - truth[channel]).abs());
            }
        }
    }
    (worst, holes)
}

#[test]
fn a_sampled_surface_has_no_crack_at_four_times_the_magnification() {
    let eyes = [DVec3::new(0.3, -2.0, 3.0), DVec3::new(-0.8, -1.6, 2.6)];
    let cameras = eyes.iter().enumerate().map(|(i, eye)| camera(&format!("c{i}"), *eye, DVec3::ZERO, 96));
    let capture = ground().record(cameras.collect(), 1);
    let near = camera("near", DVec3::new(0.0, -1.8, 2.8), DVec3::ZERO, 96);
    let vantage = zoomed(&near, 4.0);
    for method in [PruningMethod::Off, PruningMethod::HighestRate] {
        let samples = samples(&capture, method);
        for kernel in [Kernel::Surfel, Kernel::Gather] {
            let (error, holes) = worst_error(&paint(&samples, &vantage, kernel), &vantage);
            assert_eq!(holes, 0, "{kernel} after {method}");
            assert!(error < 0.02, "{kernel} after {method}: {error}");
        }
        // The comparison can fail: points alone leave the gaps that footprints close.
        assert!(paint(&samples, &vantage, Kernel::Point).holes() > 1000);
    }
}

/// A camera straight above the ground, with a picture of the given size.
fn above(name: &str, x: f64, (width, height): (u32, u32)) -> Camera {
    let (cx, cy) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
    let intrinsics =
        Intrinsics { width, height, fx: 150.0, fy: 150.0, cx, cy, projection: Projection::Perspective };
    Camera::look_at(name, intrinsics, DVec3::new(x, -0.01, 5.0), DVec3::new(x, 0.0, 0.0), DVec3::Z)
}

#[test]
fn no_gap_opens_in_a_close_up_where_one_camera_s_samples_give_way_to_another_s() {
    // Both sample the ground alike, so that each is the better one here and there.
    let cameras = vec![above("a", 0.0, (160, 120)), above("b", 0.25, (120, 90))];
    let capture = ground().record(cameras.clone(), 1);
    let samples = samples(&capture, PruningMethod::HighestRate);
    let recorded = cameras.iter().map(|camera| camera.intrinsics.pixel_count()).sum::<usize>();
    assert!(samples.sample_count() < recorded as u64, "nothing gave way");
    for zoom in [4.0, 6.0, 8.0] {
        let vantage = zoomed(&cameras[0], zoom);
        let (error, holes) = worst_error(&paint(&samples, &vantage, Kernel::Gather), &vantage);
        assert_eq!(holes, 0, "at {zoom} times");
        assert!(error < 0.02, "at {zoom} times: {error}");
    }
}

#[test]
fn a_close_up_is_as_smooth_as_what_was_recorded() {
    let camera = above("a", 0.0, (96, 72));
    let capture = ground().record(vec![camera.clone()], 1);
    let samples = samples(&capture, PruningMethod::HighestRate);
    let largest_step = |picture: &Picture| {
        let (width, height) = (picture.color.width(), picture.color.height());
        let at = (0..height).flat_map(|y| (1..width).map(move |x| (x, y)));
        let step = |(x, y)| (picture.color[(x, y)][0] - picture.color[(x - 1, y)][0]).abs();
        at.map(step).fold(0.0_f32, f32::max)
    };
    let recorded = largest_step(&paint(&samples, &camera, Kernel::Gather));
    for zoom in [2.0, 4.0, 8.0, 16.0] {
        let step = largest_step(&paint(&samples, &zoomed(&camera, f64::from(zoom)), Kernel::Gather));
        assert!(step < 1.5 * recorded / zoom, "at {zoom} times: {step}, recorded {recorded}");
    }
}

#[test]
fn fine_detail_does_not_alias_at_four_times_the_minification() {
    // A checker of single camera pixels, whose mean is the only right answer for pixels four times as large.
    let mut scene = ground();
    scene.ground_light = Some(Arc::new(|_, point| {
        let cell = |value: f64| (value * 40.0).floor() as i64;
        if (cell(point.x) + cell(point.y)) % 2 == 0 { 0.2 } else { -0.2 }
    }));
    let above = camera("above", DVec3::new(0.0, -0.01, 3.0), DVec3::ZERO, 256);
    let capture = scene.record(vec![above.clone()], 1);
    let samples = samples(&capture, PruningMethod::HighestRate);
    let k = above.intrinsics;
    let intrinsics = Intrinsics {
        fy: k.fy / 4.0,
        cx: k.cx / 4.0 + 0.3,
        cy: k.cy / 4.0 + 0.2,
        ..Intrinsics::centered(64, 64, k.fx / 4.0)
    };
    let vantage = Camera { intrinsics, ..above };
    let spread = |kernel| {
        let picture = paint(&samples, &vantage, kernel);
        let errors = (8..56).flat_map(|y| (8..56).map(move |x| (x, y))).map(|(x, y)| {
            let ray = vantage.unproject(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), 1.0);
            let eye = vantage.position_in_world();
            let truth = ground_color(eye + (ray - eye) * (eye.z / (eye.z - ray.z)));
            (picture.color[(x as usize, y as usize)][0] - truth[0]).powi(2)
        });
        (errors.sum::<f32>() / (48.0 * 48.0)).sqrt()
    };
    // One sample for sixteen: the checker's full contrast, 0.2, comes through.
    assert!(spread(Kernel::Point) > 0.1, "{}", spread(Kernel::Point));
    for kernel in [Kernel::Block, Kernel::Surfel, Kernel::Gather] {
        assert!(spread(kernel) < 0.06, "{kernel}: {}", spread(kernel));
    }
}

/// The same view in fewer pixels.
fn coarser(camera: &Camera, times: u32) -> Camera {
    let (k, share) = (camera.intrinsics, 1.0 / f64::from(times));
    let (width, height) = (k.width / times, k.height / times);
    let [fx, fy, cx, cy] = [k.fx, k.fy, k.cx, k.cy].map(|length| length * share);
    Camera {
        intrinsics: Intrinsics { width, height, fx, fy, cx, cy, projection: Projection::Perspective },
        ..camera.clone()
    }
}

#[test]
fn a_coarse_picture_shows_what_a_fine_one_averages_to_on_slopes_and_at_edges() {
    let mut scene = Scene::still_life();
    scene.ground_light =
        Some(Arc::new(|_, point| 0.2 * ((point.x * 23.0).sin() * (point.y * 19.0).sin()) as f32));
    let capture = scene.record(arc(5, 192), 1);
    let fine = camera("novel", DVec3::new(0.4, -4.4, 1.2), DVec3::new(0.3, 0.2, 0.3), 192);
    // More is kept than by default: how finely edges are looked for then matters little, and averaging is seen by itself.
    let mut settings = Settings::default();
    settings.pruning.color_tolerance = 24.0;
    let samples = preprocess(&capture, &settings, &Job::new()).unwrap().samples;
    for kernel in [Kernel::Gather, Kernel::Surfel] {
        let settings = RenderSettings { kernel, backend: Backend::Cpu, ..RenderSettings::default() };
        let render = |camera: &Camera, settings: &RenderSettings| {
            let vantage = Vantage { camera: camera.clone(), frame: 0 };
            Renderer::new().render(&samples, &vantage, settings, &Job::new()).unwrap().0
        };
        let whole = render(&fine, &settings);
        for times in [2, 4, 8] {
            let decibel = |antialias, coarse| {
                let settings = RenderSettings { antialias, coarse, ..settings.clone() };
                off_the_mean(&render(&coarser(&fine, times), &settings), &whole, times as usize)
            };
            let (off, on) =
                (decibel(Antialias::Off, Coarse::Average), decibel(Antialias::Silhouettes, Coarse::Average));
            let pyramid = decibel(Antialias::Silhouettes, Coarse::Pyramid);
            println!("{kernel}, {times}: {off:.1} dB, averaged {on:.1} dB, from a pyramid {pyramid:.1} dB");
            assert!(on > 34.0 && on > off + 3.0, "{kernel}, {times}: {off:.1} dB, averaged {on:.1} dB");
            // Surfels are as coarse as their samples, so that only time is gained.
            assert!(
                pyramid > off + 1.0 || kernel == Kernel::Surfel && pyramid > 25.0,
                "{kernel}, {times}: {off:.1} dB, from a pyramid {pyramid:.1} dB"
            );
        }
    }
}

#[test]
fn a_picture_from_a_pyramid_touches_what_it_shows_and_one_as_fine_as_the_recording_stays_bit_for_bit() {
    let capture = Scene::still_life().record(arc(5, 192), 1);
    let fine = camera("novel", DVec3::new(0.4, -4.4, 1.2), DVec3::new(0.3, 0.2, 0.3), 192);
    let samples = samples(&capture, PruningMethod::HighestRate);
    let render = |camera: &Camera, coarse| {
        let settings = RenderSettings { coarse, backend: Backend::Cpu, ..RenderSettings::default() };
        let vantage = Vantage { camera: camera.clone(), frame: 0 };
        Renderer::new().render(&samples, &vantage, &settings, &Job::new()).unwrap()
    };
    let [(whole, all), (same, _)] = [Coarse::Average, Coarse::Pyramid].map(|coarse| render(&fine, coarse));
    assert!(whole == same, "nothing is coarser there than the recording");
    // Here three quarters of a picture half as large have less than 1.75 recorded pixels to one of theirs.
    for (times, most) in [(2, 1.0), (4, 0.4), (8, 0.12), (16, 0.04)] {
        let (_, touched) = render(&coarser(&fine, times), Coarse::Pyramid);
        let share = touched.samples as f64 / all.samples as f64;
        assert!(share <= most, "{times} times as coarse: {share} of the samples");
    }
}

/// PSNR of a picture against the means of `times` × `times` pixels of a finer one, dB; only pixels whose fine pixels all show something
/// count.
fn off_the_mean(coarse: &Picture, fine: &Picture, times: usize) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for y in 0..coarse.color.height() {
        for x in 0..coarse.color.width() {
            let parts = || (0..times * times).map(|nth| (x * times + nth % times, y * times + nth / times));
            if coarse.image[(x, y)] == NO_IMAGE || parts().any(|at| fine.image[at] == NO_IMAGE) {
                continue;
            }
            for channel in 0..3 {
                let mean = parts().map(|at| fine.color[at][channel]).sum::<f32>() / (times * times) as f32;
                sum += f64::from(coarse.color[(x, y)][channel] - mean).powi(2);
                count += 1.0;
            }
        }
    }
    -10.0 * (sum / count).log10()
}

/// Mean squared error over the pixels that both pictures of a kernel show.
fn error(picture: &Picture, scene: &Scene, vantage: &Camera) -> f64 {
    let truth = scene.trace(vantage, 0, 9);
    let (mut sum, mut count) = (0.0, 0);
    for (pixel, truth) in truth.color.as_slice().iter().enumerate() {
        if picture.image.as_slice()[pixel] != NO_IMAGE {
            let found = picture.color.as_slice()[pixel];
            sum += (0..3)
                .map(|channel| f64::from(found[channel] - truth[channel].to_f32()).powi(2))
                .sum::<f64>();
            count += 1;
        }
    }
    sum / f64::from(count)
}

#[test]
fn gathering_is_closer_to_the_truth_than_blending_blocks_before_and_after_pruning() {
    let mut scene = Scene::still_life();
    scene.ground_light =
        Some(Arc::new(|_, point| 0.15 * ((point.x * 14.0).sin() * (point.y * 14.0).sin()) as f32));
    let capture = scene.record(arc(5, 128), 1);
    let vantage = camera("novel", DVec3::new(0.4, -4.4, 2.5), DVec3::new(0.3, 0.2, 0.3), 128);
    let of = |method, kernel| error(&paint(&samples(&capture, method), &vantage, kernel), &scene, &vantage);
    let decibel = |a: f64, b: f64| 10.0 * (a / b).log10();
    for method in [PruningMethod::Off, PruningMethod::HighestRate] {
        let gain = decibel(of(method, Kernel::Block), of(method, Kernel::Gather));
        assert!(gain > 0.8, "{method}: {gain:.2} dB");
    }
    let loss =
        decibel(of(PruningMethod::HighestRate, Kernel::Gather), of(PruningMethod::Off, Kernel::Gather));
    assert!(loss < 1.0, "pruning costs {loss:.2} dB");
}

#[test]
fn a_silhouette_lies_where_it_is_and_neither_grows_nor_shrinks_with_more_cameras() {
    let scene = Scene::still_life();
    let vantage = camera("novel", DVec3::new(0.4, -4.4, 2.5), DVec3::new(0.3, 0.2, 0.3), 96);
    let truth = scene.trace(&vantage, 0, 9);
    // Pixels whose inverse depth is the nearer sphere's although the ground or the sky is seen there, and the reverse.
    let shown = |cameras, kernel| {
        let capture = scene.record(arc(cameras, 96), 1);
        let picture = paint(&samples(&capture, PruningMethod::Off), &vantage, kernel);
        let pairs = picture.inverse_depth.as_slice().iter().zip(truth.inverse_depth.as_slice());
        let (mut grown, mut shrunk) = (0_i32, 0_i32);
        // Up to 20 m: towards the horizon the ground's own depth changes by as much from pixel to pixel.
        for (found, truth) in pairs.filter(|(_, truth)| **truth > 0.05) {
            grown += i32::from(*found > truth * 1.05);
            shrunk += i32::from(*found < truth * 0.95 && *found >= 0.0);
        }
        (grown, shrunk)
    };
    for cameras in [5, 16] {
        let (grown, shrunk) = shown(cameras, Kernel::Gather);
        let (block_grown, _) = shown(cameras, Kernel::Block);
        assert!(10 * grown < block_grown, "{cameras} cameras: gather {grown}, block {block_grown}");
        // Measured: 12 and 17 of five, 28 and 7 of sixteen, of some 300 pixels beside silhouettes, each of which may fall to either side.
        let (all, shift) = (grown + shrunk, (grown - shrunk).abs());
        assert!(all <= 45 && shift <= 30, "{cameras} cameras: {grown} grown, {shrunk} shrunk");
    }
}

#[test]
fn colors_outside_of_the_gamut_are_kept_by_every_kernel() {
    let mut scene = ground();
    scene.ground_light = Some(Arc::new(|_, _| -3.0));
    let camera = above("a", 0.0, (96, 72));
    let samples = samples(&scene.record(vec![camera.clone()], 1), PruningMethod::HighestRate);
    for &kernel in Kernel::ALL {
        let picture = paint(&samples, &camera, kernel);
        let middle = picture.color[(48, 36)];
        assert!(middle.iter().all(|channel| (-3.0..-2.0).contains(channel)), "{kernel}: {middle:?}");
    }
}

#[test]
fn silhouettes_that_show_both_sides_are_a_tenth_nearer_to_the_truth_than_those_that_show_one() {
    let scene = Scene { color_rays: 4, ..Scene::still_life() };
    let capture = scene.record(arc(5, 96), 1);
    let vantage = camera("between", DVec3::new(0.35, -4.9, 2.5), DVec3::new(0.3, 0.2, 0.3), 96);
    let truth = scene.record(vec![vantage.clone()], 1).frame(0, 0).unwrap();
    // Pixels beside a step in the truth's depth.
    let beside_step = |x: usize, y: usize| {
        let depths = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|at| truth.inverse_depth[at]);
        let (near, far) = depths.iter().fold((0.0_f32, f32::INFINITY), |(a, b), w| (a.max(*w), b.min(*w)));
        far < 0.9 * near
    };
    let error = |method, antialias| {
        let settings = RenderSettings { antialias, ..RenderSettings::default() };
        let seen = Vantage { camera: vantage.clone(), frame: 0 };
        let samples = samples(&capture, method);
        let picture = CpuRenderer::new().render(&samples, &seen, &settings, &Job::new()).unwrap().0;
        let (mut sum, mut count) = (0.0_f32, 0);
        for y in 0..95 {
            for x in (0..95).filter(|x| beside_step(*x, y)) {
                for channel in 0..3 {
                    let off = picture.color[(x, y)][channel] - truth.color[(x, y)][channel].to_f32();
                    sum += off * off;
                }
                count += 1;
            }
        }
        assert!(count > 100, "{count} pixels at edges");
        sum / count as f32
    };
    for method in [PruningMethod::Off, PruningMethod::HighestRate] {
        let [averaged, blended, decided] =
            [Antialias::Supersampled, Antialias::Silhouettes, Antialias::Off].map(|step| error(method, step));
        // Where a silhouette lies is known to a pixel of the cameras, and what is off by that stays.
        assert!(blended < 0.9 * decided, "after {method}: {blended} instead of {decided}");
        assert!(averaged < 0.9 * decided, "after {method}: {averaged} instead of {decided}");
    }
}
