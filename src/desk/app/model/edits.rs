//! The edits of the open scene: the list with its undo, what is selected, and what both leave of the samples.

use std::sync::Arc;

use super::scene::OpenScene;
use overlook_engine::edits::{Action, Edit, EditList, Reach, Region};
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::samples::SampleSet;

/// Lists that are remembered for undo.
const STEPS: usize = 200;

/// How a region that is chosen joins what is selected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Combine {
    #[default]
    Replace,
    Add,
    Subtract,
    Intersect,
}

impl Combine {
    /// Every choice in the order of the panel: its name, and what it does.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Replace, "New", "What is chosen next is the selection."),
        (Self::Add, "Add", "What is chosen next is selected too."),
        (Self::Subtract, "Subtract", "What is chosen next is selected no longer."),
        (Self::Intersect, "Intersect", "Of what is selected, what is also chosen next stays selected."),
    ];
}

/// When an edit acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum EditTime {
    #[default]
    AllFrames,
    /// All frames of the samples that hold at the frame that is shown.
    Spans,
    ThisFrame,
}

impl EditTime {
    /// Every choice in the order of the panel: its name, and what it means.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::AllFrames, "All frames", "The edit acts at every frame."),
        (
            Self::Spans,
            "Spans",
            "The edit takes the samples of the frame that is shown, at all frames for which each of them is stored.",
        ),
        (
            Self::ThisFrame,
            "This frame",
            "The edit acts at the frame that is shown; other frames keep what they show.",
        ),
    ];
}

/// A shape that is drawn in the live view to select what lies behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OutlineTool {
    Rectangle,
    Lasso,
}

/// What a person does to edits.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum EditCommand {
    /// Select a region, as [`Combine`] says.
    Select(Region),
    /// Put another selection in the place of the one that is there: a number or a handle of it was moved.
    Reshape(Region),
    SelectNothing,
    Invert,
    Combine(Combine),
    Tool(Option<OutlineTool>),
    Time(EditTime),
    /// Delete or keep what is selected, or bring it back.
    Act(Action),
    LeaveOut(usize),
    Switch(usize, bool),
    Rename(usize, String),
    /// Move an edit to another place in the list.
    Move(usize, usize),
    Remove(usize),
    /// Select the region of an edit again.
    SelectOf(usize),
}

/// What is worked out of edits; equal keys give the same samples.
#[derive(Clone)]
pub(crate) struct EditKey {
    pub scene: Arc<OpenScene>,
    /// The samples before edits; an outline where a store plays from disk.
    pub samples: Arc<SampleSet>,
    /// The scan that they were pruned with: its capture says which cameras confirm a sample.
    pub scan: Option<Arc<PreparedScan>>,
    pub list: EditList,
    pub selection: Option<Region>,
}

impl PartialEq for EditKey {
    fn eq(&self, other: &Self) -> bool {
        self.scene.id == other.scene.id
            && Arc::ptr_eq(&self.samples, &other.samples)
            && self.scan.as_ref().map(Arc::as_ptr) == other.scan.as_ref().map(Arc::as_ptr)
            && self.list == other.list
            && self.selection == other.selection
    }
}

/// What edits and the selection give.
#[derive(Clone)]
pub(crate) struct EditedScene {
    /// What edits leave.
    pub samples: Arc<SampleSet>,
    /// The same, with the selection in a color of its own.
    pub shown: Arc<SampleSet>,
    /// Samples before edits.
    pub before: u64,
    /// Those that edits delete.
    pub deleted: u64,
    /// Those of what edits leave that are selected.
    pub selected: u64,
    /// Bytes in memory of what edits leave.
    pub bytes: u64,
}

/// The edits of the open scene.
#[derive(Default)]
pub(crate) struct SceneEdits {
    pub list: EditList,
    past: Vec<EditList>,
    future: Vec<EditList>,
    /// Whether the list was changed after any setting: undo takes back what was done last.
    pub is_latest: bool,
    pub selection: Option<Region>,
    pub combine: Combine,
    pub tool: Option<OutlineTool>,
    pub time: EditTime,
    /// What the last list and selection gave; `None` without any.
    pub edited: Option<(EditKey, EditedScene)>,
    /// Why they gave nothing.
    pub trouble: Option<String>,
    /// The list as it is in a file.
    pub saved: EditList,
}

impl SceneEdits {
    /// Whether anything is edited or selected.
    pub(crate) fn are_in_use(&self) -> bool {
        self.selection.is_some() || !self.list.is_idle()
    }

    /// Changes the list in one step of undo. Names that are typed letter by letter are one step.
    pub(crate) fn change(&mut self, is_new_step: bool, change: impl FnOnce(&mut EditList)) {
        let before = self.list.clone();
        change(&mut self.list);
        if self.list == before {
            return;
        }
        if is_new_step || self.past.is_empty() {
            self.past.push(before);
            let surplus = self.past.len().saturating_sub(STEPS);
            self.past.drain(..surplus);
        }
        self.future.clear();
        self.is_latest = true;
    }

    /// Whether undo (or redo) would take an edit back (or do it again).
    pub(crate) fn can(&self, undo: bool) -> bool {
        self.is_latest && !if undo { &self.past } else { &self.future }.is_empty()
    }

