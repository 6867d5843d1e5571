//! What is right is left alone, whatever it shows; and what is found to be wrong is wrong by as much as is said.

use glam::{DAffine3, DQuat, DVec3};
use overlook_engine::alignment::{Aligned, Alignment, align};
use overlook_engine::capture::conventions::{Evidence, check};
use overlook_engine::capture::{Camera, Capture};
use overlook_engine::job::Job;
use overlook_engine::settings::{AlignSettings, Correction};

use crate::draws::Draws;
use crate::exact_scenes::{ExactScene, between, color_camera, misplaced};

fn aligned(capture: &Capture) -> Aligned {
    align(capture, &AlignSettings::default(), &Job::new()).unwrap()
}

/// What pictures would have otherwise of a capture that is read as it is meant.
fn accused_by_pictures(capture: &Capture) -> Option<String> {
    let reading = check(capture).unwrap();
    let is_by_pictures = matches!(reading.alternative()?.evidence, Evidence::Pictures { .. });
    is_by_pictures.then(|| reading.sentence())
}

/// The corrections that are made of exact scenes, and the units and lenses that pictures would have otherwise.
fn harm(seeds: std::ops::Range<u64>) -> Vec<String> {
    let of_seed = |seed: u64| {
        let scene = ExactScene::random(seed, seed % 2 == 1);
        let capture = scene.record(scene.cameras.clone());
        let found = aligned(&capture);
        if found.alignment.is_none() {
            assert_eq!(found.capture.cameras, capture.cameras);
        }
        if let Some(alignment) = found.alignment {
            return Some(format!("scene {seed}: {:?} {:?}", alignment.sentences(), alignment.refusals()));
        }
        accused_by_pictures(&capture).map(|said| format!("scene {seed}: {said}"))
    };
    seeds.filter_map(of_seed).collect()
}

#[test]
fn exact_scenes_are_left_alone_whatever_they_show() {
    let harm = harm(0..16);
    assert!(harm.is_empty(), "{harm:#?}");
}

#[test]
fn scenes_that_are_exact_by_their_depth_are_left_alone_under_a_light_that_moves_with_the_cameras() {
    for seed in 0..24 {
        let mut scene = ExactScene::random(seed, false).under_a_headlight();
        scene.is_rendered = None;
        let capture = scene.record(scene.cameras.clone());
        let corrected = aligned(&capture).alignment.map(|found| found.sentences()).unwrap_or_default();
        assert!(corrected.is_empty(), "scene {seed}: {corrected:?}");
        assert_eq!(accused_by_pictures(&capture), None, "scene {seed}");
    }
}

#[test]
fn points_of_one_size_in_all_pictures_are_left_alone_though_they_lie_elsewhere_for_each_camera() {
    for seed in 0..8 {
        let mut scene = ExactScene::random(seed, false).of_points(seed);
        for is_rendered in [Some(true), None] {
            scene.is_rendered = is_rendered;
            let corrected = aligned(&scene.record(scene.cameras.clone())).alignment;
            let corrected = corrected.map(|found| found.sentences()).unwrap_or_default();
            assert!(corrected.is_empty(), "scene {seed}: {corrected:?}");
        }
    }
}

#[test]
#[ignore = "takes a minute"]
fn two_hundred_exact_scenes_are_left_alone() {
    let harm = harm(0..200);
    assert!(harm.is_empty(), "{} of 200: {harm:#?}", harm.len());
}

#[test]
fn exposures_of_what_a_program_rendered_are_measured_and_corrected_where_one_asks() {
    let mut scene = ExactScene::random(2, false);
    scene.stops[1] = 0.4;
    let with = |is_rendered: Option<bool>, exposure: Correction| {
        let mut scene = scene.clone();
        scene.is_rendered = is_rendered;
        let settings = AlignSettings { exposure, ..AlignSettings::default() };
        align(&scene.record(scene.cameras.clone()), &settings, &Job::new()).unwrap().alignment.unwrap()
    };
    let is_corrected = |found: &Alignment| found.cameras.iter().any(|camera| camera.exposure.is_some());
    // By its word, and by its depth.
    for is_rendered in [Some(true), None] {
        let found = with(is_rendered, Correction::Auto);
        assert!(!is_corrected(&found), "{:?}", found.sentences());
        assert!(found.measured.iter().any(|line| line.starts_with("c1: red -0.")), "{:?}", found.measured);
        assert!(is_corrected(&with(is_rendered, Correction::On)));
    }
    assert!(is_corrected(&with(Some(false), Correction::Auto)));
}

