//! Warnings about cameras whose pose, clock or depth does not fit the others, and what each takes for wrong.

use super::pair_residuals::{PairResiduals, Residual};
use super::pair_table::PairTable;
use crate::median::median_f32;

/// What a warning takes for wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suspect {
    /// The pose of one camera, or its lens.
    Pose,
    /// When one camera's frames were taken.
    Clock,
    /// How the depth of all cameras is read, or their lens or poses.
    Depth,
    /// The space of given normals.
    Normals,
}

impl Suspect {
    /// In a word or two.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pose => "Pose error",
            Self::Clock => "Time offset",
            Self::Depth => "Depth or poses of all cameras",
            Self::Normals => "Normals",
        }
    }
}

/// A camera that fits no other as well as the others fit each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationWarning {
    /// The camera, by its index.
    pub camera: usize,
    /// Whether only moving things disagree: then the frames of the camera may be early or late. Else its pose may be wrong. (If a plane
    /// fills the picture, a pose that is off along it shows only at things in front of it, and these may be the moving ones.)
    pub over_time: bool,
    /// Distance from the camera that fits it best, in footprints: of most samples, or over time the median.
    pub footprints: f32,
    /// Distance between the other two cameras that fit each other best; `None` if none of them can be compared.
    pub usual_footprints: Option<f32>,
}

impl CalibrationWarning {
    /// In words, for a camera of this name.
    #[must_use]
    pub fn sentence(&self, name: &str) -> String {
        let others = self.usual_footprints.map_or_else(String::new, |usual| format!(", others {usual:.2}"));
        let compared = format!("{:.2} footprints where it fits best{others}", self.footprints);
        if self.over_time {
            format!(
                "camera '{name}' agrees with no other about what moves ({compared}); its frames may be early or late, or its pose may be off in a direction that flat scenery does not show"
            )
        } else {
            format!(
                "camera '{name}' agrees with no other about where things are ({compared}); check its pose and lens"
            )
        }
    }
}

/// No two cameras agree about what never moves: something that they share is wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SharedWarning {
    /// Distance between the two cameras that fit each other best, in footprints, of most samples; `None` if no camera finds anything
    /// that another sees.
    pub footprints: Option<f32>,
}

impl SharedWarning {
    /// The first condition that is not met.
    pub(super) fn sentence(self) -> String {
        const CHECK: &str = "check depth_kind, depth_unit_scale_factor and the lens, which concern all of them, and the poses";
        match self.footprints {
            Some(footprints) => format!(
                "no two cameras agree about where things are ({footprints:.2} footprints for the two that fit best); {CHECK}"
            ),
            None => {
                format!(
                    "no camera finds anything that another one sees; unless they look at different things, {CHECK}"
                )
            }
        }
    }
}

/// A pose is suspect only if the distance of most samples of what never moves exceeds this, in footprints. Correct captures
/// stay below a tenth in all but one or two pairs; a camera that is turned by half a pixel reaches a third in all.
const SUSPECT_POSE_FOOTPRINTS: f32 = 0.25;

/// Surfaces agree where the median distance of the two cameras that fit best stays below this, in footprints. What most samples do not
/// exceed is then the distance of silhouettes, more than a sixth of a small round thing.
const AGREEING_MEDIAN_FOOTPRINTS: f32 = 0.03;

/// A clock is suspect only if the median distance of what moves exceeds this, in footprints: of moving things silhouettes are a large part, and are off in correct captures too.
const SUSPECT_CLOCK_FOOTPRINTS: f32 = 0.15;

/// The same where there are no others to compare with.
const SUSPECT_CLOCK_ALONE_FOOTPRINTS: f32 = 2.0;

/// With fewer samples of a pair, both ways where there are any, no warning about all cameras: silhouettes may be most of them.
const INFORMATIVE_SAMPLES: u64 = 256;

/// Samples of a camera from which on it is suspect that no other camera sees any of them.
const INFORMATIVE_UNMATCHED: u64 = 1000;

/// A camera is suspect only if its residual exceeds this many times the median of the others.
const SUSPECT_RATIO: f32 = 8.0;

/// How far two cameras are apart about what never moves: most samples, or no more than is suspect where the median says that surfaces agree.
fn off(fit: Residual) -> f32 {
    if fit.median_footprints < AGREEING_MEDIAN_FOOTPRINTS {
        fit.most_footprints.min(SUSPECT_POSE_FOOTPRINTS)
    } else {
        fit.most_footprints
    }
}

