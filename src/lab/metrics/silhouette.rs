//! Pixels near a step in depth. Errors there (grown or frayed outlines, background colors) vanish in a mean over the whole
//! picture.

use overlook_engine::grid::Grid;

/// Farthest distance of a silhouette pixel from a step in depth, pixels.
pub(super) const REACH_PX: f64 = 3.0;

/// A step is a second difference of inverse depth, which vanishes on every plane, of this share of the nearest depth
/// involved. A crease that turns by 90° where a surface is 1000 pixels away gives a tenth of it.
const STEP_RELATIVE: f32 = 0.02;

/// The pixels within [`REACH_PX`] of a step in depth, given inverse depths (0 at infinity, negative where unknown;
/// next to the unknown nothing is a step).
pub(super) fn near_silhouettes(inverse_depth: &Grid<f32>) -> Grid<bool> {
    let (width, height) = inverse_depth.size();
    let reach = REACH_PX as usize;
    let mut near = Grid::filled(width, height, false);
    for y in 0..height {
        for x in 0..width {
            if !is_step(inverse_depth, x, y) {
                continue;
            }
            for ny in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                for nx in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                    let distance = (nx as f64 - x as f64).hypot(ny as f64 - y as f64);
                    near[(nx, ny)] |= distance <= REACH_PX;
                }
            }
        }
    }
    near
}

fn is_step(inverse_depth: &Grid<f32>, x: usize, y: usize) -> bool {
    let (width, height) = inverse_depth.size();
    let middle = inverse_depth[(x, y)];
    let steps = |before: f32, after: f32| {
        let nearest = before.max(middle).max(after);
        before.min(middle).min(after) >= 0.0
            && (before - 2.0 * middle + after).abs() > STEP_RELATIVE * nearest
    };
    let across = x > 0 && x + 1 < width && steps(inverse_depth[(x - 1, y)], inverse_depth[(x + 1, y)]);
    let down = y > 0 && y + 1 < height && steps(inverse_depth[(x, y - 1)], inverse_depth[(x, y + 1)]);
    across || down
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_has_no_silhouette_however_steep_and_a_step_has_one_three_pixels_wide() {
        let plane = Grid::from_fn(20, 20, |x, y| 0.01 + 0.05 * x as f32 + 0.02 * y as f32);
        assert!(near_silhouettes(&plane).as_slice().iter().all(|near| !near));
        let step = Grid::from_fn(20, 9, |x, _| if x < 10 { 1.0 } else { 0.5 });
        let near = near_silhouettes(&step);
        for y in 0..9 {
            for x in 0..20 {
                assert_eq!(near[(x, y)], (6..=13).contains(&x), "{x} {y}");
            }
        }
    }

    #[test]
    fn an_object_before_the_sky_has_a_silhouette_and_unknown_depth_has_none() {
        let sky = Grid::from_fn(9, 9, |x, _| if x < 4 { 0.3 } else { 0.0 });
        assert!(near_silhouettes(&sky)[(4, 4)]);
        let unknown = Grid::from_fn(9, 9, |x, _| if x < 4 { 0.3 } else { -1.0 });
        assert!(near_silhouettes(&unknown).as_slice().iter().all(|near| !near));
    }
}
