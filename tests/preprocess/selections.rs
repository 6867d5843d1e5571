//! Regions that are drawn in pictures, that follow a surface, and that are grown: which samples they hold, by the truth of the scene.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::DVec3;
use overlook_engine::capture::{Camera, Capture, PixelSide};
use overlook_engine::edits::{
    Action, CutByHand, Edit, EditList, Region, Stroke, Viewpoint, edit_samples, selected,
};
use overlook_engine::error::Error;
use overlook_engine::job::Job;
use overlook_engine::samples::{PlacedSample, SampleImage, SampleSet};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use crate::edits::{edited, list, placed, preprocessed, pruned};
use crate::moving::moving_capture;
use crate::scene::{Scene, arc};

fn still_life() -> Capture {
    Scene::still_life().record(arc(4, 96), 1)
}

/// A sample by its camera, span and pixel.
type Name = (u32, u32, u32, usize, usize);

fn name((image, placed): &(Arc<SampleImage>, PlacedSample)) -> Name {
    (image.camera, image.span.start, image.span.end, placed.sample.x, placed.sample.y)
}

/// The samples of a set that are in a region, apart from the sky.
fn inside(set: &SampleSet, region: &Region) -> BTreeSet<Name> {
    placed(&edited(set, &list([(Action::KeepOnly, region.clone())]))).iter().map(name).collect()
}

fn square(first: f64, last: f64) -> Vec<[f64; 2]> {
    vec![[first, first], [last, first], [last, last], [first, last]]
}

/// Whether a pixel shows a place, whether something before it hides it, by what a camera recorded; `None` at edges and beside the square.
fn is_seen(capture: &Capture, camera: &Camera, point: DVec3, [first, last]: [f64; 2]) -> Option<bool> {
    let (at, depth) = camera.project(point)?;
    let margin = 2.0;
    if at.min_element() < first + margin || at.max_element() > last - margin {
        return None;
    }
    let frame = capture.frame(0, 0).unwrap();
    let (x, y) = (at.x as usize, at.y as usize);
    let ratios: Vec<f64> = (y - 1..y + 2)
        .flat_map(|row| (x - 1..x + 2).map(move |column| (column, row)))
        .map(|pixel| f64::from(frame.inverse_depth[pixel]) * depth)
        .collect();
    if ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.015) {
        return Some(true);
    }
    ratios.iter().all(|ratio| *ratio > 1.1).then_some(false)
}

#[test]
fn a_selection_that_is_cancelled_ends_whatever_it_asks() {
    let capture = still_life();
    let set = pruned(&capture).samples;
    let at = placed(&set)[0].1.point_in_world.to_array();
    let surface = Region::same_surface(at, set.frame_numbers[0]);
    let camera = set.cameras[0].name.clone();
    let drawn = Region::Pixels {
        camera,
        frame: Some(set.frame_numbers[0]),
        outline: square(8.0, 60.0),
        strokes: vec![],
    };
    let grown = Region::Grow { region: Box::new(drawn.clone()), footprints: 2.0 };
    let job = Job::new();
    job.cancel();
    for region in [surface, drawn, grown] {
        let one = selected(&set, &region, [0.0; 3], None, "test", &Job::new()).unwrap().1;
        assert!(one > 0, "{region:?}");
        let stopped = selected(&set, &region, [0.0; 3], None, "test", &job);
        assert!(matches!(stopped, Err(Error::Cancelled)), "{region:?}");
        let deleted = edit_samples(&set, &list([(Action::Delete, region)]), None, "test", &job);
        assert!(matches!(deleted, Err(Error::Cancelled)));
    }
}