#[test]
fn a_pose_that_is_wrong_beyond_doubt_is_corrected_of_what_a_program_rendered_too() {
    for seed in [1, 3, 7, 9] {
        let mut scene = ExactScene::random(seed, false);
        scene.is_rendered = Some(true);
        let mut claimed = scene.cameras.clone();
        claimed[1] = misplaced(&claimed[1], &mut Draws(7), 1.0, 0.03);
        let found = aligned(&scene.record(claimed)).alignment.unwrap();
        for (index, camera) in found.cameras.iter().enumerate() {
            let degrees = camera.pose.map(|pose| pose.degrees);
            let is_right = degrees.map_or(index != 1, |degrees| index == 1 && (degrees - 1.0).abs() < 0.05);
            assert!(is_right, "scene {seed}, camera {index}: {degrees:?}");
        }
    }
}

#[test]
fn depth_of_a_sensor_is_not_taken_for_what_a_program_rendered() {
    let mut scene = ExactScene::random(3, true);
    scene.stops[1] = 0.4;
    scene.is_rendered = None;
    let found = aligned(&scene.record(scene.cameras.clone())).alignment.unwrap();
    assert!(found.measured.is_empty(), "{:?}", found.measured);
}

/// A stated number that ought to be another one.
#[derive(Debug)]
struct Stated {
    what: String,
    off: f64,
    standard_error: f64,
}

fn pose_planted(seed: u64) -> Vec<Stated> {
    let scene = ExactScene::random(seed, seed % 2 == 1);
    // Of two cameras nobody knows which one is wrong.
    if scene.cameras.len() < 3 {
        return Vec::new();
    }
    let mut draws = Draws(seed ^ 0x5bd1_e995);
    let wrong = draws.below(scene.cameras.len() as u64) as usize;
    let (degrees, distance) = (between(&mut draws, 0.1, 1.5), between(&mut draws, 0.0, 0.05));
    let mut claimed = scene.cameras.clone();
    claimed[wrong] = misplaced(&claimed[wrong], &mut draws, degrees, distance);
    let found = aligned(&scene.record(claimed.clone()));
    let cameras = found.alignment.map_or_else(Vec::new, |alignment| alignment.cameras);
    let mut stated = Vec::new();
    for (index, camera) in cameras.iter().enumerate() {
        let (degrees, distance) = if index == wrong { (degrees, distance) } else { (0.0, 0.0) };
        let what = |what: &str| {
            format!("{what} of camera {index} of {}, {wrong} is wrong, scene {seed}", cameras.len())
        };
        if let Some(pose) = &camera.pose {
            stated.push(Stated {
                what: what("angle"),
                off: pose.degrees - degrees,
                standard_error: pose.degrees_se,
            });
            let off = pose.distance - distance;
            stated.push(Stated { what: what("distance"), off, standard_error: pose.distance_se });
        }
        if let Some(exposure) = &camera.exposure {
            for channel in 0..3 {
                let off = exposure.stops[channel];
                stated.push(Stated { what: what("stops"), off, standard_error: exposure.stops_se[channel] });
            }
        }
    }
    stated
}

fn exposure_planted(seed: u64) -> Vec<Stated> {
    let mut scene = ExactScene::random(seed, seed % 2 == 1);
    let mut draws = Draws(seed ^ 0x5bd1_e995);
    scene.stops = scene.cameras.iter().map(|_| between(&mut draws, -0.3, 0.3)).collect();
    let found = aligned(&scene.record(scene.cameras.clone()));
    let (cameras, pairs) =
        found.alignment.map_or_else(Default::default, |found| (found.cameras, found.pairs));
    let mut stated = Vec::new();
    for (index, camera) in cameras.iter().enumerate() {
        let what = |what: &str| format!("{what} of camera {index} of {}, scene {seed}", cameras.len());
        if let Some(pose) = &camera.pose {
            stated.push(Stated { what: what("angle"), off: pose.degrees, standard_error: pose.degrees_se });
        }
    }
    // Only ratios are known, of cameras that see the same.
    for pair in pairs {
        let of = |index: usize| cameras[index].exposure.map(|found| (found, scene.stops[index]));
        let (Some((own, own_stops)), Some((other, other_stops))) = (of(pair.source), of(pair.target)) else {
            continue;
        };
        for channel in 0..3 {
            let off = own.stops[channel] - other.stops[channel] + own_stops - other_stops;
            let standard_error = own.stops_se[channel].hypot(other.stops_se[channel]);
            let what = format!("stops of cameras {} and {}, scene {seed}", pair.source, pair.target);
            stated.push(Stated { what, off, standard_error });
        }
    }
    stated
}

