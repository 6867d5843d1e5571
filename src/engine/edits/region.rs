//! Regions: sets of samples, by where they are, by which camera saw them, or by what other cameras say of them.

use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

use crate::capture::{Camera, Intrinsics};

/// A closed outline in a picture: its corners in pixels, `[x, y]` from the upper left corner, in order. At least three.
pub type Outline = Vec<[f64; 2]>;

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
    /// What one camera saw at the pixels whose centers lie within an outline of its picture.
    Pixels {
        /// Its name.
        camera: String,
        /// In its picture.
        outline: Outline,
    },
    /// What lies within an outline of the picture of any viewpoint, at any depth, or between two depths.
    View {
        /// The viewpoint.
        viewpoint: Viewpoint,
        /// In its picture.
        outline: Outline,
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
    /// What is in at least one of these: regions added to each other.
    Any(Vec<Region>),
    /// What is in each of these: their intersection.
    All(Vec<Region>),
    /// What is in the first of these and in none of the others: regions subtracted.
    Without(Vec<Region>),
    /// What is not in this one.
    Not(Box<Region>),
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
        }
    }

    pub(super) fn lens(&self) -> Intrinsics {
        let ([width, height], [fx, fy], [cx, cy]) = (self.size, self.focal_length, self.principal_point);
        Intrinsics { width, height, fx, fy, cx, cy }
    }

    pub(super) fn camera_from_world(&self) -> DAffine3 {
        DAffine3::from_cols_array_2d(&self.world_from_camera).inverse()
    }
}

impl Region {
    /// The regions that it is made of, where it is a combination.
    fn parts(&self) -> &[Self] {
        match self {
            Self::Any(parts) | Self::All(parts) | Self::Without(parts) => parts,
            Self::Not(part) => std::slice::from_ref(&**part),
            _ => &[],
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
        self.asks_for_votes() || self.has(&|part| matches!(part, Self::Doubtful | Self::Angle { .. }))
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

    /// What is wrong with its numbers, and what to do; `None` where nothing is.
    pub(super) fn fault(&self) -> Option<String> {
        let said = |is_wrong: bool, what: &str| is_wrong.then(|| what.to_owned());
        let is_bad = |numbers: &[f64]| numbers.iter().any(|number| !number.is_finite());
        let range = |from: f64, to: f64, name: &str| {
            (is_bad(&[from, to]) || from > to || from < 0.0)
                .then(|| format!("{name} goes from {from} to {to}; give from ≥ 0, and to at least as large"))
        };
        let outline_fault = |outline: &Outline| {
            said(
                outline.len() < 3 || outline.iter().any(|corner| is_bad(corner)),
                "an outline needs at least three corners with finite numbers",
            )
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
            Self::Pixels { outline, .. } => outline_fault(outline),
            Self::View { viewpoint, outline, depth } => {
                let numbers = viewpoint.world_from_camera.as_flattened();
                let lens = [viewpoint.focal_length, viewpoint.principal_point];
                let is_flat =
                    DAffine3::from_cols_array_2d(&viewpoint.world_from_camera).matrix3.determinant().abs()
                        < 1e-12;
                let is_no_lens = viewpoint.focal_length.iter().any(|focal| *focal <= 0.0);
                said(
                    is_bad(numbers) || is_bad(lens.as_flattened()) || is_no_lens || is_flat,
                    "a viewpoint needs focal lengths above 0, and axes that span space",
                )
                .or_else(|| outline_fault(outline))
                .or_else(|| depth.and_then(|[from, to]| range(from, to, "depth")))
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
