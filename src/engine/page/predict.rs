//! Predictions of numbers from neighbors that are decoded already.
//!
//! Source: for colors the median edge detector of LOCO-I (Weinberger et al., *The LOCO-I Lossless Image Compression Algorithm*, IEEE
//! TIP 2000). Inverse depth is linear in the pixels of a plane, so that `left + above − corner` is exact on planes, across whose
//! edges the detector would clip it.

/// A pixel without a sample, or beyond what is decoded.
pub(super) const MISSING: i32 = -1;

/// Neighbors whose depths differ by more quanta than this are of different surfaces.
const EDGE: i32 = 256;

/// Neighbors whose depths differ by at most this many quanta are of a smooth surface.
const SMOOTH: i32 = 12;

/// Quantized inverse depths around a pixel; [`MISSING`] where there is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthsAround {
    pub(super) left: i32,
    pub(super) above: i32,
    pub(super) corner: i32,
    /// Two to the left.
    pub(super) left2: i32,
    /// Two above.
    pub(super) above2: i32,
    /// The sample before in storage order, 0 at first.
    pub(super) before: i32,
}

impl DepthsAround {
    /// The prediction, never negative, and whether it is of a smooth surface.
    pub(super) fn predicted(&self) -> (i32, bool) {
        let Self { left, above, corner, left2, above2, before } = *self;
        if left == MISSING && above == MISSING {
            return (before, false);
        }
        if left == MISSING {
            return (continued(above, above2), false);
        }
        if above == MISSING {
            return (continued(left, left2), false);
        }
        if corner == MISSING {
            return (left, false);
        }
        if left == 0 || above == 0 {
            return (if corner == 0 { left.max(above) } else { 0 }, left == above);
        }
        let (down, across) = ((left - corner).abs(), (above - corner).abs());
        if down > EDGE && across > EDGE {
            return (left, false);
        }
        ((left + above - corner).max(0), down <= SMOOTH && across <= SMOOTH)
    }
}

/// What follows `near` and, before it, `far`.
fn continued(near: i32, far: i32) -> i32 {
    if near == 0 || far == MISSING || (near - far).abs() > EDGE { near } else { (2 * near - far).max(0) }
}

/// How colors are predicted, chosen for each image.
pub(super) const PREDICTORS: u8 = 2;

/// One channel of the colors around a pixel that has both neighbors and the corner.
pub(super) fn predicted_channel(predictor: u8, left: i32, above: i32, corner: i32) -> i32 {
    if predictor == 0 {
        let plane = left + above - corner;
        return plane.clamp(left.min(above), left.max(above));
    }
    // Averages the noise of both, which the detector does not.
    ((3 * (left + above) - 2 * corner + 2) >> 2).clamp(0, 255)
}

/// Which of four streams a green residual goes to, by how much the greens around differ.
pub(super) fn activity_context(differences: i32) -> usize {
    match differences {
        ..=3 => 0,
        4..=10 => 1,
        11..=28 => 2,
        _ => 3,
    }
}

/// Which of three streams the residuals of red and blue go to, by that of green.
pub(super) fn green_context(residual: u8) -> usize {
    match (residual as i8).unsigned_abs() {
        0..=1 => 0,
        2..=6 => 1,
        _ => 2,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn around(left: i32, above: i32, corner: i32) -> DepthsAround {
        DepthsAround { left, above, corner, left2: MISSING, above2: MISSING, before: 77 }
    }

    #[test]
    fn planes_are_predicted_exactly_and_edges_from_their_own_side() {
        assert_eq!(around(1005, 1003, 1000).predicted(), (1008, true));
        // Left and corner are of the far surface, above is of the near one.
        assert_eq!(around(1000, 5000, 1000).predicted().0, 5000);
        assert_eq!(around(5000, 1000, 9000).predicted().0, 5000);
        assert_eq!(around(MISSING, MISSING, 3).predicted(), (77, false));
    }

    #[test]
    fn what_lies_between_sky_and_surface_is_never_in_the_air() {
        assert_eq!(around(0, 0, 0).predicted(), (0, true));
        assert_eq!(around(0, 900, 0).predicted().0, 900);
        assert_eq!(around(0, 900, 905).predicted().0, 0);
        assert_eq!(around(0, MISSING, MISSING).predicted().0, 0);
    }
}
