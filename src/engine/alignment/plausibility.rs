//! What is farther off than rigs are is evidence of something else, and is said rather than corrected.

use glam::{DAffine3, DQuat};

use super::color_lens::UNKNOWNS;

/// The poses of rigs are off by no more: radians, and typical depths. What is farther off is misread.
const MOST_TURN: f64 = 0.15;
const MOST_SHIFT: f64 = 0.15;

/// Two sensors of one device differ by less: the unknowns of a color lens, in their order.
const MOST: [f64; UNKNOWNS] = [0.18, 0.15, 0.15, 0.15, 0.12, 0.12, 0.12, 0.1, 0.1];

/// Whether the pose of a rig may be off by this change; `inverse_depth` is of a typical depth.
pub(super) fn is_of_a_rig(change: &DAffine3, inverse_depth: f64) -> bool {
    let turn = DQuat::from_mat3(&change.matrix3).to_scaled_axis().length();
    turn < MOST_TURN && change.translation.length() * inverse_depth < MOST_SHIFT
}

/// Whether two sensors of one device may differ by these unknowns of a color lens.
pub(super) fn is_of_one_device(unknowns: &[f64; UNKNOWNS]) -> bool {
    unknowns.iter().zip(MOST).all(|(value, most)| value.abs() < most)
}
