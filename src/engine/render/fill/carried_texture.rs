//! Texture for hole pixels: the surface that a hole is filled from goes on in its own plane, mirrored at the hole's rim.
//!
//! ```text
//!      near | hole p ··d·· | r ··t·· q   far        p: hole pixel   r: rim   q: where its texture comes from
//!                          |                        r halves the way from p to q on the surface, not in the picture
//! ```
//!
//! The pyramid gives a hole pixel the colors around it without their fine detail. What is added here is the detail at q: its color
//! less the mean that the same blocks of the pyramid would give at q. So detail is carried on where it is there, shading goes on
//! smoothly, and both meet the rim without a seam.
//!
//! Sources: mirroring at a boundary is the symmetric extension of signal processing; adding detail to a smooth fill separates
//! texture from structure as Bertalmio, Vese, Sapiro and Osher do, *Simultaneous Structure and Texture Image Inpainting*, 2003.
//! What differs: mirroring is done in perspective, along lines of the picture, on which the inverse depth of a plane is linear. No
//! patch is searched for: which one is best changes abruptly with the viewpoint, and holes would boil in motion.

use super::pyramid::{LevelWeights, Pyramid};
use super::rays::{HoleNeighbors, STEPS};
use super::surface::{HoleSurface, SurfaceTolerance};
use crate::render::vantage::{NO_IMAGE, Picture};

/// Pixels beyond the rim over which the slope of a surface is measured. What is narrower has no texture to carry on.
const SLOPE_PX: usize = 6;

/// At this distance from the rim half of the detail is carried on. The farther, the less likely it is right: without fading, pictures lose
/// two to three times as much accuracy, and holes are no more pleasing.
const FADE_PX: f32 = 6.0;

/// Texture is carried on where it lies up to this many times as far from the rim as the hole pixel: a surface that is seen ever more
/// edge on has no more of it.
const MAX_STRETCH: f32 = 3.0;

/// Weights of directions fall with this power of the distance when the nearer side of a hole is told from the farther one.
const SIDE_POWER: i32 = 4;

/// The same for directions of one side: what they see lies on one rim, of which the mean is steadier than the nearest pixel.
const RIM_POWER: i32 = 2;

/// The same for the two sides: a power so high that their textures are mixed in the middle of the hole alone.
const MIX_POWER: i32 = 6;

/// Detail needs at least this share of a pixel's worth of samples at its origin.
const LEAST_SHOWN: f32 = 0.05;

/// Carries the texture around holes into them.
pub(super) struct CarriedTexture<'a> {
    pub(super) picture: &'a Picture,
    /// [`NO_IMAGE`] for each pixel that holes are not filled from.
    pub(super) sources: &'a [u32],
    pub(super) pyramid: &'a Pyramid,
    pub(super) tolerance: SurfaceTolerance,
}

/// Where the texture of a hole pixel comes from, on one side of the hole.
#[derive(Clone, Copy, Default)]
struct Origin {
    x: f32,
    y: f32,
    /// Inverse depth of the surface there.
    w: f32,
    weight: f32,
}

