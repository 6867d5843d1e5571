//! Hole filling: colors and inverse depths for pixels that no sample reached, taken from the surface behind.
//!
//! Sources: Gortler, Grzeszczuk, Szeliski and Cohen, *The Lumigraph*, 1996, §3.4 (pull: average to coarser levels; push:
//! fill what is missing from them); Grossman and Dally, *Point Sample Rendering*, 1998 (the same for point samples); Solh
//! and `AlRegib`, *Hierarchical Hole-Filling for Depth-Based View Synthesis*, 2012 (depth: a hole beside a near object is
//! background that the object used to hide, so the near side must stay out of it).
//!
//! What differs: a pyramid in which the farther side always wins grows the near side wherever a coarse cell holds nothing
//! else, and lets a sliver of sky win over a whole wall elsewhere. So the surface is chosen first (`surface`), for every hole
//! pixel by itself, among the painted pixels that it sees across its own hole (`rays`); the pyramid (`pyramid`) then
//! blends colors of that surface alone. A round thing that was seen in part goes on before all others (`round`). Last, neighbors in a hole
//! are joined (`around`).
//!
//! ```text
//!      near  near  near |  hole  hole  hole  hole | far  far      across the hole two surfaces face each other: the farther
//!                  ◀──────── p ──────────────────▶                one is what was hidden
//!
//!      near  near | hole | near  near                             one surface on both sides: a gap in it
//! ```
//!
//! The mask is kept: [`Picture::image`] stays [`NO_IMAGE`] in filled pixels, and pixels that are painted as a whole are not touched. What
//! is painted of others is put over what fills the rest (`partial`).
//!
//! Pixels that are shown in part: what fills the hole beside or behind them shows in the rest of them.
//!
//! ```text
//!      near  near | n h | hole  hole        h: the share that no sample covers. It shows what fills the holes beside
//!                   ▲                          the pixel, or the pixel itself if that counts as a hole.
//! ```
//!
//! Source: Porter and Duff, *Compositing Digital Images*, SIGGRAPH 1984 (coverage as alpha; `over`). What differs: what lies below is
//! found by filling.

mod around;
mod pyramid;
mod rays;
mod round;
mod surface;

use rayon::prelude::*;

use super::environment::{Environment, PixelDirections};
use super::free_space::{HOLE, HolePlace, OPEN_HOLE, RayTest, SKY_HOLE, hidden_surface_limit, sky_share};
use super::vantage::{NO_IMAGE, Picture, pixels_around};
use crate::capture::Camera;
use crate::settings::{Fill, RenderSettings};
use around::{Filling, FillingsAround};
use pyramid::Pyramid;
use rays::{HoleNeighbors, HoleRays};
use round::{RoundThings, RoundVotes};
use surface::{SurfaceTolerance, surface_behind};

/// Surfaces that face each other across a hole in more of the four directions go on through it.
const MOST_FACING: usize = 1;

/// Fills the holes of `picture` as the settings demand. Sets color and inverse depth, which is then 0 or more; [`Picture::image`]
/// stays [`NO_IMAGE`]. A picture without any sample is left as it is.
pub fn fill(picture: &mut Picture, target: &Camera, settings: &RenderSettings) {
    fill_tested(picture, target, settings, TestedHoles::default(), &mut FillPlanes::default());
}

/// What is known of holes whose lines of sight were tested; nothing by default.
#[derive(Clone, Copy, Default)]
pub(super) struct TestedHoles<'a> {
    /// The sky, where any camera saw it.
    pub(super) environment: Option<&'a Environment>,
    /// Pixels whose colors may be blended with the sky.
    pub(super) blended: &'a [usize],
    /// Per pixel, the share of its line of sight that is hidden: the more of it, the less of the sky is shown.
    pub(super) hidden_share: &'a [f32],
    /// What cameras know of lines of sight, where any saw the sky.
    pub(super) test: Option<&'a RayTest<'a>>,
}

/// Of larger pictures the memory of [`FillPlanes`] is given back, pixels: they take 90 bytes a pixel.
const MOST_KEPT_PIXELS: usize = 1 << 20;

