//! Edits by hand: what is deleted is gone, before and after pruning, and nothing else is.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::DVec3;
use overlook_engine::capture::{Capture, with_changed_frames};
use overlook_engine::edits::{Action, Edit, EditList, Reach, Region, Viewpoint, edit_samples, selected};
use overlook_engine::job::Job;
use overlook_engine::preprocess::{
    BufferedResult, Preprocessed, preprocess, preprocess_again, preprocess_edited, prune_for_store, scan,
    votes_on,
};
use overlook_engine::samples::{ImageBuffer, PlacedSample, SampleImage, SampleSet};
use overlook_engine::settings::{AlignSettings, PruningMethod, Settings};
use overlook_engine::store::file::{Extras, write_spooled};

use crate::moving::moving_capture;
use crate::scene::{Scene, arc};

pub(crate) fn settings() -> Settings {
    Settings { align: AlignSettings::OFF, ..Settings::default() }
}

pub(crate) fn pruned(capture: &Capture) -> Preprocessed {
    preprocess(capture, &settings(), &Job::new()).unwrap()
}

pub(crate) fn list(edits: impl IntoIterator<Item = (Action, Region)>) -> EditList {
    EditList { edits: edits.into_iter().map(|(action, region)| Edit::new("", action, region)).collect() }
}

/// The place of the ball that passes by, at a frame.
fn ball(frame: usize) -> Region {
    Region::Sphere { center: [-1.2 + 0.3 * frame as f64, -0.9, 0.3], radius: 0.35 }
}

pub(crate) fn edited(set: &SampleSet, edits: &EditList) -> SampleSet {
    edit_samples(set, edits, None, "test", &Job::new()).unwrap().0
}

/// A pixel of a camera at a frame, with its color and its inverse depth.
type HeldPixel = (u32, usize, usize, [u16; 3], u32);

/// What a set shows at a frame.
fn held(set: &SampleSet, frame: usize) -> BTreeSet<HeldPixel> {
    let of_image = |image: &Arc<SampleImage>| {
        let depths = image.inverse_depths();
        let samples = image.samples().map(|sample| {
            let color = image.color[sample.index].map(half::f16::to_bits);
            (image.camera, sample.x, sample.y, color, depths[sample.index].to_bits())
        });
        samples.collect::<Vec<_>>()
    };
    set.images_at(frame).flat_map(of_image).collect()
}

pub(crate) fn placed(set: &SampleSet) -> Vec<(Arc<SampleImage>, PlacedSample)> {
    let of_image = |image: &Arc<SampleImage>| {
        let placed = image.placed(&set.cameras[image.camera as usize]);
        placed.map(|placed| (image.clone(), placed)).collect::<Vec<_>>()
    };
    set.images.iter().flat_map(of_image).collect()
}

fn is_in(region: &Region, point: DVec3) -> bool {
    let Region::Sphere { center, radius } = region else { panic!("a sphere") };
    (point - DVec3::from(*center)).length() <= *radius
}

#[test]
fn each_edit_counts_what_it_takes_from_what_those_before_it_left() {
    let set = pruned(&moving_capture()).samples;
    let around = |radius| Region::Sphere { center: [0.0, 0.0, 0.5], radius };
    let mut edits = list([
        (Action::Delete, around(0.9)),
        (Action::Delete, around(1.3)),
        (Action::Restore, Region::HalfSpace { point: [0.0, 0.0, 0.2], normal: [0.0, 0.0, 1.0] }),
        (Action::Delete, around(1.6)),
        (Action::KeepOnly, around(2.0)),
        (Action::LeaveOut, Region::Cameras(vec![set.cameras[1].name.clone()])),
    ]);
    edits.edits[1].frames = Some([set.frame_numbers[1]; 2]);
    edits.edits[3].is_on = false;
    let counts = edit_samples(&set, &edits, None, "test", &Job::new()).unwrap().1;
    let left = |first: usize| edited(&set, &EditList { edits: edits.edits[..first].to_vec() }).sample_count();
    let expected: Vec<i64> = (0..edits.edits.len()).map(|n| left(n) as i64 - left(n + 1) as i64).collect();
    assert_eq!(counts, expected);
    assert!(counts[0] > 0 && counts[2] < 0 && counts[3] == 0 && counts[5] > 0, "{counts:?}");
}

