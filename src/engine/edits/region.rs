//! Regions: sets of samples, by where they are, by which camera saw them, or by what other cameras say of them.

use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

use crate::capture::{Camera, Intrinsics, Projection, is_believable_size};

/// A closed outline in a picture: its corners in pixels, `[x, y]` from the upper left corner, in order. At least three.
pub type Outline = Vec<[f64; 2]>;

/// A stroke of a round brush in a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stroke {
    /// Radius of the brush, pixels, above 0.
    pub radius: f64,
    /// Where it went, in pixels, `[x, y]` from the upper left corner, in order; straight in between. At least one point.
    pub points: Vec<[f64; 2]>,
}

/// A set of samples. Empty combinations follow the rules of sets: `any = []` holds nothing, `all = []` holds everything.
///
/// Samples at infinity (the sky) are in no box, sphere or range of depth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Region {
    /// A box, world space.
    #[serde(rename_all = "snake_case")]
    Box {
        /// Its middle.
        center: [f64; 3],
        /// Half of its sides, world units, above 0.
        half_size: [f64; 3],
        /// How it is turned: degrees about world x, then y, then z.
        #[serde(default)]
        rotation_degrees: [f64; 3],
    },
    /// A ball, world space.
    Sphere {
        /// Its middle.
        center: [f64; 3],
        /// World units, above 0.
        radius: f64,
    },
    /// All on one side of a plane, world space.
    HalfSpace {
        /// A point of the plane.
        point: [f64; 3],
        /// Toward the side that is meant; of any length but 0.
        normal: [f64; 3],
    },
    /// Samples whose planar depth in their own camera is in a range, world units, both ends included.
    Depth {
        /// The nearest.
        from: f64,
        /// The farthest.
        to: f64,
    },
    /// All that some cameras saw, by their names.
    Cameras(Vec<String>),
    /// What one camera saw at the pixels whose centers lie within the outline or under a stroke in its picture. With a frame, it is what
    /// these pixels show at that frame, even by samples of other cameras.
    Pixels {
        /// Its name.
        camera: String,
        /// The frame, by its number in the capture.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        frame: Option<i64>,
        /// In its picture.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        outline: Outline,
        /// In its picture.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        strokes: Vec<Stroke>,
    },
    /// What lies within an outline or under a stroke of the picture of any viewpoint, at any depth, or between two depths. With a frame,
    /// only what is seen from there at that frame, without what lies behind.
    View {
        /// The viewpoint.
        viewpoint: Viewpoint,
        /// The frame, by its number in the capture.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        frame: Option<i64>,
        /// In its picture.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        outline: Outline,
        /// In its picture.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        strokes: Vec<Stroke>,
        /// The nearest and the farthest planar depth from there, world units; without it any depth and the sky.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        depth: Option<[f64; 2]>,
    },
    /// Samples that no other camera confirms among noisy cameras, as stores mark them.
    Doubtful,
    /// Samples that more other cameras look past than confirm, their own among these.
    Contradicted,
    /// Samples that fewer than this many other cameras confirm. The sky is not among them.
    ConfirmedByFewerThan(u32),
    /// Samples that no other camera could have seen: none confirms them, none looks past them. The sky is not among them.
    SeenByOneCamera,
    /// Samples whose pixel is this wide at their depth, world units, both ends included: the sampling rate.
    Footprint {
        /// The finest.
        from: f64,
        /// The coarsest.
        to: f64,
    },
    /// Samples whose stored normal is this far from the direction to their camera, degrees, both ends included.
    Angle {
        /// The steepest view.
        from: f64,
        /// The most grazing view.
        to: f64,
    },
    /// Samples with a scalar value in a range, both ends included, which may be infinite. A sample without a value is in none; others have
    /// that of the first frame of their span.
    Value {
        /// The channel's name.
        name: String,
        /// The lowest.
        from: f64,
        /// The highest.
        to: f64,
    },
    /// Samples whose color is near to one: no channel, encoded as sRGB, differs by more than the tolerance. A negative channel counts as 0.
    Color {
        /// Linear Rec.709.
        linear: [f64; 3],
        /// The largest difference that is near, steps of 1/255 of the encoded channel; from 0.
        tolerance: f64,
    },
    /// The surface that a sample lies on, at one frame: all samples of all cameras that are reached from it in short steps along which
    /// the direction of the surface hardly changes. Edges end it.
    SameSurface {
        /// A point of the surface, world space: the sample nearest to it is the first.
        seed: [f64; 3],
        /// The frame, by its number in the capture.
        frame: i64,
        /// The longest step, in widths of the coarser of both pixels at their depths; above 0, at most 64.
        #[serde(default = "default_step")]
        footprints: f64,
        /// By how much normals may differ over one step, degrees, from 0 to 90.
        #[serde(default = "default_turn")]
        angle: f64,
        /// It ends so far from the first sample, world units, above 0; without it nowhere.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        radius: Option<f64>,
    },
    /// What is in a region, and all samples that hold at the same time as one of these and are this near to it. The sky is near nothing.
    Grow {
        /// The region.
        region: Box<Region>,
        /// Widths of the coarser of both pixels at their depths; above 0, at most 64.
        footprints: f64,
    },
    /// What is in a region, without samples that hold at the same time as one beside it and are this near to it.
    Shrink {
        /// The region.
        region: Box<Region>,
        /// As of `grow`.
        footprints: f64,
    },
    /// What is in at least one of these: regions added to each other.
    Any(Vec<Region>),
    /// What is in each of these: their intersection.
    All(Vec<Region>),
    /// What is in the first of these and in none of the others: regions subtracted.
    Without(Vec<Region>),
    /// What is not in this one.
    Not(Box<Region>),
}