#[test]
fn what_is_outlined_in_one_picture_is_gone_from_every_camera_and_what_lies_behind_it_stays() {
    let capture = still_life();
    let set = pruned(&capture).samples;
    let camera = &set.cameras[0];
    let [first, last] = [24.0, 70.0];
    let of_camera = |frame| Region::Pixels {
        camera: camera.name.clone(),
        frame,
        outline: square(first, last),
        strokes: Vec::new(),
    };
    let from_there = Region::View {
        viewpoint: Viewpoint::of(camera),
        frame: Some(0),
        outline: square(first, last),
        strokes: Vec::new(),
        depth: None,
    };
    for region in [of_camera(Some(0)), from_there] {
        let selected = inside(&set, &region);
        let (mut of_others, mut hidden) = (0, 0);
        for sample in placed(&set) {
            let (image, place) = &sample;
            let is_in = selected.contains(&name(&sample));
            match is_seen(&capture, camera, place.point_in_world, [first, last]) {
                Some(true) => {
                    assert!(is_in, "{region:?}: {place:?} is seen there");
                    of_others += usize::from(image.camera != 0);
                }
                Some(false) => {
                    assert!(!is_in, "{region:?}: {place:?} is hidden there");
                    hidden += 1;
                }
                None => {}
            }
            let at = camera.project(place.point_in_world).map(|(at, _)| at);
            let is_beside = at.is_none_or(|at| at.min_element() < first || at.max_element() > last);
            assert!(!(is_in && is_beside), "{region:?}: {place:?} is not in the outline");
        }
        assert!(of_others > 50 && hidden > 50, "{of_others} of other cameras, {hidden} hidden");
    }
    let own = inside(&set, &of_camera(None));
    assert!(!own.is_empty() && own.iter().all(|(camera, ..)| *camera == 0));
}

#[test]
fn what_was_outlined_in_the_picture_of_a_camera_that_is_left_out_is_gone_all_the_same() {
    let capture = still_life();
    let [first, last] = [24.0, 70.0];
    let camera = &capture.cameras[0];
    let outlined = Region::Pixels {
        camera: camera.name.clone(),
        frame: Some(0),
        outline: square(first, last),
        strokes: Vec::new(),
    };
    let edits =
        list([(Action::Delete, outlined), (Action::LeaveOut, Region::Cameras(vec![camera.name.clone()]))]);
    let left = preprocessed(&capture, &edits);
    assert_eq!(EditList::from_toml(&left.report.cut[0].edits, "report").unwrap(), edits);
    let seen = |point| is_seen(&capture, camera, point, [first, last]);
    let shown = placed(&left.samples).iter().filter(|(_, it)| seen(it.point_in_world) == Some(true)).count();
    assert_eq!(shown, 0);
    assert!(placed(&left.samples).iter().any(|(_, it)| seen(it.point_in_world) == Some(false)));
}

#[test]
fn a_region_of_a_frame_that_is_not_there_gives_one_clear_error() {
    let set = pruned(&still_life()).samples;
    let edits = list([(Action::Delete, Region::same_surface([0.0; 3], 7))]);
    let error = edit_samples(&set, &edits, None, "list", &Job::new()).unwrap_err().to_string();
    assert!(error.contains("names frame 7") && error.contains("1 frame from 0 to 0"), "{error}");
}

#[test]
fn a_mask_that_is_painted_leaves_the_pixels_of_its_camera_out_of_pruning_at_its_frames_alone() {
    let capture = moving_capture();
    let camera = &capture.cameras[1];
    let points = vec![[20.0, 40.0], [40.0, 44.0], [44.0, 60.0]];
    let strokes = vec![Stroke { radius: 5.0, points: points.clone() }];
    let is_masked = |x: usize, y: usize| {
        let at = glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        points.windows(2).any(|ends| {
            let [start, end] = [ends[0], ends[1]].map(glam::DVec2::from);
            let share = ((at - start).dot(end - start) / (end - start).length_squared()).clamp(0.0, 1.0);
            at.distance(start + (end - start) * share) <= 5.0
        })
    };
    let region = Region::Pixels { camera: camera.name.clone(), frame: None, outline: Vec::new(), strokes };
    let mut mask = Edit::new("mask", Action::Delete, region);
    mask.frames = Some([1, 2]);
    let cleaned = preprocessed(&capture, &EditList { edits: vec![mask] });
    let with_depth = |frame: usize| {
        let depths = &capture.frame(1, frame).unwrap().inverse_depth;
        let (width, height) = depths.size();
        (0..width * height)
            .filter(|at| is_masked(at % width, at / width) && depths.as_slice()[*at] >= 0.0)
            .count()
    };
    assert_eq!(cleaned.report.cut[0].pixels, (with_depth(1) + with_depth(2)) as u64);
    let masked_at = |frame: usize| {
        let of_camera = cleaned.samples.images_at(frame).filter(|image| image.camera == 1);
        of_camera.map(|image| image.samples().filter(|it| is_masked(it.x, it.y)).count()).sum::<usize>()
    };
    assert_eq!([masked_at(1), masked_at(2)], [0, 0]);
    assert!(masked_at(0) > 0 && masked_at(3) > 0);
    let account = cleaned.report.pixel_account();
    assert_eq!(account.sum(), account.pixels, "{account:?}");
}

