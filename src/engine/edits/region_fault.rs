//! What is wrong with the numbers of a region.

use glam::{DAffine3, DVec3};

use super::region::{Outline, Region, Stroke, Viewpoint};
use crate::capture::is_believable_size;

fn said(is_wrong: bool, what: &str) -> Option<String> {
    is_wrong.then(|| what.to_owned())
}

fn is_bad(numbers: &[f64]) -> bool {
    numbers.iter().any(|number| !number.is_finite())
}

fn drawn_fault(outline: &Outline, strokes: &[Stroke]) -> Option<String> {
    let is_missing = outline.is_empty() && strokes.is_empty();
    let is_no_area = !outline.is_empty() && outline.len() < 3;
    let is_bad_stroke = |it: &Stroke| {
        it.points.is_empty() || is_bad(it.points.as_flattened()) || is_bad(&[it.radius]) || it.radius <= 0.0
    };
    said(
        is_missing || is_no_area || is_bad(outline.as_flattened()),
        "an outline needs at least three corners with finite numbers; without one, give strokes",
    )
    .or_else(|| {
        said(
            strokes.iter().any(is_bad_stroke),
            "a stroke needs a radius above 0, and at least one point with finite numbers",
        )
    })
}

fn viewpoint_fault(viewpoint: &Viewpoint) -> Option<String> {
    let axes = DAffine3::from_cols_array_2d(&viewpoint.world_from_camera).matrix3;
    let lens = [viewpoint.focal_length, viewpoint.principal_point];
    let [width, height] = viewpoint.size.map(|side| side as usize);
    said(
        is_bad(viewpoint.world_from_camera.as_flattened())
            || is_bad(lens.as_flattened())
            || viewpoint.focal_length.iter().any(|focal| *focal <= 0.0)
            || axes.determinant().abs() < 1e-12
            || !is_believable_size(width, height),
        "a viewpoint needs a size, focal lengths above 0, and axes that span space",
    )
}

fn step_fault(footprints: f64) -> Option<String> {
    let is_fine = footprints > 0.0 && footprints <= Region::MOST_FOOTPRINTS;
    {
        let most = Region::MOST_FOOTPRINTS;
        (!is_fine).then(|| format!("footprints = {footprints}: give a number above 0, and at most {most}"))
    }
}

impl Region {
    /// What is wrong with its numbers, and what to do; `None` where nothing is.
    pub(super) fn fault(&self) -> Option<String> {
        let range = |from: f64, to: f64, name: &str| {
            (is_bad(&[from, to]) || from > to || from < 0.0)
                .then(|| format!("{name} goes from {from} to {to}; give from ≥ 0, and to at least as large"))
        };
        match self {
            Self::Box { center, half_size, rotation_degrees } => said(
                is_bad(center)
                    || is_bad(half_size)
                    || is_bad(rotation_degrees)
                    || half_size.iter().any(|half| *half <= 0.0),
                "a box needs finite numbers, and each half_size above 0",
            ),
            Self::Sphere { center, radius } => said(
                is_bad(center) || is_bad(&[*radius]) || *radius <= 0.0,
                "a sphere needs a radius above 0",
            ),
            Self::HalfSpace { point, normal } => said(
                is_bad(point) || is_bad(normal) || DVec3::from(*normal).length() == 0.0,
                "a half space needs a point, and a normal that is not 0",
            ),
            Self::Depth { from, to } => range(*from, *to, "depth"),
            Self::Footprint { from, to } => range(*from, *to, "footprint"),
            Self::Angle { from, to } => range(*from, *to, "angle"),
            Self::Value { name, from, to } => (from.is_nan() || to.is_nan() || from > to).then(|| {
                format!("value '{name}' goes from {from} to {to}; give to at least as large as from; inf and -inf leave an end open")
            }),
            Self::Color { linear, tolerance } => said(
                is_bad(linear) || is_bad(&[*tolerance]) || *tolerance < 0.0,
                "a color needs three finite numbers, and a tolerance from 0",
            ),
            Self::Pixels { outline, strokes, .. } => drawn_fault(outline, strokes),
            Self::View { viewpoint, outline, strokes, depth, .. } => viewpoint_fault(viewpoint)
                .or_else(|| drawn_fault(outline, strokes))
                .or_else(|| depth.and_then(|[from, to]| range(from, to, "depth"))),
            Self::SameSurface { seed, footprints, angle, radius, .. } => step_fault(*footprints).or_else(|| {
                said(
                    is_bad(seed)
                        || !(0.0..=90.0).contains(angle)
                        || radius.is_some_and(|radius| is_bad(&[radius]) || radius <= 0.0),
                    "same_surface needs a seed, an angle from 0 to 90, and a radius above 0 if it has one",
                )
            }),
            Self::Grow { region, footprints } | Self::Shrink { region, footprints } => {
                step_fault(*footprints).or_else(|| region.fault())
            }
            Self::ConfirmedByFewerThan(count) => said(
                *count == 0,
                "confirmed_by_fewer_than = 0 holds nothing; write 1 for samples that no other camera confirms",
            ),
            Self::Without(parts) => said(
                parts.is_empty(),
                "without needs a region that others are subtracted from; write it first",
            )
            .or_else(|| parts.iter().find_map(Self::fault)),
            _ => self.parts().iter().find_map(Self::fault),
        }
    }
}
