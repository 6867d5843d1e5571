//! A thousand random captures, the same in every run: cameras of odd sizes beside, behind, inside and far from things and
//! each other, exact and half-float depth, clean and noisy color, given and estimated normals.

mod coverage;
mod scene;

use std::sync::Arc;

use coverage::assert_covered;
use glam::DVec3;
use overlook::capture::{Camera, Intrinsics};
use overlook::job::Job;
use overlook::preprocess::{inspect_frame, preprocess, scan};
use overlook::settings::{MixedPixels, PruningMethod, RateModel, Settings, SpanLevels};
use rayon::prelude::*;
use scene::draws::Draws;
use scene::{Scene, Sphere, arc};

const CAPTURES: u64 = 1000;

impl Draws {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.below(1 << 53) as f64 / (1_u64 << 53) as f64
    }

    fn chance(&mut self, share: f64) -> bool {
        self.between(0.0, 1.0) < share
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }

    fn point(&mut self, reach: f64) -> DVec3 {
        DVec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }
}

fn any_camera(draws: &mut Draws, before: &[Camera]) -> Camera {
    let lens = Intrinsics::from_horizontal_angle(
        1 + draws.below(23) as u32,
        1 + draws.below(23) as u32,
        draws.between(0.2, 2.2),
    );
    let placed = |eye, target| Camera::look_at("any", lens, eye, target, DVec3::Z);
    match draws.below(8) {
        // The same camera once more, or another lens in its place.
        0 if !before.is_empty() => {
            let twin = before[draws.below(before.len() as u64) as usize].clone();
            if draws.chance(0.5) { twin } else { Camera { intrinsics: lens, ..twin } }
        }
        // Right behind another camera, looking the same way.
        1 if !before.is_empty() => {
            let other = &before[draws.below(before.len() as u64) as usize];
            let (eye, ahead) = (other.position_in_world(), other.forward_in_world());
            placed(eye - ahead * draws.between(0.1, 3.0), eye + ahead)
        }
        // Inside the first sphere, or on its surface.
        2 => {
            let direction = draws.point(1.0).normalize_or(DVec3::X);
            let target = draws.point(2.0);
            placed(DVec3::new(0.0, 0.0, 0.6) + direction * 0.6 * draws.of(&[0.0, 0.5, 1.0]), target)
        }
        // So far away that everything is a pixel.
        3 => placed(draws.point(1.0).normalize_or(DVec3::X) * 1e5, DVec3::ZERO),
        // Below the ground, or in it.
        4 => {
            let target = draws.point(1.0);
            placed(
                DVec3::new(draws.between(-3.0, 3.0), draws.between(-3.0, 3.0), draws.of(&[0.0, -1.0])),
                target,
            )
        }
        // Where a person would put one.
        5 => {
            let place = draws.below(4) as usize;
            arc(4, 1 + draws.below(23) as u32).remove(place)
        }
        _ => {
            let target = draws.point(1.0);
            placed(draws.point(6.0), target)
        }
    }
}

fn any_scene(draws: &mut Draws) -> Scene {
    let speed = draws.between(0.0, 1.0);
    let moving = Sphere {
        center: Arc::new(move |frame| Some(DVec3::new(-1.5 + speed * frame as f64, -0.5, 0.5))),
        radius: draws.between(0.01, 1.0),
        color: [0.6, 0.6, 0.1],
    };
    let mut scene = Scene {
        color_noise: draws.of(&[0.0, 0.02, 0.2]),
        half_depth: draws.chance(0.5),
        normals: draws.chance(0.5),
        color_rays: draws.of(&[1, 1, 3]),
        ..Scene::still_life()
    };
    scene.ground = draws.chance(0.8);
    scene.spheres.push(moving);
    scene
}

fn any_settings(draws: &mut Draws) -> Settings {
    let mut settings = Settings::default();
    settings.spans.levels = draws.of(SpanLevels::ALL);
    settings.spans.noise = draws.of(&[0.0, 1.0]);
    let pruning = &mut settings.pruning;
    pruning.method = draws.of(PruningMethod::ALL);
    pruning.rate = draws.of(RateModel::ALL);
    pruning.mixed_pixels = draws.of(&[MixedPixels::Keep, MixedPixels::Yield, MixedPixels::Drop]);
    pruning.depth_tolerance = draws.between(0.05, 16.0) as f32;
    pruning.normal_tolerance = draws.between(1.0, 90.0) as f32;
    pruning.color_tolerance = draws.between(1.0, 255.0) as f32;
    pruning.cosine_floor = draws.between(0.01, 1.0) as f32;
    pruning.across_spans = draws.chance(0.5);
    pruning.overlap = draws.chance(0.5);
    settings
}

#[test]
fn a_thousand_random_captures_neither_panic_nor_lose_a_surface_point() {
    let (dropped, beyond) = (0..CAPTURES)
        .into_par_iter()
        .map(|seed| {
            let draws = &mut Draws(seed);
            let (scene, settings) = (any_scene(draws), any_settings(draws));
            let mut cameras = Vec::new();
            for _ in 0..=draws.below(6) {
                cameras.push(any_camera(draws, &cameras));
            }
            let frames = 1 + draws.below(3) as usize;
            let capture = scene.record(cameras, frames);
            let job = Job::new();
            let scan = scan(&capture, &settings, &job).unwrap();
            let frame = draws.below(frames as u64) as usize;
            let inspection = inspect_frame(&capture, Some(&scan), &settings, frame, &job).unwrap();
            let beyond = assert_covered(&scene, &capture, &inspection, &settings);
            let report = preprocess(&capture, &settings, &job).unwrap().report;
            let pruned: u64 = report.pruned.values().sum();
            let invalid: u64 = report.cameras.iter().map(|camera| camera.invalid).sum();
            assert_eq!(report.samples_in, report.samples_kept + pruned + invalid, "capture {seed}");
            let verdicts = inspection.cameras.iter().flat_map(|camera| camera.verdict.as_slice());
            (verdicts.filter(|verdict| !verdict.is_kept()).count(), beyond)
        })
        .reduce(|| (0, 0), |(a, b), (c, d)| (a + c, b + d));
    assert!(dropped > 50_000, "{dropped}");
    // Where an estimated normal is wrong: 2 of 65,122 here, and 18 in six times as many captures.
    assert!(beyond * 10_000 < dropped, "{beyond} of {dropped}");
}