/// The warning about all cameras together, where not even the two agree that fit best; see [`PairResiduals`] for `pairs`.
/// `granted_footprints` is how far noise and rounding may put surfaces apart.
pub(super) fn shared_warning(
    pairs: &PairTable<PairResiduals>,
    granted_footprints: f32,
) -> Option<SharedWarning> {
    let of = |a: usize, b: usize| pairs.get(a, b).copied();
    let others = |a: usize| (0..pairs.cameras()).filter(move |b| *b != a);
    let all = || (0..pairs.cameras()).flat_map(|a| others(a).filter_map(move |b| of(a, b)));
    if all().all(|pair| pair.lasting.is_none() && pair.moving.is_none()) {
        let is_informative = |a: &usize| {
            others(*a).filter_map(|b| of(*a, b)).any(|pair| pair.unmatched >= INFORMATIVE_UNMATCHED)
        };
        let informative = (0..pairs.cameras()).filter(is_informative).count();
        return (informative > 1).then_some(SharedWarning { footprints: None });
    }
    let one_way = |a: usize, b: usize| of(a, b)?.lasting;
    let fits_of = |fit: &dyn Fn(usize, usize) -> Option<(f32, u64)>| -> Vec<(f32, u64)> {
        (0..pairs.cameras()).flat_map(|a| others(a).filter_map(move |b| fit(a, b))).collect()
    };
    let mutual = fits_of(&|a, b| {
        let [there, back] = [one_way(a, b)?, one_way(b, a)?];
        Some((off(there).max(off(back)), there.samples.min(back.samples)))
    });
    let one_sided = || fits_of(&|a, b| one_way(a, b).map(|fit| (off(fit), fit.samples)));
    let fits = if mutual.is_empty() { one_sided() } else { mutual };
    let is_informative = fits.iter().any(|(_, samples)| *samples >= INFORMATIVE_SAMPLES);
    let best = fits.iter().map(|(off, _)| *off).reduce(f32::min).filter(|_| is_informative)?;
    (best > SUSPECT_POSE_FOOTPRINTS + granted_footprints).then_some(SharedWarning { footprints: Some(best) })
}

/// The cameras that fit no other as well as the others fit each other; see [`PairResiduals`] for `pairs`. Where no others can be
/// compared, only clocks are suspect, and all of them; the rest is left to the warning about all cameras.
#[must_use]
pub fn calibration_warnings(pairs: &PairTable<PairResiduals>) -> Vec<CalibrationWarning> {
    let mut calibration_warnings = warnings_over(pairs, false, |pair| pair.lasting.map(off));
    let moving = warnings_over(pairs, true, |pair| Some(pair.moving?.median_footprints));
    let wrong_poses = calibration_warnings.len();
    for warning in moving {
        if calibration_warnings[..wrong_poses].iter().all(|pose| pose.camera != warning.camera) {
            calibration_warnings.push(warning);
        }
    }
    calibration_warnings
}