/// What filling works on, kept from picture to picture.
#[derive(Debug, Default)]
pub(super) struct FillPlanes {
    /// For each pixel whether it is an open hole that shows the sky rather than a surface; empty without open holes.
    is_open: Vec<bool>,
    /// All that holes may be filled from, and surfaces alone.
    sources: [FillSources; 2],
    /// What fills the holes of each row.
    filled: Vec<Vec<Filling>>,
    around: FillingsAround,
}

/// As [`fill`], but with the sky where holes show it. Where they hide a surface, colors that may be blended with the sky are not used.
pub(super) fn fill_tested(
    picture: &mut Picture,
    target: &Camera,
    settings: &RenderSettings,
    tested: TestedHoles<'_>,
    planes: &mut FillPlanes,
) {
    if settings.fill == Fill::None {
        return;
    }
    let image = picture.image.as_slice();
    let is_hole = |image: &u32| *image == NO_IMAGE;
    let are_all_holes = image.par_iter().with_min_len(4096).all(is_hole);
    if are_all_holes || !image.par_iter().with_min_len(4096).any(is_hole) {
        picture.coverage.clear();
        if are_all_holes {
            // What covers less than half of a pixel is not shown without anything that fills the rest.
            picture.color.as_mut_slice().fill([0.0; 3]);
        }
        return;
    }
    let partial = PartialPixels::take(picture);
    fill_holes(picture, target, settings, tested, planes);
    partial.put_over(picture);
    if picture.image.len() > MOST_KEPT_PIXELS {
        *planes = FillPlanes::default();
    }
}

/// Fills all holes as [`fill_tested`] does, as if none were shown in part.
fn fill_holes(
    picture: &mut Picture,
    target: &Camera,
    settings: &RenderSettings,
    tested: TestedHoles<'_>,
    planes: &mut FillPlanes,
) {
    let FillPlanes { is_open, sources: [of_all, of_surfaces], filled, around } = planes;
    let TestedHoles { environment, blended, hidden_share, .. } = tested;
    let size = picture.image.size();
    let width = size.0;
    if let Some(environment) = environment {
        fill_sky(picture, target, environment, |_, depth| depth == SKY_HOLE);
    }
    let sky = environment.map(|environment| {
        of_all.find_open_holes(picture, is_open);
        HoleSky { environment, directions: PixelDirections::new(target), hidden_share, is_open }
    });
    let depths = picture.inverse_depth.as_slice();
    let is_unfilled = |depth: &f32| *depth < 0.0;
    // Where a surface is hidden, the hole is not filled from the sky.
    let hides_surface = |depth: &f32| *depth < HOLE;
    let tolerance = SurfaceTolerance::new(target, settings);
    let any_depth = |holds: &(dyn Fn(&f32) -> bool + Sync)| depths.par_iter().with_min_len(4096).any(holds);
    let all = any_depth(&|depth| is_unfilled(depth) && !hides_surface(depth));
    let viewpoint = tested.test.map(|_| target);
    let all = all.then(|| of_all.set(picture, tolerance, |depth| depth >= 0.0, &[], viewpoint));
    let surfaces = any_depth(&hides_surface);
    let surfaces =
        surfaces.then(|| of_surfaces.set(picture, tolerance, |depth| depth > 0.0, blended, viewpoint));
    let images = picture.image.as_slice();
    let is_sky = |pixel: usize| depths[pixel] == 0.0 && images[pixel] == NO_IMAGE;
    let fill_row = |(y, row): (usize, &[f32])| -> Vec<Filling> {
        let fill_pixel = |x: usize| {
            if row[x] == 0.0 {
                return Some(Filling { x, surface: None, sky_share: 1.0 });
            }
            let sources = if hides_surface(&row[x]) { surfaces } else { all }?;
            let limit = hidden_surface_limit(row[x]);
            let seen = sources.rays.neighbors((x, y));
            let votes = sources.votes(depths, (x, y), &seen, tested.test);
            let surface = surface_behind(depths, &seen, limit, votes.covering, tolerance);
            let pushed = sources.pyramid.push((x, y), surface.as_ref(), tolerance);
            let filling = pushed.or_else(|| Some(surface.as_ref()?.mean(picture, &seen)))?;
            let sky_share = sky.as_ref().map_or(0.0, |sky| sky.share(y * width + x, row[x]));
            Some(Filling { x, surface: Some(filling), sky_share: votes.sky_share(sky_share) })
        };
        let is_filled = |x: &usize| is_unfilled(&row[*x]) || is_sky(y * width + x);
        (0..width).filter(is_filled).filter_map(fill_pixel).collect()
    };
    depths.par_chunks(width).enumerate().map(fill_row).collect_into_vec(filled);
    around.set(filled, width);
    let rows = picture.color.as_mut_slice().par_chunks_mut(width);
    let rows = rows.zip(picture.inverse_depth.as_mut_slice().par_chunks_mut(width));
    rows.zip(filled).enumerate().for_each(|(y, ((colors, inverse_depths), filled))| {
        let mut reader = sky.as_ref().map(|sky| (sky, sky.environment.reader()));
        for &mut Filling { x, surface, .. } in filled {
            let Some(surface) = surface else { continue };
            let (mean, sky_share) = around.mean((x, y));
            // Beside what is shown the choice is sure.
            let is_sure = pixels_around(y * width + x, size).any(|there| images[there] != NO_IMAGE);
            let color = if is_sure { surface.color } else { mean };
            (colors[x], inverse_depths[x]) = (color, surface.inverse_depth);
            if let Some((sky, reader)) = reader.as_mut().filter(|_| sky_share > 0.0) {
                let beyond = reader.color(sky.directions.at((x, y)));
                colors[x] = [0, 1, 2].map(|nth| color[nth] + sky_share * (beyond[nth] - color[nth]));
                inverse_depths[x] = if sky_share < 0.5 { surface.inverse_depth } else { 0.0 };
            }
        }
    });
}

