//! The list of edits: what each does, where, and when.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::region::Region;
use crate::capture::{Camera, ValueChannel};
use crate::error::{Error, Result};
use crate::samples::ImageBuffer;

/// What an edit does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// The cameras of the region take part in nothing: before pruning as if they had never been there. The region names cameras alone.
    LeaveOut,
    /// What is in the region goes.
    Delete,
    /// What is not in the region goes.
    KeepOnly,
    /// What is in the region and was deleted by edits before comes back.
    Restore,
}

impl Action {
    /// All of them with their names in files.
    pub const NAMES: [(Self, &'static str); 4] = [
        (Self::LeaveOut, "leave_out"),
        (Self::Delete, "delete"),
        (Self::KeepOnly, "keep_only"),
        (Self::Restore, "restore"),
    ];

    /// Whether a sample stays after this action, if it stayed before, given whether it is in the region.
    pub(super) fn leaves(self, stayed: bool, is_inside: bool) -> bool {
        match self {
            Self::LeaveOut | Self::Delete => stayed && !is_inside,
            Self::KeepOnly => stayed && is_inside,
            Self::Restore => stayed || is_inside,
        }
    }
}

/// How far an edit of some frames reaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reach {
    /// These frames alone: a sample of more frames stays in the others.
    #[default]
    Frames,
    /// All frames of every sample that holds at one of these.
    Span,
}

/// One edit.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// What a person calls it; may be empty.
    pub name: String,
    /// Whether it acts.
    pub is_on: bool,
    /// What it does.
    pub action: Action,
    /// To what.
    pub region: Region,
    /// The first and the last frame, by their numbers in the capture; `None` for all.
    pub frames: Option<[i64; 2]>,
    /// How far it reaches beyond them.
    pub reach: Reach,
}

impl Edit {
    /// An edit of all frames that is on.
    #[must_use]
    pub fn new(name: impl Into<String>, action: Action, region: Region) -> Self {
        Self { name: name.into(), is_on: true, action, region, frames: None, reach: Reach::default() }
    }

    /// Whether it does the same as another, whatever their names.
    pub(super) fn does_as(&self, other: &Self) -> bool {
        let Self { action, region, frames, reach, .. } = self;
        (action, region, frames, reach) == (&other.action, &other.region, &other.frames, &other.reach)
    }

    /// Whether it acts on what pruning kept alone.
    fn needs_samples(&self) -> bool {
        self.region.asks_for_evidence() || (self.frames.is_some() && self.reach == Reach::Span)
    }

    /// What is wrong with it, and what to do; `None` where nothing is.
    pub(super) fn fault(&self) -> Option<String> {
        if let Some([first, last]) = self.frames.filter(|[first, last]| first > last) {
            return Some(format!("frames = [{first}, {last}]: write the first frame before the last"));
        }
        if self.action == Action::LeaveOut && !matches!(self.region, Region::Cameras(_)) {
            return Some(
                "leave_out needs region = { cameras = [\"NAME\"] }; use delete for other regions".to_owned(),
            );
        }
        if self.action == Action::LeaveOut && self.reach == Reach::Span {
            return Some(
                "leave_out has no reach; write the frames that the cameras are left out at".to_owned(),
            );
        }
        self.region.fault()
    }
}

/// Edits in the order in which they act.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EditList {
    /// The first acts first.
    pub edits: Vec<Edit>,
}

impl EditList {
    /// The edits that act.
    #[must_use]
    pub fn acting(&self) -> impl DoubleEndedIterator<Item = &Edit> {
        self.edits.iter().filter(|edit| edit.is_on)
    }

    /// The edits that act, in the order in which they do: cameras are left out last, so that nothing brings them back.
    pub(super) fn in_order(&self) -> Vec<&Edit> {
        let (left_out, others): (Vec<&Edit>, Vec<&Edit>) =
            self.acting().partition(|edit| edit.action == Action::LeaveOut);
        others.into_iter().chain(left_out).collect()
    }

    /// This list with viewpoints in place of the cameras that it leaves out: outlines in their pictures outlast these cameras.
    #[must_use]
    pub fn with_views_of_left_out(&self, cameras: &[Camera]) -> Self {
        let left_out = self.cameras_left_out();
        let gone: Vec<&Camera> =
            cameras.iter().filter(|camera| left_out.contains(camera.name.as_str())).collect();
        let mut list = self.clone();
        for edit in &mut list.edits {
            edit.region.see_through(&gone);
        }
        list
    }

