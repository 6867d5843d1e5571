//! What splats are written as, and what of a scene.

use crate::settings::choice::choice;

choice! {
    /// A file format of Gaussian splats.
    pub enum SplatFormat {
        /// One frame as PLY, as the authors of Gaussian splatting write it: nearly every program reads it, 68 bytes a splat.
        Ply = "ply",
        /// One frame as SPZ, version 3: some 10 to 15 bytes a splat.
        Spz = "spz",
        /// The whole scene as glTF with its extension for splats: a node for each span of frames, shown by an animation.
        Glb = "glb",
        /// The whole scene as USD, a particle field for each span of frames, shown by its visibility.
        Usda = "usda",
    }
}

choice! {
    /// What becomes of samples at infinity.
    pub enum SplatSky {
        /// They are left out: no format has a place for them.
        Out = "out",
        /// Their colors, continued into all directions, become a far dome around the scene.
        Dome = "dome",
    }
}

impl SplatFormat {
    /// Whether a file holds the whole scene in time; of the others each holds one frame.
    #[must_use]
    pub fn holds_time(self) -> bool {
        matches!(self, Self::Glb | Self::Usda)
    }
}

/// How many splats there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplatAmount {
    /// Most splats, the dome's included; samples are merged where that loses least until they fit.
    pub at_most: Option<u64>,
    /// What becomes of samples at infinity.
    pub sky: SplatSky,
}

/// How splats are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatOptions {
    /// The format.
    pub format: SplatFormat,
    /// How many splats a file has.
    pub amount: SplatAmount,
    /// Frames a second, where the format holds time; above 0.
    pub frames_per_second: f64,
}