#[test]
fn nothing_is_left_inside_of_what_is_deleted_and_keeping_alone_is_deleting_the_rest() {
    let set = pruned(&moving_capture()).samples;
    let viewpoint = Viewpoint::of(&set.cameras[1]);
    let outline = vec![[20.0, 10.0], [70.0, 14.0], [60.0, 60.0]];
    let regions = [
        Region::Sphere { center: [0.0, 0.0, 0.5], radius: 0.9 },
        Region::Box {
            center: [0.2, 0.0, 0.4],
            half_size: [0.8, 0.6, 0.5],
            rotation_degrees: [10.0, 0.0, 30.0],
        },
        Region::HalfSpace { point: [0.0, 0.0, 0.2], normal: [0.0, 0.0, 1.0] },
        Region::Depth { from: 1.0, to: 4.0 },
        Region::Cameras(vec![set.cameras[2].name.clone()]),
        Region::Pixels {
            camera: set.cameras[0].name.clone(),
            frame: None,
            outline: outline.clone(),
            strokes: Vec::new(),
        },
        Region::View { viewpoint, frame: None, outline, strokes: Vec::new(), depth: Some([0.5, 6.0]) },
    ];
    for region in regions {
        let inverse = Region::Not(Box::new(region.clone()));
        let without = edited(&set, &list([(Action::Delete, region.clone())]));
        let (_, selection) = selected(&set, &region, [1.0, 0.0, 0.0], None, "test", &Job::new()).unwrap();
        assert!(selection > 0 && selection < set.sample_count(), "{region:?}: {selection}");
        assert_eq!(without.sample_count() + selection, set.sample_count(), "{region:?}");
        assert_eq!(
            selected(&without, &region, [0.0; 3], None, "test", &Job::new()).unwrap().1,
            0,
            "{region:?}"
        );
        let kept = edited(&set, &list([(Action::KeepOnly, region.clone())]));
        assert_eq!(kept.images, edited(&set, &list([(Action::Delete, inverse)])).images, "{region:?}");
        assert_eq!(kept.sample_count(), selection);
        let nothing = Region::Without(vec![region.clone(), region.clone()]);
        let same =
            edited(&set, &list([(Action::Delete, nothing), (Action::Delete, Region::Any(Vec::new()))]));
        let shared = same.images.iter().zip(&set.images).all(|(a, b)| Arc::ptr_eq(a, b));
        assert!(shared && same.images.len() == set.images.len(), "{region:?}");
    }
}

#[test]
fn edits_act_in_their_order_those_that_are_off_do_not_and_threads_make_no_difference() {
    let set = pruned(&moving_capture()).samples;
    let wide = Region::Sphere { center: [0.0, 0.0, 0.5], radius: 1.5 };
    let narrow = Region::Sphere { center: [0.0, 0.0, 0.5], radius: 0.7 };
    let mut edits = list([(Action::Delete, wide.clone()), (Action::Restore, narrow.clone())]);
    let ring = Region::Without(vec![wide.clone(), narrow]);
    let without_ring = edited(&set, &list([(Action::Delete, ring)]));
    assert_eq!(edited(&set, &edits).images, without_ring.images);
    let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(single.install(|| edited(&set, &edits)).images, without_ring.images);
    edits.edits.swap(0, 1);
    let without_wide = edited(&set, &list([(Action::Delete, wide)]));
    assert_eq!(edited(&set, &edits).images, without_wide.images);
    edits.edits[1].is_on = false;
    assert_eq!(edited(&set, &edits).images, set.images);
}