impl CarriedTexture<'_> {
    /// The detail for hole pixel `(x, y)`, which sees `seen` of `surface`, whose smooth color is blended from levels with `levels`
    /// weights: the difference of its color from that, linear Rec.709.
    pub(super) fn detail(
        &self,
        (x, y): (usize, usize),
        seen: &HoleNeighbors,
        surface: &HoleSurface,
        levels: &LevelWeights,
    ) -> [f32; 3] {
        let mut found: [Option<Origin>; 8] = [None; 8];
        let mut toward = (0.0, 0.0);
        for direction in (0..8).filter(|direction| surface.directions >> direction & 1 == 1) {
            let weight = seen.distance_px[direction].powi(-SIDE_POWER);
            let step = unit(direction);
            toward = (toward.0 + weight * step.0, toward.1 + weight * step.1);
            found[direction] = self.origin((x, y), seen, direction);
        }
        let length = toward.0.hypot(toward.1);
        if length == 0.0 {
            return [0.0; 3];
        }
        // One side of the hole after the other: in the middle of a hole both count, and neither blurs the other before that.
        let (mut sum, mut weights) = ([0.0; 3], 0.0_f32);
        for side in [1.0, -1.0] {
            let mut origin = Origin::default();
            for (direction, found) in found.iter().enumerate() {
                let Some(found) = found else { continue };
                let step = unit(direction);
                let cosine = side * (step.0 * toward.0 + step.1 * toward.1) / length;
                let weight = found.weight * cosine.max(0.0).powi(2);
                origin.x += weight * found.x;
                origin.y += weight * found.y;
                origin.w += weight * found.w;
                origin.weight += weight;
            }
            if origin.weight > 0.0 {
                let scale = origin.weight.recip();
                let at = (origin.x * scale, origin.y * scale);
                let rim_px = 0.5 * (at.0 - x as f32).hypot(at.1 - y as f32);
                let weight = rim_px.powi(-MIX_POWER);
                if let Some((detail, shown)) = self.detail_at(at, origin.w * scale, surface, levels) {
                    let fade = FADE_PX / (FADE_PX + rim_px);
                    (0..3).for_each(|channel| sum[channel] += weight * shown * fade * detail[channel]);
                    weights += weight * shown;
                }
            }
        }
        if weights > 0.0 { sum.map(|sum| sum / weights) } else { sum }
    }

    /// Where the texture of a hole pixel comes from in a direction in which it sees its surface.
    fn origin(&self, (x, y): (usize, usize), seen: &HoleNeighbors, direction: usize) -> Option<Origin> {
        let depths = self.picture.inverse_depth.as_slice();
        let (width, height) = self.picture.image.size();
        let rim = seen.pixel[direction];
        let (dx, dy) = STEPS[direction];
        let (mut at, mut w, mut steps) = ((rim % width, rim / width), depths[rim], 0);
        while steps < SLOPE_PX {
            let next = at.0.checked_add_signed(dx).zip(at.1.checked_add_signed(dy));
            let Some(next) = next.filter(|next| next.0 < width && next.1 < height) else { break };
            let pixel = next.1 * width + next.0;
            let next_w = depths[pixel];
            let is_same = self.sources[pixel] != NO_IMAGE
                && next_w.max(w) <= next_w.min(w) * self.tolerance.factor(1.0);
            if !is_same {
                break;
            }
            (at, w, steps) = (next, next_w, steps + 1);
        }
        // In steps, of which a diagonal one is longer: the surface is linear in them as well.
        let distance = seen.distance_px[direction] / length_of_step(direction);
        let slope = (w - depths[rim]) / steps as f32;
        let there = depths[rim] - 2.0 * slope * distance;
        let beyond = distance * depths[rim] / there;
        let is_sound = steps == SLOPE_PX && there > 0.0 && beyond <= MAX_STRETCH * distance;
        is_sound.then(|| Origin {
            x: x as f32 + dx as f32 * (distance + beyond),
            y: y as f32 + dy as f32 * (distance + beyond),
            w: depths[rim] + slope * beyond,
            weight: seen.distance_px[direction].powi(-RIM_POWER),
        })
    }

    /// The detail at a place, in pixels from the center of the first, where the surface is expected at inverse depth `w`, and which share
    /// of a pixel shows it; `None` where it is not shown.
    fn detail_at(
        &self,
        (x, y): (f32, f32),
        w: f32,
        surface: &HoleSurface,
        levels: &LevelWeights,
    ) -> Option<([f32; 3], f32)> {
        let (width, height) = self.picture.image.size();
        if !(x >= 0.0 && y >= 0.0 && x <= (width - 1) as f32 && y <= (height - 1) as f32) {
            return None;
        }
        let (left, top) = (x as usize, y as usize);
        let (along, down) = (x - left as f32, y - top as f32);
        let factor = self.tolerance.factor(surface.reach_px);
        let (mut color, mut shown) = ([0.0; 3], 0.0);
        for corner in 0..4 {
            let (right, below) = (corner & 1, corner >> 1);
            let share =
                (if right == 1 { along } else { 1.0 - along }) * (if below == 1 { down } else { 1.0 - down });
            let pixel = (top + below).min(height - 1) * width + (left + right).min(width - 1);
            let found = self.picture.inverse_depth.as_slice()[pixel];
            if self.sources[pixel] != NO_IMAGE && found.max(w) <= found.min(w) * factor {
                let from = self.picture.color.as_slice()[pixel];
                (0..3).for_each(|channel| color[channel] += share * from[channel]);
                shown += share;
            }
        }
        if shown < LEAST_SHOWN {
            return None;
        }
        let nearest = ((x + 0.5) as usize, (y + 0.5) as usize);
        let smooth = self.pyramid.mean_at(nearest, levels, w, self.tolerance)?;
        Some(([0, 1, 2].map(|channel| color[channel] / shown - smooth[channel]), shown))
    }
}

/// A direction of [`STEPS`], of length 1.
fn unit(direction: usize) -> (f32, f32) {
    let (dx, dy) = STEPS[direction];
    let length = length_of_step(direction);
    (dx as f32 / length, dy as f32 / length)
}

/// The length of a step of [`STEPS`].
fn length_of_step(direction: usize) -> f32 {
    [1.0, std::f32::consts::SQRT_2][direction % 2]
}