/// The longest step of [`Region::SameSurface`] where none is given: over gaps that pruning leaves between cameras.
fn default_step() -> f64 {
    3.0
}

/// How much normals differ over a step of [`Region::SameSurface`] where nothing else is given, degrees: less than at the edges of things.
fn default_turn() -> f64 {
    25.0
}

/// A viewpoint as files name it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Viewpoint {
    /// Columns and rows of the picture.
    pub size: [u32; 2],
    /// Focal lengths, pixels.
    pub focal_length: [f64; 2],
    /// Principal point, pixels.
    pub principal_point: [f64; 2],
    /// World from camera: the camera's right, down and forward axes and its position in world space.
    pub world_from_camera: [[f64; 3]; 4],
    /// Whether lines of sight are parallel: focal lengths are then pixels per world unit.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub orthographic: bool,
}

impl Viewpoint {
    /// The viewpoint of a camera.
    #[must_use]
    pub fn of(camera: &Camera) -> Self {
        let lens = &camera.intrinsics;
        Self {
            size: [lens.width, lens.height],
            focal_length: [lens.fx, lens.fy],
            principal_point: [lens.cx, lens.cy],
            world_from_camera: camera.world_from_camera.to_cols_array_2d(),
            orthographic: lens.is_orthographic(),
        }
    }

    pub(super) fn lens(&self) -> Intrinsics {
        let ([width, height], [fx, fy], [cx, cy]) = (self.size, self.focal_length, self.principal_point);
        let projection = if self.orthographic { Projection::Orthographic } else { Projection::Perspective };
        Intrinsics { width, height, fx, fy, cx, cy, projection }
    }

    pub(super) fn camera_from_world(&self) -> DAffine3 {
        DAffine3::from_cols_array_2d(&self.world_from_camera).inverse()
    }
}

impl Region {
    /// The most footprints of a region that asks for what is near: farther is no neighborhood any more, and takes long to search.
    pub const MOST_FOOTPRINTS: f64 = 64.0;

    /// The surface at a point in world space, at a frame by its number, with steps and turns as they are where a list gives none.
    #[must_use]
    pub fn same_surface(seed: [f64; 3], frame: i64) -> Self {
        Self::SameSurface { seed, frame, footprints: default_step(), angle: default_turn(), radius: None }
    }

    /// The regions that it is made of, where it is a combination.
    pub(super) fn parts(&self) -> &[Self] {
        match self {
            Self::Any(parts) | Self::All(parts) | Self::Without(parts) => parts,
            Self::Not(part) | Self::Grow { region: part, .. } | Self::Shrink { region: part, .. } => {
                std::slice::from_ref(&**part)
            }
            _ => &[],
        }
    }

