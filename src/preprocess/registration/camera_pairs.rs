//! All cameras and the registrations between them.

use super::reproject::Registration;
use crate::capture::Camera;

/// All cameras and the registration of each pair.
pub(crate) struct CameraPairs<'a> {
    cameras: &'a [Camera],
    /// `[source * cameras + target]`.
    registrations: Vec<Registration>,
}

impl<'a> CameraPairs<'a> {
    /// All pairs of `cameras`.
    pub(crate) fn new(cameras: &'a [Camera]) -> Self {
        let registrations = cameras
            .iter()
            .flat_map(|source| cameras.iter().map(move |target| Registration::new(source, target)))
            .collect();
        Self { cameras, registrations }
    }

    /// From camera `source` to camera `target`.
    pub(crate) fn registration(&self, source: usize, target: usize) -> &Registration {
        &self.registrations[source * self.cameras.len() + target]
    }

    /// The cameras.
    pub(crate) fn cameras(&self) -> &'a [Camera] {
        self.cameras
    }
}