#[test]
fn the_same_surface_is_all_of_a_thing_that_cameras_saw_and_ends_at_its_edges() {
    let set = pruned(&still_life()).samples;
    let all = placed(&set);
    let is_ball = |point: DVec3| ((point - DVec3::new(0.0, 0.0, 0.6)).length() - 0.6).abs() < 0.02;
    let is_ground = |point: DVec3| point.z.abs() < 0.01;
    let ball = DVec3::new(0.0, 0.0, 0.6) + 0.6 * DVec3::new(0.0, -0.8, 0.6);
    for (seed, is_of_it) in
        [(ball, &is_ball as &dyn Fn(DVec3) -> bool), (DVec3::new(0.3, -1.0, 0.0), &is_ground)]
    {
        let region = Region::same_surface(seed.to_array(), 0);
        let selected = inside(&set, &region);
        let of_it = all.iter().filter(|(_, it)| is_of_it(it.point_in_world));
        let (there, found) = of_it.fold((0, 0), |(there, found), it| {
            (there + 1, found + usize::from(selected.contains(&name(it))))
        });
        assert!(found * 10 > there * 8, "{seed}: {found} of {there}");
        // Where things meet, an edge of a pixel or two has no direction that would tell whose it is.
        assert!(selected.len() * 100 < found * 108, "{seed}: {} selected, {found} of it", selected.len());
        let cameras: BTreeSet<u32> = selected.iter().map(|(camera, ..)| *camera).collect();
        assert!(cameras.len() > 1, "{seed}: {cameras:?}");
        let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(single.install(|| inside(&set, &region)), selected);
        let Region::SameSurface { seed, frame, footprints, angle, .. } = region else { panic!("a surface") };
        let near = Region::SameSurface { seed, frame, footprints, angle, radius: Some(0.2) };
        let near = inside(&set, &near);
        assert!(!near.is_empty() && near.len() < selected.len());
        let far = all.iter().filter(|(_, it)| it.point_in_world.distance(DVec3::from(seed)) > 0.2001);
        assert!(far.map(name).all(|it| !near.contains(&it)));
    }
    let in_the_air = Region::same_surface([0.0, -2.0, 2.0], 0);
    assert!(inside(&set, &in_the_air).is_empty());
}

