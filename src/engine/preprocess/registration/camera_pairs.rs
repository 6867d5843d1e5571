//! All cameras and the registrations between those that may see the same.

use rayon::prelude::*;

use super::reproject::Registration;
use super::sight::Sight;
use crate::capture::Camera;

/// All cameras and the registration of each pair that matters.
pub struct CameraPairs<'a> {
    cameras: &'a [Camera],
    of_camera: Vec<OthersOf>,
}

/// One camera, and those that may see any of its samples.
struct OthersOf {
    itself: Registration,
    /// Ascending.
    others: Vec<u32>,
    /// One for each of `others`.
    registrations: Vec<Registration>,
}

impl<'a> CameraPairs<'a> {
    /// All pairs of `cameras`.
    #[must_use]
    pub fn new(cameras: &'a [Camera]) -> Self {
        Self::where_seen(cameras, |_, _| true)
    }

    /// The pairs whose target may see what the source saw. No sample of any other source is in the picture of its target.
    ///
    /// A target that saw only nearer surfaces is not left out: the distance from a tangent plane decides whether both saw the same
    /// surface, and a surface seen from its edge is close to that plane at any depth.
    pub(crate) fn of_sights(cameras: &'a [Camera], sights: &[Sight]) -> Self {
        Self::where_seen(cameras, |source, registration| sights[source].may_be_seen(registration))
    }

    fn where_seen(cameras: &'a [Camera], is_seen: impl Fn(usize, &Registration) -> bool + Sync) -> Self {
        let of_camera = |(source, camera): (usize, &Camera)| {
            let others = cameras.iter().enumerate().filter(|(target, _)| *target != source);
            let registered = others.map(|(target, other)| (target as u32, Registration::new(camera, other)));
            let (others, registrations) =
                registered.filter(|(_, registration)| is_seen(source, registration)).unzip();
            OthersOf { itself: Registration::new(camera, camera), others, registrations }
        };
        Self { cameras, of_camera: cameras.par_iter().enumerate().map(of_camera).collect() }
    }

    /// From camera `source` to camera `target`, which is the same or one of [`CameraPairs::others`].
    pub(crate) fn registration(&self, source: usize, target: usize) -> &Registration {
        let of_source = &self.of_camera[source];
        if let Ok(at) = of_source.others.binary_search(&(target as u32)) {
            return &of_source.registrations[at];
        }
        debug_assert_eq!(source, target, "cameras that do not see each other are not compared");
        &of_source.itself
    }

    /// The cameras that may see any sample of `source`, ascending, each with the way there.
    #[inline(always)]
    pub(crate) fn others(&self, source: usize) -> impl ExactSizeIterator<Item = (usize, &Registration)> {
        let OthersOf { others, registrations, .. } = &self.of_camera[source];
        others.iter().map(|other| *other as usize).zip(registrations)
    }

    /// Those of [`CameraPairs::others`] that are among some cameras, ascending.
    #[inline(always)]
    pub(crate) fn others_among(
        &self,
        source: usize,
        cameras: &[usize],
    ) -> impl Iterator<Item = (usize, &Registration)> {
        let OthersOf { others, registrations, .. } = &self.of_camera[source];
        let at = |camera: &usize| others.binary_search(&(*camera as u32)).ok();
        cameras.iter().filter_map(move |camera| at(camera).map(|at| (*camera, &registrations[at])))
    }

    /// The cameras.
    pub(crate) fn cameras(&self) -> &'a [Camera] {
        self.cameras
    }
}