#[test]
fn a_thing_that_is_deleted_at_one_frame_is_gone_at_all_frames_of_its_spans_or_at_that_frame_alone() {
    let set = pruned(&moving_capture()).samples;
    let frame = 2;
    let mut edit = Edit::new("", Action::Delete, ball(frame));
    (edit.frames, edit.reach) = (Some([set.frame_numbers[frame]; 2]), Reach::Span);
    let spans = edited(&set, &EditList { edits: vec![edit.clone()] });
    let hit = |image: &SampleImage, point: DVec3| image.span.contains(frame) && is_in(&ball(frame), point);
    let expected = placed(&set).iter().filter(|(image, it)| hit(image, it.point_in_world)).count();
    assert!(expected > 0);
    assert_eq!(set.sample_count() - spans.sample_count(), expected as u64);
    assert!(placed(&spans).iter().all(|(image, it)| !hit(image, it.point_in_world)));

    // What stays the same for several frames is cut out of one of them.
    let ground = Region::Sphere { center: [0.0, 0.0, 0.0], radius: 1.5 };
    edit.region = ground.clone();
    edit.reach = Reach::Frames;
    let cut = edited(&set, &EditList { edits: vec![edit] });
    for at in 0..set.frame_count() {
        if at == frame {
            let before = held(&set, at).len();
            assert!(held(&cut, at).is_subset(&held(&set, at)) && held(&cut, at).len() < before);
        } else {
            assert_eq!(held(&cut, at), held(&set, at), "frame {at}");
        }
    }
    assert!(
        placed(&cut)
            .iter()
            .all(|(image, it)| !(image.span.contains(frame) && is_in(&ground, it.point_in_world)))
    );
    let keys: Vec<_> = cut.images.iter().map(|image| (image.camera, image.span)).collect();
    assert_eq!(keys.iter().collect::<BTreeSet<_>>().len(), keys.len(), "no camera has two images of a span");
}

/// What preprocessing with edits gives, in memory.
pub(crate) fn preprocessed(capture: &Capture, edits: &EditList) -> Preprocessed {
    preprocess_edited(capture, &settings(), edits, &Job::new()).unwrap().into_memory().unwrap()
}

#[test]
fn what_is_deleted_before_pruning_does_not_come_back_and_the_numbers_still_add_up() {
    let capture = moving_capture();
    let plain = pruned(&capture);
    let region = Region::Sphere { center: [0.0, 0.0, 0.5], radius: 1.0 };
    let mut once = Edit::new("once", Action::Delete, ball(3));
    once.frames = Some([capture.frame_numbers[3]; 2]);
    let mut edits =
        list([(Action::Delete, region.clone()), (Action::Delete, Region::ConfirmedByFewerThan(1))]);
    edits.edits.push(once);
    let cleaned = preprocessed(&capture, &edits);
    assert!(placed(&cleaned.samples).iter().all(|(_, it)| !is_in(&region, it.point_in_world)));
    let cut = &cleaned.report.cut[0];
    assert!(cut.pixels > 0 && cut.samples > 0, "{cut:?}");
    assert_eq!(EditList::from_toml(&cut.edits, "report").unwrap(), edits);
    for report in [&plain.report, &cleaned.report] {
        let account = report.pixel_account();
        assert_eq!(account.sum(), account.pixels, "{account:?}");
        assert_eq!(account.kept, report.spans.iter().map(|span| span.samples).sum::<u64>());
    }
    assert_eq!(cleaned.report.without_depth(), plain.report.without_depth());
    assert_eq!(preprocessed(&capture, &EditList::default()).samples.images, plain.samples.images);
}

