//! The edits of the open scene: the list, what is selected, and what both leave of the samples.

use std::sync::Arc;

use glam::DVec3;

use crate::app::model::command::{Combine, EditTime, EditTools};
use crate::app::model::same::Same;
use crate::app::model::scene::OpenScene;
use overlook_engine::edits::{Action, Edit, EditList, Reach, Region, Stroke};
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::samples::SampleSet;

/// What is worked out of edits; equal keys give the same samples.
#[derive(Clone, PartialEq)]
pub(crate) struct EditKey {
    pub scene: Arc<OpenScene>,
    /// The samples before edits; an outline where a store plays from disk.
    pub samples: Same<SampleSet>,
    /// The scan that they were pruned with: its capture says which cameras confirm a sample.
    pub scan: Option<Same<PreparedScan>>,
    pub list: EditList,
    pub selection: Option<Region>,
}

/// What edits and the selection give.
#[derive(Clone)]
pub(crate) struct EditedScene {
    /// What edits leave.
    pub samples: Arc<SampleSet>,
    /// These samples, with the selection in a color of its own.
    pub shown: Arc<SampleSet>,
    /// Samples before edits.
    pub before: u64,
    /// Those that edits delete.
    pub deleted: u64,
    /// Samples that each edit of the list takes from those before it; fewer than 0 where it brings some back.
    pub counts: Vec<i64>,
    /// Those of what edits leave that are selected.
    pub selected: u64,
    /// Where these lie; `None` where none is selected or all are infinitely far away.
    pub place: Option<SelectionPlace>,
    /// Bytes in memory of what edits leave.
    pub bytes: u64,
}

/// Where selected samples lie, over all frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SelectionPlace {
    /// World space.
    pub mean: DVec3,
    /// Root mean square distance from the mean, world units.
    pub spread: f64,
}

/// The edits of the open scene.
#[derive(Default)]
pub(crate) struct SceneEdits {
    pub list: EditList,
    pub selection: Option<Region>,
    /// What is being drawn, and how it will join the selection.
    pub draft: Option<(Region, Combine)>,
    pub tools: EditTools,
    /// What the last list and selection gave; `None` without any.
    pub edited: Option<(EditKey, EditedScene)>,
    /// Why they gave nothing.
    pub trouble: Option<String>,
    /// The list as it is in a file.
    pub saved: EditList,
}

/// Radii of the brush, points.
pub(crate) const BRUSH_RADII: std::ops::RangeInclusive<f32> = 1.0..=200.0;

impl SceneEdits {
    /// Whether anything is edited or selected.
    pub(crate) fn are_in_use(&self) -> bool {
        self.selection.is_some() || self.draft.is_some() || !self.list.is_idle()
    }

    /// What is selected, with what is being drawn.
    pub(crate) fn shown_selection(&self) -> Option<Region> {
        match &self.draft {
            Some((region, combine)) => Some(self.combined(region.clone(), *combine)),
            None => self.selection.clone(),
        }
    }

    /// What a region that is chosen makes of the selection.
    pub(crate) fn combined(&self, region: Region, combine: Combine) -> Region {
        let Some(selection) = self.selection.clone() else { return region };
        match combine {
            Combine::Replace => region,
            Combine::Add => {
                let mut parts = if let Region::Any(parts) = selection { parts } else { vec![selection] };
                join_stroke(&mut parts, region);
                if parts.len() == 1 { parts.swap_remove(0) } else { Region::Any(parts) }
            }
            Combine::Subtract => Region::Without(vec![selection, region]),
            Combine::Intersect => Region::All(vec![selection, region]),
        }
    }

    /// What is not selected.
    pub(crate) fn inverted(&self) -> Option<Region> {
        Some(match self.selection.clone()? {
            Region::Not(region) => *region,
            region => Region::Not(Box::new(region)),
        })
    }

    /// The selection, grown or shrunk.
    pub(crate) fn grown(&self, grows: bool) -> Option<Region> {
        let mut region = self.selection.clone()?;
        let by = self.tools.grow_by;
        if let (true, Region::Grow { footprints, .. }) | (false, Region::Shrink { footprints, .. }) =
            (grows, &mut region)
        {
            *footprints = (*footprints + by).min(Region::MOST_FOOTPRINTS);
            return Some(region);
        }
        let region = Box::new(region);
        Some(if grows {
            Region::Grow { region, footprints: by }
        } else {
            Region::Shrink { region, footprints: by }
        })
    }

    /// Puts a stroke on the mask of a camera: on the one that was painted last, if it is at the same frames, or on a new one.
    pub(crate) fn mask(&mut self, camera: &str, stroke: Stroke) {
        if let Some(Edit { is_on: true, action: Action::Delete, region, frames, .. }) =
            self.list.edits.last_mut()
            && let Region::Pixels { camera: of, frame: None, strokes, .. } = region
            && *of == camera
            && *frames == self.tools.range
        {
            strokes.push(stroke);
            return;
        }
        let (camera, strokes) = (camera.to_owned(), vec![stroke]);
        let name = format!("Mask {camera}");
        let region = Region::Pixels { camera, frame: None, outline: Vec::new(), strokes };
        let mut edit = Edit::new(name, Action::Delete, region);
        edit.frames = self.tools.range;
        self.list.edits.push(edit);
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
        (edit.frames, edit.reach) = match self.tools.time {
            EditTime::AllFrames => (None, Reach::Frames),
            EditTime::Spans => (Some([frame_number; 2]), Reach::Span),
            EditTime::ThisFrame => (Some([frame_number; 2]), Reach::Frames),
            EditTime::Range => (self.tools.range, Reach::Frames),
        };
        Some(edit)
    }
}

