//! Samples by their scalar values: edits of a range of values, and how values are spread.

use overlook_engine::capture::Capture;
use overlook_engine::edits::{Action, EditList, Region};
use overlook_engine::job::Job;
use overlook_engine::preprocess::{preprocess, preprocess_edited};
use overlook_engine::render::output::kept_values;
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::Settings;

use crate::edits::{edited, list};
use crate::scalar_values::orrery;

/// What edits before and after pruning leave of a capture.
fn cleaned(capture: &Capture, edits: &EditList) -> SampleSet {
    let kept = preprocess_edited(capture, &Settings::default(), edits, &Job::new()).unwrap();
    SampleSet { images: kept.images.into_images().unwrap(), ..kept.outline }
}

/// All values of a channel of a set.
fn values(set: &SampleSet, channel: usize) -> Vec<f32> {
    set.images.iter().flat_map(|image| image.values.channel(channel)).collect()
}

#[test]
fn a_range_of_values_is_deleted_or_kept_alone_and_samples_without_a_value_are_in_none() {
    let capture = orrery(3);
    let kept = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples;
    let region = |from: f64, to: f64| Region::Value { name: "part".to_owned(), from, to };
    let all = values(&kept, 2);
    let inside = |value: &&f32| (0.0..=2.0).contains(*value);
    let expected = all.iter().filter(inside).count();
    assert!(expected > 1000 && expected < all.len() / 2, "{expected} of {}", all.len());
    let deleted = edited(&kept, &list([(Action::Delete, region(0.0, 2.0))]));
    assert_eq!(deleted.sample_count() as usize, all.len() - expected);
    let alone = edited(&kept, &list([(Action::KeepOnly, region(0.0, 2.0))]));
    assert_eq!(alone.sample_count() as usize, expected);
    // Everything that has a value at all.
    let open = edited(&kept, &list([(Action::Delete, region(f64::NEG_INFINITY, f64::INFINITY))]));
    assert!(values(&open, 2).iter().all(|value| value.is_nan()) && open.sample_count() > 100);

    let before = cleaned(&capture, &list([(Action::Delete, region(0.0, 2.0))]));
    let left = values(&before, 2);
    assert!(!left.iter().any(|value| inside(&value)) && left.len() >= all.len() - expected);
    let wrong = list([(Action::Delete, Region::Value { name: "speed".to_owned(), from: 0.0, to: 1.0 })]);
    let error =
        preprocess_edited(&capture, &Settings::default(), &wrong, &Job::new()).unwrap_err().to_string();
    assert!(error.contains("no value 'speed'; there are pressure, drift, part"), "{error}");
}

#[test]
fn the_values_of_a_frame_are_those_of_every_kept_sample_once_and_ascend() {
    let kept = preprocess(&orrery(3), &Settings::default(), &Job::new()).unwrap().samples;
    for channel in [0, 2] {
        let shown: Vec<f32> = kept.images_at(1).flat_map(|image| image.values.channel(channel)).collect();
        let missing = shown.iter().filter(|value| value.is_nan()).count();
        let sorted = kept_values(&kept, 1, channel);
        assert!(sorted.is_sorted() && sorted.len() == shown.len() - missing);
        for part in [0.0, 1.0, 2.0, -1.0, 1.5] {
            let count = |values: &[f32]| values.iter().filter(|value| **value <= part).count();
            assert_eq!(count(&sorted), count(&shown));
        }
    }
}