/// The sky in holes that may show it.
struct HoleSky<'a> {
    environment: &'a Environment,
    directions: PixelDirections,
    /// As in [`TestedHoles`].
    hidden_share: &'a [f32],
    /// As in [`FillPlanes`].
    is_open: &'a [bool],
}

impl HoleSky<'_> {
    /// The share of the sky in a pixel of a hole, whose inverse depth is `hole`.
    fn share(&self, pixel: usize, hole: f32) -> f32 {
        let place = match hole {
            HOLE.. => return 0.0,
            OPEN_HOLE if self.is_open[pixel] => HolePlace::Open,
            OPEN_HOLE => HolePlace::Facing,
            _ => HolePlace::Enclosed,
        };
        sky_share(place, self.hidden_share[pixel])
    }
}

/// The pixels that holes are filled from.
#[derive(Debug, Default)]
struct FillSources {
    /// As [`find_sources`] gives them.
    sources: Vec<u32>,
    pyramid: Pyramid,
    rays: HoleRays,
    /// Only where there is a sky, seen in perspective.
    round: RoundThings,
}

impl FillSources {
    /// Finds which open holes of a picture show the sky rather than a surface. Takes the memory of sources and rays, which are to be set after
    /// it.
    fn find_open_holes(&mut self, picture: &Picture, is_open: &mut Vec<bool>) {
        is_open.clear();
        let (width, depths) = (picture.image.width(), picture.inverse_depth.as_slice());
        if !depths.contains(&OPEN_HOLE) {
            return;
        }
        let Self { sources: stops, rays, .. } = self;
        find_sources(picture, |depth| depth != OPEN_HOLE, stops);
        rays.cast(stops, picture.image.size());
        let rays = &*rays;
        let opens = |pixel: usize| {
            depths[pixel] == OPEN_HOLE && is_open_to_sky(rays, depths, (pixel % width, pixel / width))
        };
        (0..depths.len()).into_par_iter().with_min_len(4096).map(opens).collect_into_vec(is_open);
    }