    fn parts_mut(&mut self) -> &mut [Self] {
        match self {
            Self::Any(parts) | Self::All(parts) | Self::Without(parts) => parts,
            Self::Not(part) | Self::Grow { region: part, .. } | Self::Shrink { region: part, .. } => {
                std::slice::from_mut(&mut **part)
            }
            _ => &mut [],
        }
    }

    /// Makes what pictures of some cameras show what is seen from where they are.
    pub(super) fn see_through(&mut self, cameras: &[&Camera]) {
        self.parts_mut().iter_mut().for_each(|part| part.see_through(cameras));
        if let Self::Pixels { camera, frame: Some(frame), outline, strokes } = self
            && let Some(known) = cameras.iter().find(|known| known.name == *camera)
        {
            *self = Self::View {
                viewpoint: Viewpoint::of(known),
                frame: Some(*frame),
                outline: std::mem::take(outline),
                strokes: std::mem::take(strokes),
                depth: None,
            };
        }
    }

    /// Whether it, or any part of it, is as asked.
    fn has(&self, asked: &impl Fn(&Self) -> bool) -> bool {
        asked(self) || self.parts().iter().any(|part| part.has(asked))
    }

    /// Whether it asks what other cameras say of a sample.
    #[must_use]
    pub fn asks_for_votes(&self) -> bool {
        self.has(&|part| {
            matches!(part, Self::Contradicted | Self::ConfirmedByFewerThan(_) | Self::SeenByOneCamera)
        })
    }

    /// Whether it asks for normals.
    #[must_use]
    pub fn asks_for_normals(&self) -> bool {
        self.has(&|part| matches!(part, Self::Angle { .. }))
    }

    /// Whether it asks for what only a sample has that pruning kept.
    #[must_use]
    pub fn asks_for_evidence(&self) -> bool {
        self.asks_for_votes()
            || self
                .has(&|part| matches!(part, Self::Doubtful | Self::Angle { .. }) || part.asks_other_samples())
    }

    /// Whether it, or any part of it, depends on other samples than the one that is asked about.
    pub(super) fn depends_on_others(&self) -> bool {
        self.has(&Self::asks_other_samples)
    }

    /// Whether it, apart from its parts, depends on other samples than the one that is asked about.
    pub(super) fn asks_other_samples(&self) -> bool {
        matches!(
            self,
            Self::Pixels { frame: Some(_), .. }
                | Self::View { frame: Some(_), .. }
                | Self::SameSurface { .. }
                | Self::Grow { .. }
                | Self::Shrink { .. }
        )
    }

    /// Its parts that depend on other samples, each once; parts come before what is made of them.
    pub(super) fn note_those_that_ask_others<'a>(&'a self, known: &mut Vec<&'a Self>) {
        self.parts().iter().for_each(|part| part.note_those_that_ask_others(known));
        if self.asks_other_samples() && !known.contains(&self) {
            known.push(self);
        }
    }

    /// The cameras that it names.
    pub(super) fn named_cameras(&self) -> Vec<&str> {
        let mut names: Vec<&str> = match self {
            Self::Cameras(names) => names.iter().map(String::as_str).collect(),
            Self::Pixels { camera, .. } => vec![camera],
            _ => Vec::new(),
        };
        names.extend(self.parts().iter().flat_map(Self::named_cameras));
        names
    }

    /// The frames that it names, by their numbers in the capture.
    pub(super) fn named_frames(&self) -> Vec<i64> {
        let own = match self {
            Self::Pixels { frame, .. } | Self::View { frame, .. } => *frame,
            Self::SameSurface { frame, .. } => Some(*frame),
            _ => None,
        };
        own.into_iter().chain(self.parts().iter().flat_map(Self::named_frames)).collect()
    }

    /// The channels of values that it names.
    pub(super) fn named_values(&self) -> Vec<&str> {
        let own = if let Self::Value { name, .. } = self { vec![name.as_str()] } else { Vec::new() };
        own.into_iter().chain(self.parts().iter().flat_map(Self::named_values)).collect()
    }
}

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