    /// Whether nothing is edited.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.acting().next().is_none()
    }

    /// Whether an edit that acts asks what other cameras say of a sample.
    #[must_use]
    pub fn asks_for_votes(&self) -> bool {
        self.acting().any(|edit| edit.region.asks_for_votes())
    }

    /// The edits that delete observations before pruning. One that something brings back by its evidence waits for that.
    pub(super) fn before_pruning(&self) -> impl Iterator<Item = &Edit> {
        let acting = self.in_order();
        let waits = acting
            .iter()
            .rposition(|edit| edit.action == Action::Restore && edit.needs_samples())
            .map_or(0, |last| last + 1);
        acting.into_iter().skip(waits).filter(|edit| !edit.needs_samples())
    }

    /// Whether something is done before pruning: a camera is left out, or observations are deleted.
    #[must_use]
    pub fn changes_input(&self) -> bool {
        self.before_pruning().next().is_some()
    }

    /// The first edit that acts on what pruning kept alone, with its place in the list.
    pub(super) fn first_after_pruning(&self) -> Option<(usize, &Edit)> {
        self.edits.iter().enumerate().find(|(_, edit)| edit.is_on && edit.needs_samples())
    }

    /// Names of the cameras that are left out of all frames.
    #[must_use]
    pub fn cameras_left_out(&self) -> BTreeSet<&str> {
        let whole = |edit: &&Edit| edit.action == Action::LeaveOut && edit.frames.is_none();
        self.acting().filter(whole).flat_map(|edit| edit.region.named_cameras()).collect()
    }

    /// A line for each acting edit of frames that are not among some: it does nothing there. `place` is named in each.
    #[must_use]
    pub fn without_effect(&self, frame_numbers: &[i64], place: &str) -> Vec<String> {
        let Some((from, to)) = frame_numbers.first().zip(frame_numbers.last()) else { return Vec::new() };
        let is_there = |[first, last]: [i64; 2]| frame_numbers.iter().any(|at| (first..=last).contains(at));
        let acting = self.edits.iter().enumerate().filter(|(_, edit)| edit.is_on);
        let idle = acting.filter_map(|(index, edit)| {
            let of_region = edit.region.named_frames().into_iter().map(|at| [at, at]);
            let [first, last] = edit.frames.into_iter().chain(of_region).find(|range| !is_there(*range))?;
            let place = edit_place(place, index, edit);
            Some(format!(
                "{place} does nothing: it is of frames {first} to {last}, and there are {from} to {to}"
            ))
        });
        idle.collect()
    }

    /// Checks that a capture or store has the cameras and values that acting edits name; the cameras `gone` were left out of it before.
    /// `place` is named in errors.
    ///
    /// # Errors
    /// `Invalid` for a camera or a value that is not there, and where no camera is left.
    pub fn check(
        &self,
        cameras: &[Camera],
        gone: &[String],
        values: &[ValueChannel],
        place: &str,
    ) -> Result<()> {
        for (index, edit) in self.edits.iter().enumerate().filter(|(_, edit)| edit.is_on) {
            let named = edit.region.named_cameras();
            let known = |name: &str| {
                cameras.iter().any(|camera| camera.name == name) || gone.iter().any(|gone| gone == name)
            };
            if let Some(unknown) = named.into_iter().find(|name| !known(name)) {
                let names: Vec<&str> = cameras.iter().take(8).map(|camera| camera.name.as_str()).collect();
                let more = if cameras.len() > names.len() { " …" } else { "" };
                let what = format!("there is no camera '{unknown}'; name one of {}{more}", names.join(", "));
                return Err(Error::invalid(edit_place(place, index, edit), what));
            }
            for name in edit.region.named_values() {
                ValueChannel::named(values, name, &edit_place(place, index, edit))?;
            }
        }
        let left_out = self.cameras_left_out();
        if !cameras.is_empty() && cameras.iter().all(|camera| left_out.contains(camera.name.as_str())) {
            return Err(Error::invalid(place, "leaves no camera; switch one of the edits off"));
        }
        Ok(())
    }
}

/// Refuses edits that leave no sample where they found some.
///
/// # Errors
/// `Invalid` where nothing is left, and something `was_there`.
pub(crate) fn refuse_nothing(was_there: bool, left: &ImageBuffer, place: &str) -> Result<()> {
    if was_there && left.facts().all(|facts| facts.samples == 0) {
        return Err(Error::invalid(
            place,
            "the edits leave no sample; switch one of them off, or invert its region",
        ));
    }
    Ok(())
}

/// An edit of a list, for errors.
pub(super) fn edit_place(place: &str, index: usize, edit: &Edit) -> String {
    let name = if edit.name.is_empty() { String::new() } else { format!(" ({})", edit.name) };
    format!("{place}: edit {}{name}", index + 1)
}