    /// Sets the pixels of a picture whose inverse depth `counts`, without some, if any others are left. Round things go on as seen from a
    /// `viewpoint`, if one is given.
    fn set(
        &mut self,
        picture: &Picture,
        tolerance: SurfaceTolerance,
        counts: impl Fn(f32) -> bool + Sync,
        without: &[usize],
        viewpoint: Option<&Camera>,
    ) -> &Self {
        let Self { sources, pyramid, rays, round } = self;
        find_sources(picture, counts, sources);
        let left_out: Vec<usize> =
            without.iter().copied().filter(|pixel| sources[*pixel] != NO_IMAGE).collect();
        if sources.iter().filter(|source| **source != NO_IMAGE).count() > left_out.len() {
            for pixel in left_out {
                sources[pixel] = NO_IMAGE;
            }
        }
        let sources = &*sources;
        rayon::join(
            || pyramid.pull(picture, sources, tolerance),
            || rays.cast(sources, picture.image.size()),
        );
        match viewpoint.filter(|target| !target.intrinsics.is_orthographic()) {
            Some(target) => round.find(picture.inverse_depth.as_slice(), sources, target, tolerance),
            None => round.clear(),
        }
        self
    }

    /// What round things say of a pixel of a hole that sees `seen`; nothing where there are none.
    fn votes(
        &self,
        depths: &[f32],
        (x, y): (usize, usize),
        seen: &HoleNeighbors,
        test: Option<&RayTest<'_>>,
    ) -> RoundVotes {
        let at = (x as f32, y as f32);
        let is_seen_through =
            |[near, far]: [f32; 2]| test.is_some_and(|test| test.sees_through(at, near, far));
        self.round.votes(depths, (x, y), seen, is_seen_through)
    }
}

/// Sets [`NO_IMAGE`] for each pixel of a picture unless its inverse depth `counts`.
fn find_sources(picture: &Picture, counts: impl Fn(f32) -> bool + Sync, sources: &mut Vec<u32>) {
    let depths = picture.inverse_depth.as_slice();
    sources.resize(depths.len(), 0);
    let parts = sources.par_chunks_mut(4096).zip(depths.par_chunks(4096));
    parts.for_each(|(sources, depths)| {
        for (source, depth) in sources.iter_mut().zip(depths) {
            *source = if counts(*depth) { 0 } else { NO_IMAGE };
        }
    });
}

/// Whether a pixel sees the sky across its hole, and has surfaces on both sides in at most one direction: a surface continues only
/// between its parts on both sides. A pixel that sees nothing at all shows the sky.
fn is_open_to_sky(rays: &HoleRays, depths: &[f32], pixel: (usize, usize)) -> bool {
    let seen = rays.neighbors(pixel);
    let inverse_depth =
        |direction: usize| seen.distance_px[direction].is_finite().then(|| depths[seen.pixel[direction]]);
    let is_surface = |direction: usize| inverse_depth(direction).is_some_and(|w| w > 0.0);
    let facing = (0..4).filter(|direction| is_surface(*direction) && is_surface(direction + 4)).count();
    let sees_sky = (0..8).any(|direction| inverse_depth(direction) == Some(0.0));
    let sees_nothing = (0..8).all(|direction| inverse_depth(direction).is_none());
    sees_nothing || sees_sky && facing <= MOST_FACING
}

/// Fills the holes for which `shows_sky` holds, given the index of the pixel and its inverse depth.
fn fill_sky(
    picture: &mut Picture,
    target: &Camera,
    environment: &Environment,
    shows_sky: impl Fn(usize, f32) -> bool + Sync,
) {
    let width = picture.image.width();
    let directions = PixelDirections::new(target);
    let rows = picture.color.as_mut_slice().par_chunks_mut(width);
    let rows = rows.zip(picture.inverse_depth.as_mut_slice().par_chunks_mut(width));
    rows.enumerate().for_each(|(y, (colors, depths))| {
        let mut sky = environment.reader();
        for (x, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
            if *depth < 0.0 && shows_sky(y * width + x, *depth) {
                (*color, *depth) = (sky.color(directions.at((x, y))), 0.0);
            }
        }
    });
}

/// From this share on a pixel is shown as a whole.
const WHOLE: f32 = 0.999;

/// A pixel that is shown in part.
struct PartialPixel {
    pixel: usize,
    /// Share that is shown, above 0 and below 1.
    share: f32,
    /// Color of this share.
    color: [f32; 3],
}

/// The pixels of a picture that are shown in part.
struct PartialPixels(Vec<PartialPixel>);

