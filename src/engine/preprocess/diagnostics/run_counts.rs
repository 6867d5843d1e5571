//! What was counted over a run of frames, to be added to what was counted over others.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::pair_residuals::{PairHistograms, residuals_of};
use super::pair_table::{keeps_all_pairs, others_kept};
use super::report::Report;
use crate::samples::ImageFacts;

/// Counts and residuals of a run of frames. All are whole numbers that add up, or the same for all runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunCounts {
    /// Without what the images say, and without residuals.
    pub(crate) report: Report,
    pub(crate) readings: PairHistograms,
}

impl RunCounts {
    /// Adds the counts of another run of the same capture.
    pub(crate) fn add(&mut self, other: &Self) {
        let (all, more) = (&mut self.report, &other.report);
        add_each(&mut all.foreground_per_frame, &more.foreground_per_frame);
        add_named(&mut all.pruned, &more.pruned);
        add_named(&mut all.mixed_pixels, &more.mixed_pixels);
        for (loser, winner, more) in more.witnesses.iter() {
            if let Some(all) = all.witnesses.get_mut(loser, winner) {
                *all += more;
            }
        }
        for (all, more) in all.cameras.iter_mut().zip(&more.cameras) {
            all.background_pixels += more.background_pixels;
            all.background_kept += more.background_kept;
            all.foreground_pixels += more.foreground_pixels;
            all.foreground_kept += more.foreground_kept;
        }
        for (all, more) in self.readings.iter_mut().zip(&other.readings) {
            if let Some(more) = more {
                let all = all.get_or_insert_default();
                all.iter_mut().zip(more.iter()).for_each(|(all, more)| all.add(more));
            }
        }
    }

    /// The report of all runs of this many cameras, given the images that are kept.
    pub(crate) fn finish<'a>(self, cameras: usize, images: impl Iterator<Item = &'a ImageFacts>) -> Report {
        let Self { mut report, readings } = self;
        report.count_images(images);
        report.residuals = residuals_of(&readings, cameras);
        if !keeps_all_pairs(cameras) {
            report.witnesses_left_out = report.witnesses.keep_largest(others_kept(cameras));
        }
        report
    }
}

fn add_each(all: &mut [u64], more: &[u64]) {
    all.iter_mut().zip(more).for_each(|(all, more)| *all += more);
}

fn add_named(all: &mut BTreeMap<String, u64>, more: &BTreeMap<String, u64>) {
    for (name, count) in more {
        *all.entry(name.clone()).or_default() += count;
    }
}