#[test]
fn a_capture_that_was_pruned_before_gives_the_same_store_as_one_that_is_pruned_with_edits() {
    let (capture, job) = (moving_capture(), Job::new());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ovl");
    let written = |result: BufferedResult| {
        let BufferedResult { outline, images, verdicts, mut report } = result;
        report.seconds = 0.0;
        assert!(verdicts.is_some());
        let extras = Extras { report: report.to_json().unwrap(), verdicts, ..Extras::default() };
        write_spooled(&path, &outline, &images, &extras, &job).unwrap();
        std::fs::read(&path).unwrap()
    };
    let mut settings = Settings::default();
    settings.store.verdicts = 4.0;
    let scanned = scan(&capture, &settings, &job).unwrap();
    let known = prune_for_store(&capture, &scanned, &settings, &job).unwrap();
    let evidence = (Action::Delete, Region::ConfirmedByFewerThan(1));
    let space = (Action::Delete, Region::Sphere { center: [0.0, 0.0, 0.5], radius: 1.0 });
    let camera = (Action::LeaveOut, Region::Cameras(vec![capture.cameras[1].name.clone()]));
    let mut stores = BTreeSet::new();
    for edits in [vec![], vec![evidence.clone()], vec![space, evidence.clone()], vec![camera, evidence]] {
        let edits = list(edits);
        let again = preprocess_again(&capture, &scanned, &known, &settings, &edits, &job).unwrap();
        let at_once = preprocess_edited(&capture, &settings, &edits, &job).unwrap();
        let store = written(again);
        assert!(store == written(at_once), "{edits:?}");
        stores.insert(store);
    }
    assert_eq!(stores.len(), 4, "each list changes something");
}

#[test]
fn a_camera_that_is_left_out_takes_no_part_in_pruning() {
    let capture = moving_capture();
    let name = capture.cameras[1].name.clone();
    let edits = list([(Action::LeaveOut, Region::Cameras(vec![name.clone()]))]);
    let cleaned = preprocessed(&capture, &edits);
    let without = pruned(&capture.with_cameras(|index, _| index != 1));
    assert_eq!(cleaned.samples.images, without.samples.images);
    assert_eq!(cleaned.report.cut[0].cameras, [name]);
    let all = list([(
        Action::LeaveOut,
        Region::Cameras(capture.cameras.iter().map(|it| it.name.clone()).collect()),
    )]);
    for (edits, expected) in [
        (all, "leaves no camera"),
        (list([(Action::Delete, Region::Cameras(vec!["nobody".to_owned()]))]), "no camera 'nobody'"),
    ] {
        let error = preprocess_edited(&capture, &settings(), &edits, &Job::new()).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
}

/// Columns and rows of what a camera misreads.
const SQUARE: std::ops::Range<usize> = 40..48;

#[test]
fn samples_that_one_camera_misread_are_selected_by_what_other_cameras_say() {
    let mut settings = settings();
    settings.pruning.method = PruningMethod::Off;
    // One camera reads a square in its middle a third too near.
    let capture =
        with_changed_frames(&Scene::still_life().record(arc(5, 96), 1), 1 << 24, |camera, _, frame| {
            let mut changed = frame.clone();
            if camera == 2 {
                SQUARE.for_each(|y| SQUARE.for_each(|x| changed.inverse_depth[(x, y)] *= 1.5));
            }
            changed
        });
    let set = preprocess(&capture, &settings, &Job::new()).unwrap().samples;
    let votes = votes_on(&ImageBuffer::of(&set.images), &set.cameras, &capture, &Job::new()).unwrap();
    let count =
        |region: Region| selected(&set, &region, [0.0; 3], Some(&votes), "test", &Job::new()).unwrap().1;
    let side = SQUARE.len() as f64;
    let outline = [[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]]
        .map(|corner| corner.map(|at| at + SQUARE.start as f64));
    let square = Region::Pixels {
        camera: set.cameras[2].name.clone(),
        frame: None,
        outline: outline.to_vec(),
        strokes: Vec::new(),
    };
    let contradicted = count(Region::Contradicted);
    let of_square = count(Region::All(vec![square, Region::Contradicted]));
    assert!(of_square >= 48 && contradicted <= of_square + 16, "{contradicted}, {of_square} of the square");
    let counts: Vec<u64> = (1..6).map(|least| count(Region::ConfirmedByFewerThan(least))).collect();
    assert!(counts.is_sorted() && counts[0] < counts[4], "{counts:?}");
    assert!(count(Region::SeenByOneCamera) <= counts[0]);
    let asked = list([(Action::Delete, Region::Contradicted)]);
    let error = edit_samples(&set, &asked, None, "set", &Job::new()).unwrap_err().to_string();
    assert!(error.contains("--capture"), "{error}");
}