#[test]
fn a_region_grows_over_what_is_as_near_as_footprints_say_and_shrinks_by_what_is_beside_it() {
    let set = pruned(&moving_capture()).samples;
    let region = Region::Sphere { center: [0.0, 0.0, 0.3], radius: 0.7 };
    let footprints = 2.0;
    let boxed = || Box::new(region.clone());
    let grown = inside(&set, &Region::Grow { region: boxed(), footprints });
    let width = |image: &SampleImage, it: &PlacedSample| {
        it.depth * set.cameras[image.camera as usize].intrinsics.pixel_width(1.0, PixelSide::Longer)
    };
    let all = placed(&set);
    let core = inside(&set, &region);
    let (within, beside): (Vec<_>, Vec<_>) = all.iter().partition(|it| core.contains(&name(it)));
    let mut added = 0;
    for sample in beside {
        let (image, it) = sample;
        let slack = within
            .iter()
            .filter(|(other, _)| other.span.start < image.span.end && image.span.start < other.span.end);
        // By how much the nearest of them, as footprints count, is too far.
        let slack = slack.map(|(other, near)| {
            let reach = footprints * width(image, it).max(width(other, near));
            near.point_in_world.distance(it.point_in_world) / reach - 1.0
        });
        let slack = slack.fold(f64::INFINITY, f64::min);
        if slack.abs() > 1e-4 {
            assert_eq!(grown.contains(&name(sample)), slack < 0.0, "{it:?}: {slack}");
        }
        added += usize::from(slack < 0.0);
    }
    assert!(added > 50 && core.is_subset(&grown));
    let shrunk = inside(&set, &Region::Shrink { region: boxed(), footprints });
    let outside = Box::new(Region::Not(boxed()));
    let inverse = Region::Not(Box::new(Region::Grow { region: outside, footprints }));
    assert!(!shrunk.is_empty() && shrunk.len() < core.len());
    assert_eq!(shrunk, inside(&set, &inverse));
}

/// What is seen in a square of a picture, the surface at a place, or what is near a ball, or what one has without the other.
fn any_region(camera: String) -> impl Strategy<Value = Region> {
    let seen = (8.0..60.0_f64, 8.0..30.0_f64).prop_map(move |(first, side)| Region::Pixels {
        camera: camera.clone(),
        frame: Some(0),
        outline: square(first, first + side),
        strokes: Vec::new(),
    });
    let surface = (-0.6..0.6_f64, -0.6..0.6_f64).prop_map(|(x, y)| Region::same_surface([x, y, 0.0], 0));
    let ball = (-0.6..0.6_f64, 0.2..0.7_f64)
        .prop_map(|(x, radius)| Region::Sphere { center: [x, 0.0, 0.3], radius });
    let grown = (ball, 1.0..4.0_f64)
        .prop_map(|(ball, footprints)| Region::Grow { region: Box::new(ball), footprints });
    let one = prop_oneof![seen, surface, grown].boxed();
    (one.clone(), one, any::<bool>())
        .prop_map(|(one, other, is_both)| if is_both { Region::Without(vec![one, other]) } else { one })
}

#[test]
fn regions_of_a_list_are_those_of_the_samples_before_it_whatever_else_is_in_it_and_how_often() {
    let set = pruned(&still_life()).samples;
    let names = |set: &SampleSet| placed(set).iter().map(name).collect::<BTreeSet<Name>>();
    let all = names(&set);
    let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let region = || any_region(set.cameras[0].name.clone());
    let mut runner = TestRunner::new(ProptestConfig { cases: 12, ..ProptestConfig::default() });
    let property = |(one, other): (Region, Region)| {
        let [of_one, of_other] = [&one, &other].map(|region| inside(&set, region));
        let left: BTreeSet<Name> = all.iter().filter(|it| !of_one.contains(it)).copied().collect();
        let twice = list([(Action::Delete, one.clone()), (Action::Delete, one.clone())]);
        prop_assert_eq!(&names(&edited(&set, &twice)), &left);
        let both = list([(Action::Delete, one), (Action::Delete, other)]);
        let cut = edited(&set, &both);
        prop_assert_eq!(names(&cut), left.difference(&of_other).copied().collect::<BTreeSet<_>>());
        prop_assert_eq!(single.install(|| names(&edited(&set, &both))), names(&cut));
        // A store that has it behind it, by its report.
        let done = [CutByHand { edits: both.to_toml(), ..CutByHand::default() }];
        let mut longer = both.clone();
        longer.edits.push(Edit::new("more", Action::Delete, Region::Doubtful));
        prop_assert!(CutByHand::left_to_do(&done, &both).is_idle());
        prop_assert_eq!(CutByHand::left_to_do(&done, &longer).edits, longer.edits[2..].to_vec());
        longer.edits[0].is_on = false;
        prop_assert_eq!(CutByHand::left_to_do(&done, &longer).edits, longer.edits[2..].to_vec());
        Ok(())
    };
    runner.run(&(region(), region()), property).unwrap();
}