    /// Takes the last change of the list back, or does it again; false where there is none.
    pub(crate) fn step(&mut self, undo: bool) -> bool {
        if !self.can(undo) {
            return false;
        }
        let (from, to) =
            if undo { (&mut self.past, &mut self.future) } else { (&mut self.future, &mut self.past) };
        let Some(list) = from.pop() else { return false };
        to.push(std::mem::replace(&mut self.list, list));
        true
    }

    /// What a region that is chosen makes of the selection.
    pub(crate) fn combined(&self, region: Region) -> Region {
        let Some(selection) = self.selection.clone() else { return region };
        match self.combine {
            Combine::Replace => region,
            Combine::Add => Region::Any(vec![selection, region]),
            Combine::Subtract => Region::Without(vec![selection, region]),
            Combine::Intersect => Region::All(vec![selection, region]),
        }
    }

    /// The edit that an action makes of the selection, at a frame by its number.
    pub(crate) fn edit_of_selection(&self, action: Action, frame_number: i64) -> Option<Edit> {
        let region = self.selection.clone()?;
        let verb = match action {
            Action::LeaveOut => "Leave out",
            Action::Delete => "Delete",
            Action::KeepOnly => "Keep only",
            Action::Restore => "Restore",
        };
        let mut edit = Edit::new(format!("{verb} {}", words(&region)), action, region);
        if self.time != EditTime::AllFrames {
            edit.frames = Some([frame_number; 2]);
            edit.reach = if self.time == EditTime::Spans { Reach::Span } else { Reach::Frames };
        }
        Some(edit)
    }
}

/// A region in a few words.
pub(crate) fn words(region: &Region) -> String {
    match region {
        Region::Box { .. } => "box".to_owned(),
        Region::Sphere { .. } => "sphere".to_owned(),
        Region::HalfSpace { .. } => "half space".to_owned(),
        Region::Depth { .. } => "range of depth".to_owned(),
        Region::Cameras(names) => names.join(", "),
        Region::Pixels { camera, .. } => format!("pixels of {camera}"),
        Region::View { .. } => "outline".to_owned(),
        Region::SameSurface { .. } => "surface".to_owned(),
        Region::Grow { region, .. } => format!("{}, grown", words(region)),
        Region::Shrink { region, .. } => format!("{}, shrunk", words(region)),
        Region::Doubtful => "doubtful".to_owned(),
        Region::Contradicted => "contradicted".to_owned(),
        Region::ConfirmedByFewerThan(count) => format!("confirmed by fewer than {count}"),
        Region::SeenByOneCamera => "seen by one camera".to_owned(),
        Region::Footprint { .. } => "range of sampling rate".to_owned(),
        Region::Angle { .. } => "range of angle".to_owned(),
        Region::Any(parts) => join(parts, " + "),
        Region::All(parts) => join(parts, " and "),
        Region::Without(parts) => join(parts, " − "),
        Region::Not(part) => format!("not {}", words(part)),
    }
}

fn join(parts: &[Region], sign: &str) -> String {
    parts.iter().map(words).collect::<Vec<_>>().join(sign)
}

/// The box or sphere of a selection that was chosen last, to be reshaped.
pub(crate) fn last_shape(region: &mut Region) -> Option<&mut Region> {
    match region {
        Region::Box { .. } | Region::Sphere { .. } => Some(region),
        Region::Any(parts) | Region::All(parts) | Region::Without(parts) => {
            parts.last_mut().and_then(last_shape)
        }
        Region::Not(part) => last_shape(part),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_taken_back_and_done_again_until_a_setting_is_changed() {
        let mut edits = SceneEdits::default();
        assert!(!edits.step(true));
        let delete = Edit::new("a", Action::Delete, Region::Doubtful);
        edits.change(true, |list| list.edits.push(delete.clone()));
        edits.change(true, |list| list.edits[0].is_on = false);
        edits.change(false, |list| list.edits[0].name = "b".to_owned());
        assert!(edits.step(true) && edits.list.edits == [delete]);
        assert!(edits.step(true) && edits.list.edits.is_empty() && !edits.can(true));
        assert!(edits.step(false) && edits.step(false) && edits.list.edits[0].name == "b");
        edits.is_latest = false;
        assert!(!edits.step(true), "a setting was changed after it");
    }

    #[test]
    fn regions_join_the_selection_as_sets_and_the_last_shape_is_reshaped() {
        let sphere = Region::Sphere { center: [0.0; 3], radius: 1.0 };
        let mut edits = SceneEdits { selection: Some(sphere.clone()), ..SceneEdits::default() };
        assert_eq!(edits.combined(Region::Doubtful), Region::Doubtful);
        edits.combine = Combine::Subtract;
        let mut without = edits.combined(sphere.clone());
        assert_eq!(without, Region::Without(vec![sphere.clone(), sphere]));
        assert_eq!(words(&without), "sphere − sphere");
        let Some(Region::Sphere { radius, .. }) = last_shape(&mut without) else { panic!("a sphere") };
        *radius = 2.0;
        let Region::Without(parts) = without else { panic!("a difference") };
        assert!(matches!(parts[1], Region::Sphere { radius: 2.0, .. }));
    }
}