impl PartialPixels {
    /// Takes the coverage of a picture.
    fn take(picture: &mut Picture) -> Self {
        let coverage = std::mem::take(&mut picture.coverage);
        let color = picture.color.as_slice();
        let width = picture.image.width();
        let rows = coverage.par_chunks(width).enumerate();
        let is_partial = |share: f32| share > 0.0 && share < WHOLE;
        let rows = rows.filter(|(_, row)| row.iter().fold(false, |any, share| any | is_partial(*share)));
        let partial = rows.flat_map_iter(|(y, row)| {
            let partial = row.iter().enumerate().filter(|(_, share)| is_partial(**share));
            partial.map(move |(x, share)| {
                let pixel = y * width + x;
                PartialPixel { pixel, share: *share, color: color[pixel] }
            })
        });
        Self(partial.collect())
    }

    /// Puts the shown parts over the filled picture. Pixels without a hole beside them stay as they are.
    fn put_over(self, picture: &mut Picture) {
        let composed = |partial: &PartialPixel| {
            let below = filling_at(picture, partial.pixel)?;
            let mix =
                |channel: usize| below[channel] + partial.share * (partial.color[channel] - below[channel]);
            Some((partial.pixel, [0, 1, 2].map(mix)))
        };
        let composed: Vec<_> = self.0.par_iter().filter_map(composed).collect();
        for (pixel, color) in composed {
            picture.color.as_mut_slice()[pixel] = color;
        }
    }
}

/// What fills a pixel that is a hole, else the mean of what fills the holes beside it; `None` without any.
fn filling_at(picture: &Picture, pixel: usize) -> Option<[f32; 3]> {
    let is_filled = |pixel: usize| {
        picture.image.as_slice()[pixel] == NO_IMAGE && picture.inverse_depth.as_slice()[pixel] >= 0.0
    };
    let colors = picture.color.as_slice();
    if picture.image.as_slice()[pixel] == NO_IMAGE {
        return is_filled(pixel).then(|| colors[pixel]);
    }
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for there in pixels_around(pixel, picture.image.size()).filter(|there| is_filled(*there)) {
        (0..3).for_each(|channel| sum[channel] += colors[there][channel]);
        count += 1.0;
    }
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse depths of a picture: `?` is an open hole, `s` the sky, `d` a surface, and `h` a hole of another kind.
    fn depths(rows: &[&str]) -> (Vec<f32>, (usize, usize)) {
        let of = |letter: char| match letter {
            '?' => OPEN_HOLE,
            's' => 0.0,
            'd' => 0.5,
            _ => HOLE,
        };
        (rows.iter().flat_map(|row| row.chars().map(of)).collect(), (rows[0].len(), rows.len()))
    }

    fn is_open(rows: &[&str], pixel: (usize, usize)) -> bool {
        let (depths, size) = depths(rows);
        let stops: Vec<u32> =
            depths.iter().map(|depth| if *depth == OPEN_HOLE { NO_IMAGE } else { 0 }).collect();
        let mut rays = HoleRays::default();
        rays.cast(&stops, size);
        is_open_to_sky(&rays, &depths, pixel)
    }

    #[test]
    fn beyond_the_corner_of_a_surface_is_the_sky_and_between_its_parts_the_surface() {
        // Surfaces in five of eight directions, two of them opposite.
        assert!(is_open(&["ddddd", "d???s", "d???s", "d???s", "dssss"], (2, 2)));
        assert!(!is_open(&["ddsdd", "d???d", "d???d", "d???d", "ddddd"], (2, 2)));
        assert!(!is_open(&["sssss", "sd?ds", "sd?ds", "sd?ds", "sssss"], (2, 2)), "a narrow gap");
    }

    #[test]
    fn where_nothing_is_seen_is_the_sky_and_beside_other_holes_alone_it_is_not() {
        assert!(is_open(&["???", "???", "???"], (1, 1)));
        assert!(!is_open(&["hhh", "h?h", "hhh"], (1, 1)));
        assert!(!is_open(&["ddd", "d??", "d??"], (1, 1)), "a surface on one side, and nothing else");
    }
}