/// The warnings by one number of each pair; a pair that is missing counts for nothing.
fn warnings_over(
    pairs: &PairTable<PairResiduals>,
    over_time: bool,
    of: impl Fn(&PairResiduals) -> Option<f32>,
) -> Vec<CalibrationWarning> {
    let of = |a: usize, b: usize| of(pairs.get(a, b)?);
    // The others that each camera can be compared with, those it fits best first.
    let partners = |camera: usize| {
        let off = |other: usize| of(camera, other).into_iter().chain(of(other, camera)).reduce(f32::max);
        let others = (0..pairs.cameras()).filter(|other| *other != camera);
        let mut partners: Vec<(f32, usize)> = others.filter_map(|other| Some((off(other)?, other))).collect();
        partners.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        partners
    };
    let partners: Vec<_> = (0..pairs.cameras()).map(partners).collect();
    let is_mutual = |a: usize, b: usize| of(a, b).is_some() && of(b, a).is_some();
    let warning = |camera: usize| {
        let footprints = partners[camera].first()?.0;
        // Where only one of two cameras finds things in the other's picture, they see next to nothing in common.
        if partners[camera].iter().all(|(_, other)| !is_mutual(camera, *other)) {
            return None;
        }
        let best_without = |a: usize| {
            let counts = |other: usize| other != camera && is_mutual(a, other);
            Some(partners[a].iter().find(|(_, other)| counts(*other))?.0)
        };
        let others = (0..pairs.cameras()).filter(|other| *other != camera);
        let mut usual: Vec<f32> = others.filter_map(best_without).collect();
        let usual_footprints = median_f32(&mut usual);
        let limit = match (over_time, usual_footprints) {
            (false, None) => return None,
            (false, Some(usual)) => SUSPECT_POSE_FOOTPRINTS.max(SUSPECT_RATIO * usual),
            (true, None) => SUSPECT_CLOCK_ALONE_FOOTPRINTS,
            (true, Some(usual)) => SUSPECT_CLOCK_FOOTPRINTS.max(SUSPECT_RATIO * usual),
        };
        (footprints > limit).then_some(CalibrationWarning { camera, over_time, footprints, usual_footprints })
    };
    (0..pairs.cameras()).filter_map(warning).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals of cameras, each as far off as its entry says from all others.
    fn pairs(off: &[f32], moving: &[f32]) -> Vec<Vec<PairResiduals>> {
        let residual = |off: f32| Residual {
            samples: 1000,
            median_footprints: off / 2.0,
            most_footprints: off,
            median_color_steps: 1.0,
        };
        let pair = |a: usize, b: usize| PairResiduals {
            lasting: (a != b).then(|| residual(off[a].max(off[b]))),
            moving: (a != b).then(|| residual(moving[a].max(moving[b]))),
            unmatched: 0,
        };
        (0..off.len()).map(|a| (0..off.len()).map(|b| pair(a, b)).collect()).collect()
    }

    fn doubted(pairs: &[Vec<PairResiduals>]) -> Vec<CalibrationWarning> {
        calibration_warnings(&pairs.to_vec().into())
    }

    fn shared(pairs: &[Vec<PairResiduals>], granted_footprints: f32) -> Option<SharedWarning> {
        shared_warning(&pairs.to_vec().into(), granted_footprints)
    }

    #[test]
    fn the_camera_that_fits_no_other_is_doubted_and_those_it_does_not_fit_are_not() {
        let found = doubted(&pairs(&[0.01, 0.9, 0.02, 0.01], &[0.1, 1.2, 0.1, 0.1]));
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].camera, found[0].over_time, found[0].footprints), (1, false, 0.9));
        let found = doubted(&pairs(&[0.01; 4], &[0.02, 0.01, 0.02, 0.6]));
        assert_eq!(found.iter().map(|d| (d.camera, d.over_time)).collect::<Vec<_>>(), [(3, true)]);
    }

    #[test]
    fn pairs_that_a_report_lacks_say_nothing() {
        let mut part = pairs(&[0.01, 0.9, 0.02, 0.01], &[0.1; 4]);
        part[3].clear();
        part[0].truncate(3);
        assert_eq!(doubted(&part).iter().map(|warning| warning.camera).collect::<Vec<_>>(), [1]);
    }

    #[test]
    fn a_camera_that_is_seen_but_sees_no_other_is_not_doubted_nor_makes_others_look_worse() {
        let mut one_sided = pairs(&[0.01, 0.9, 0.02, 0.01], &[0.1; 4]);
        one_sided[1].fill(PairResiduals::default());
        assert!(doubted(&one_sided).is_empty());
        let mut hardly_seen = pairs(&[0.05, 0.3, 0.05, 0.0], &[0.1; 4]);
        for (a, row) in hardly_seen.iter_mut().enumerate().take(3) {
            row[3].lasting = (a != 1)
                .then_some(row[3].lasting)
                .flatten()
                .map(|fits| Residual { most_footprints: 0.0, ..fits });
        }
        hardly_seen[3].fill(PairResiduals::default());
        assert!(doubted(&hardly_seen).is_empty());
    }

    #[test]
    fn where_all_are_off_alike_nobody_is_accused_and_what_all_share_is_doubted() {
        let alike = pairs(&[0.8, 0.9, 1.1], &[0.8, 0.9, 1.1]);
        assert!(doubted(&alike).is_empty());
        assert_eq!(shared(&alike, 0.0), Some(SharedWarning { footprints: Some(0.9) }));
        assert_eq!(shared(&alike, 0.7), None, "noise explains it");
        let two = pairs(&[0.9, 0.9], &[0.1, 0.1]);
        assert!(doubted(&two).is_empty());
        let sentence = shared(&two, 0.0).unwrap().sentence();
        for key in ["depth_kind", "depth_unit_scale_factor", "lens", "0.90"] {
            assert!(sentence.contains(key), "{sentence}");
        }
        assert_eq!(shared(&pairs(&[0.01, 0.9, 0.02, 0.01], &[0.1; 4]), 0.0), None, "two agree");
        let mut one_sided = pairs(&[14.0; 2], &[0.1; 2]);
        one_sided[0][1] = PairResiduals::default();
        assert_eq!(shared(&one_sided, 0.0), Some(SharedWarning { footprints: Some(14.0) }));
        let mut round = alike.clone();
        for lasting in round.iter_mut().flatten().filter_map(|pair| pair.lasting.as_mut()) {
            lasting.median_footprints = 0.01;
        }
        assert_eq!(shared(&round, 0.0), None, "silhouettes are a large part of a small round thing");
        let mut few = alike;
        for lasting in few.iter_mut().flatten().filter_map(|pair| pair.lasting.as_mut()) {
            lasting.samples = INFORMATIVE_SAMPLES - 1;
        }
        assert_eq!(shared(&few, 0.0), None, "silhouettes may be most of them");
    }

    #[test]
    fn where_no_camera_finds_what_another_sees_depth_and_lens_are_doubted() {
        let unmatched = |count| vec![vec![PairResiduals { unmatched: count, ..Default::default() }; 2]; 2];
        assert_eq!(shared(&unmatched(5000), 0.0), Some(SharedWarning { footprints: None }));
        assert_eq!(shared(&unmatched(400), 0.0), None);
        assert_eq!(shared(&[], 0.0), None);
    }

    #[test]
    fn the_clocks_of_two_cameras_are_doubted_only_where_silhouettes_cannot_be_the_reason() {
        assert!(doubted(&pairs(&[0.01; 2], &[0.46; 2])).is_empty());
        let found = doubted(&pairs(&[0.01; 2], &[15.75; 2]));
        assert_eq!(
            found.iter().map(|warning| (warning.camera, warning.over_time)).collect::<Vec<_>>(),
            [(0, true), (1, true)]
        );
        assert!(!found[0].sentence("a").contains("others"), "{}", found[0].sentence("a"));
    }
}