/// What was done to a list.
pub(crate) fn named_change([before, after]: [&EditList; 2]) -> String {
    let (before, after) = (&before.edits, &after.edits);
    let differ = |(before, after): &(&Edit, &Edit)| before != after;
    let mut differing = before.iter().zip(after).filter(differ);
    match (after.len() as i64 - before.len() as i64, differing.next(), differing.next()) {
        (1, None, _) => after.last().map_or_else(String::new, |added| added.name.clone()),
        (-1, ..) => {
            let removed = before.iter().find(|edit| !after.contains(edit)).or(before.last());
            format!("Remove \"{}\"", removed.map_or("", |edit| &edit.name))
        }
        (0, Some((old, new)), None) if old.is_on != new.is_on => {
            format!("Switch \"{}\" {}", new.name, if new.is_on { "on" } else { "off" })
        }
        (0, Some((old, new)), None) if old.name != new.name => format!("Name \"{}\"", new.name),
        (0, Some((_, new)), None) => format!("Change \"{}\"", new.name),
        (0, Some(_), Some(_)) if before.iter().all(|edit| after.contains(edit)) => {
            "Change the order of edits".to_owned()
        }
        _ => "Open edits".to_owned(),
    }
}

/// Adds a region to others: strokes of one brush in one picture become one region, as they are painted one after the other.
fn join_stroke(parts: &mut Vec<Region>, region: Region) {
    let last = parts.last_mut();
    match (last, region) {
        (
            Some(Region::Pixels { camera: of, frame: at, outline: before, strokes }),
            Region::Pixels { camera, frame, outline, strokes: more },
        ) if *of == camera && *at == frame && before.is_empty() && outline.is_empty() => strokes.extend(more),
        (
            Some(Region::View { viewpoint: from, frame: at, outline: before, strokes, depth: within }),
            Region::View { viewpoint, frame, outline, strokes: more, depth },
        ) if *from == viewpoint
            && *at == frame
            && *within == depth
            && before.is_empty()
            && outline.is_empty() =>
        {
            strokes.extend(more);
        }
        (_, region) => parts.push(region),
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
        Region::Pixels { camera, frame: None, .. } => format!("pixels of {camera}"),
        Region::Pixels { camera, .. } => format!("seen by {camera}"),
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
        Region::Color { .. } => "color".to_owned(),
        Region::Value { name, .. } => format!("range of {name}"),
        Region::Any(parts) => join(parts, " + "),
        Region::All(parts) => join(parts, " and "),
        Region::Without(parts) => join(parts, " − "),
        Region::Not(part) => format!("not {}", words(part)),
    }
}

fn join(parts: &[Region], sign: &str) -> String {
    parts.iter().map(words).collect::<Vec<_>>().join(sign)
}

/// The part of a selection that was chosen last, where it has numbers to be turned: a box, sphere, surface, color or range.
pub(crate) fn last_shape(region: &mut Region) -> Option<&mut Region> {
    match region {
        Region::Box { .. }
        | Region::Sphere { .. }
        | Region::SameSurface { .. }
        | Region::Color { .. }
        | Region::Depth { .. }
        | Region::Angle { .. }
        | Region::ConfirmedByFewerThan(_)
        | Region::Value { .. } => Some(region),
        Region::Any(parts) | Region::All(parts) | Region::Without(parts) => {
            parts.last_mut().and_then(last_shape)
        }
        Region::Grow { region: part, .. } | Region::Shrink { region: part, .. } | Region::Not(part) => {
            last_shape(part)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_join_the_selection_as_sets_and_the_last_shape_is_reshaped() {
        let sphere = Region::Sphere { center: [0.0; 3], radius: 1.0 };
        let edits = SceneEdits { selection: Some(sphere.clone()), ..SceneEdits::default() };
        assert_eq!(edits.combined(Region::Doubtful, Combine::Replace), Region::Doubtful);
        let mut without = edits.combined(sphere.clone(), Combine::Subtract);
        assert_eq!(without, Region::Without(vec![sphere.clone(), sphere]));
        assert_eq!(words(&without), "sphere − sphere");
        let Some(Region::Sphere { radius, .. }) = last_shape(&mut without) else { panic!("a sphere") };
        *radius = 2.0;
        let Region::Without(parts) = without else { panic!("a difference") };
        assert!(matches!(parts[1], Region::Sphere { radius: 2.0, .. }));
    }

    #[test]
    fn strokes_that_are_painted_one_after_the_other_are_one_region_and_one_mask() {
        let stroke = |x: f64| Stroke { radius: 3.0, points: vec![[x, 1.0]] };
        let painted = |strokes: Vec<Stroke>| Region::Pixels {
            camera: "a".to_owned(),
            frame: Some(2),
            outline: Vec::new(),
            strokes,
        };
        let mut edits = SceneEdits { selection: Some(painted(vec![stroke(1.0)])), ..SceneEdits::default() };
        edits.selection = Some(edits.combined(painted(vec![stroke(2.0)]), Combine::Add));
        assert_eq!(edits.selection, Some(painted(vec![stroke(1.0), stroke(2.0)])));
        edits.selection = edits.grown(true);
        edits.selection = edits.grown(true);
        assert!(matches!(edits.selection, Some(Region::Grow { footprints: 4.0, .. })));
        edits.mask("a", stroke(1.0));
        edits.mask("a", stroke(2.0));
        edits.tools.range = Some([3, 5]);
        edits.mask("a", stroke(3.0));
        edits.mask("b", stroke(4.0));
        let frames: Vec<_> = edits.list.edits.iter().map(|edit| edit.frames).collect();
        assert_eq!(frames, [None, Some([3, 5]), Some([3, 5])]);
        let Region::Pixels { strokes, .. } = &edits.list.edits[0].region else { panic!("a mask") };
        assert_eq!(*strokes, [stroke(1.0), stroke(2.0)]);
    }
}
