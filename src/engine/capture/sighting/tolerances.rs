//! What counts as the same depth when a point of one camera is looked for in another, by the one who asks.

use super::Tolerance;

/// Choice of views: the noise of real sensors, which one pixel shows in full.
pub const CHOSEN_VIEWS: Tolerance = Tolerance::up_to(0.03);

/// Rows of turned pictures: colors are compared, so that the surface has to be the same, whatever the noise of depth.
pub const TURNED_PICTURES: Tolerance = Tolerance::up_to(0.02);

/// Which cameras overlap: before the alignment, poses may be far off, and depths with them.
pub const OVERLAPS: Tolerance = Tolerance::below(0.15);

/// Samples that determine a color lens: only the color lens is in doubt, not the pose.
pub const COLOR_LENS_MATCHES: Tolerance = Tolerance::below(0.03);

/// Normals that are carried into the pixels of color: both depths were measured by one sensor.
pub const REGISTERED_NORMALS: Tolerance = Tolerance::below(0.02);

/// Points of a true picture that a camera saw: one of nine pixels has to be as close, so that noise needs no wider tolerance.
pub const SEEN_POINTS: Tolerance = Tolerance::found_below(0.015);

/// The sample that a pixel of a rendered picture was painted from: the picture is as exact as the samples, so that what is farther off is
/// another surface.
pub const PAINTED_SAMPLE: Tolerance = Tolerance::below(0.01);

/// A mark in the rendered picture: depths of surfaces that are splatted over each other are blended there.
pub const MARKED_SURFACE: Tolerance = Tolerance::below(0.03);

/// Kept samples that other cameras confirm or look past, after pruning: the noise of real sensors, as for the choice of views.
pub const KEPT_SAMPLES: Tolerance = Tolerance::up_to(0.03);
