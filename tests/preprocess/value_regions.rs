//! Samples by their scalar values and colors: edits of a range of values and of a color, and how values are spread.

use overlook_engine::capture::Capture;
use overlook_engine::color::srgb_from_linear;
use overlook_engine::edits::{Action, EditList, Region, edit_tinted, selected};
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
fn a_color_is_deleted_before_and_after_pruning_and_of_a_selection_that_is_shown_in_another_color() {
    let capture = orrery(3);
    let kept = preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples;
    let image = kept.images.iter().max_by_key(|image| image.len()).unwrap();
    let linear = image.color[image.len() / 2].map(half::f16::to_f32);
    let tolerance = 16.3;
    let is_near = |color: &[half::f16; 3]| {
        color.iter().zip(linear).all(|(channel, linear)| {
            let apart = srgb_from_linear(channel.to_f32()) - srgb_from_linear(linear);
            255.0 * apart.abs() <= tolerance
        })
    };
    let near = |set: &SampleSet| {
        set.images.iter().flat_map(|image| &image.color).filter(|color| is_near(color)).count() as u64
    };
    let (all, expected) = (kept.sample_count(), near(&kept));
    assert!(expected > 100 && expected < all, "{expected} of {all}");
    let region = Region::Color { linear: linear.map(f64::from), tolerance: f64::from(tolerance) };
    let delete = list([(Action::Delete, region.clone())]);
    let deleted = edited(&kept, &delete);
    assert_eq!((deleted.sample_count(), near(&deleted)), (all - expected, 0));
    assert_eq!(edited(&kept, &list([(Action::KeepOnly, region.clone())])).sample_count(), expected);
    assert_eq!(near(&cleaned(&capture, &delete)), 0);

    let (tinted, count) = selected(&kept, &region, [1.0, 0.0, 1.0], None, "test", &Job::new()).unwrap();
    assert_eq!((count, near(&tinted)), (expected, 0));
    let left = edit_tinted(&tinted, &kept, &delete, None, "test", &Job::new()).unwrap();
    assert_eq!(left.sample_count(), all - expected, "the colors count that samples had before");
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