fn lens_planted(seed: u64) -> Vec<Stated> {
    let mut scene = ExactScene::random(seed, seed % 2 == 1);
    let mut draws = Draws(seed ^ 0x5bd1_e995);
    let ratio = between(&mut draws, 0.88, 1.12);
    let mut part = |most: f64| between(&mut draws, -most, most);
    let turn = DVec3::new(part(0.006), part(0.006), part(0.006));
    let shift = DVec3::new(part(0.04), part(0.01), part(0.01));
    let color_from_depth = DAffine3::from_rotation_translation(DQuat::from_scaled_axis(turn), shift);
    let color: Vec<Camera> =
        scene.cameras.iter().map(|camera| color_camera(camera, ratio, color_from_depth)).collect();
    let focal = color[0].intrinsics.fx;
    scene.color_cameras = Some(color);
    let found = aligned(&scene.record(scene.cameras.clone()));
    let Some(alignment) = found.alignment else { return Vec::new() };
    let what = |what: &str| format!("{what} of {} cameras, scene {seed}", scene.cameras.len());
    let mut stated = Vec::new();
    for lens in &alignment.lenses {
        stated.push(Stated {
            what: what("focal"),
            off: lens.color.fx - focal,
            standard_error: lens.focal_se,
        });
        if let (Some(degrees_se), Some(distance_se)) = (lens.degrees_se, lens.distance_se) {
            let degrees = turn.length().to_degrees();
            stated.push(Stated {
                what: what("lens angle"),
                off: lens.degrees - degrees,
                standard_error: degrees_se,
            });
            let off = lens.distance - shift.length();
            stated.push(Stated { what: what("lens distance"), off, standard_error: distance_se });
        }
    }
    for (index, camera) in alignment.cameras.iter().enumerate() {
        if let Some(pose) = &camera.pose {
            let (what, off) = (what(&format!("camera {index}, angle")), pose.degrees);
            stated.push(Stated { what, off, standard_error: pose.degrees_se });
        }
        for (stops, standard_error) in
            camera.exposure.iter().flat_map(|exposure| exposure.stops.into_iter().zip(exposure.stops_se))
        {
            stated.push(Stated { what: what(&format!("camera {index}, stops")), off: stops, standard_error });
        }
    }
    stated
}

fn all_planted(seeds: std::ops::Range<u64>) -> Vec<Vec<Stated>> {
    let planted = [pose_planted, exposure_planted, lens_planted];
    seeds.map(|seed| planted[seed as usize / 2 % 3](seed)).collect()
}

impl Stated {
    /// Whether the truth lies within three standard errors.
    fn holds(&self) -> bool {
        self.off.abs() <= 3.0 * self.standard_error
    }
}

#[test]
fn the_truth_of_planted_errors_lies_within_three_standard_errors_but_for_one_in_twenty() {
    let all = all_planted(0..18);
    let found = all.iter().filter(|stated| !stated.is_empty()).count();
    assert!(found >= 9, "corrections of {found} of {} scenes", all.len());
    let wrong: Vec<&Stated> = all.iter().flatten().filter(|stated| !stated.holds()).collect();
    let count = all.iter().flatten().count();
    assert!(20 * wrong.len() <= count, "{} of {count}: {wrong:#?}", wrong.len());
}

#[test]
#[ignore = "takes a minute"]
fn the_truth_of_two_hundred_planted_errors_lies_within_three_standard_errors_but_for_two_in_a_hundred() {
    let all = all_planted(0..200);
    let stated: Vec<&Stated> = all.iter().flatten().collect();
    let wrong: Vec<&&Stated> = stated.iter().filter(|stated| !stated.holds()).collect();
    for stated in &wrong {
        let sigmas = stated.off / stated.standard_error;
        println!("{sigmas:8.1} {:9.4} ± {:.4} {}", stated.off, stated.standard_error, stated.what);
    }
    let scenes = all.iter().filter(|stated| !stated.is_empty()).count();
    let scenes_wrong = all.iter().filter(|stated| stated.iter().any(|stated| !stated.holds())).count();
    println!("{} of {} statements off, in {scenes_wrong} of {scenes} scenes", wrong.len(), stated.len());
    assert!(50 * wrong.len() <= stated.len(), "{} of {}", wrong.len(), stated.len());
}
