//! How far round things go on beyond what was seen of them.
//!
//! ```text
//!      2  1  0 | p  p  p . .      0, 1, 2: samples of one surface, in line with a hole. With the eye they lie in one plane, and in it on a
//!      ◯───────────               circle. A line of sight of the hole that meets the circle shows the same thing; one that passes it
//!                                 does not.
//! ```
//!
//! Purpose: of a ball, a stem or a limb that no camera saw whole, the unseen side continues the silhouette of the seen one. Without it such
//! a hole shows what lies behind, or the sky. A thing does not go on where a camera saw through: that tells the limb of a ball from the
//! edge of a leaf.
//!
//! Source: the osculating circle as what continues a curve best (P. Parent and S. Zucker, *Trace Inference, Curvature Consistency, and
//! Curve Detection*, PAMI 1989). What differs: curves are sections of surfaces by planes through the eye, so that where they end as seen
//! from there is known as well; and the odds of the sky were chosen by hand where traced scenes have their truth: spheres, an orrery and
//! leaves.

use glam::Vec3;
use rayon::prelude::*;

use super::rays::HoleNeighbors;
use super::surface::SurfaceTolerance;
use crate::capture::Camera;
use crate::render::environment::PixelDirections;
use crate::render::vantage::NO_IMAGE;

/// Pixels from each sample of a section to the next, the best first: the wider apart, the surer the circle.
const SPACINGS: [usize; 3] = [6, 4, 2];

/// Samples of a section are of one surface where their inverse depths differ by no more than over so many pixels.
const JOINED_PX: f32 = 8.0;

/// What is wider than this share of its distance is flat as far as anybody can tell.
const LARGEST_RADIUS: f32 = 0.3;

/// Columns and rows that one step goes in each direction of [`HoleNeighbors`].
const STEP: [[isize; 2]; 8] = [[-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0], [1, 1], [0, 1], [-1, 1]];

/// By this the odds of the sky are multiplied for each thing that goes on through a pixel.
const ODDS_OF_COVERED: f32 = 0.05;

/// Each thing that ends before a pixel doubles the odds of the sky, so many times at most: there may be others, which nobody saw.
const MOST_DOUBLINGS: u32 = 3;

/// The share of the sky where nothing else speaks against it, and a thing goes on through a pixel.
const MOST_SKY_OF_COVERED: f32 = 0.97;

/// The circle in which a plane through the eye meets a round thing: relative to the eye, in world space.
#[derive(Clone, Copy, Debug)]
struct Section {
    center: Vec3,
    radius_squared: f32,
}

/// The sections at one pixel, in the directions of [`HoleNeighbors`].
type Sections = [Option<Section>; 8];

/// The round things beside the holes of a picture; none by default.
#[derive(Debug, Default)]
pub(super) struct RoundThings {
    /// For each pixel the number of its sections, from 1 on; 0 without any.
    numbers: Vec<u32>,
    /// The pixels that have sections, and these.
    sections: Vec<(usize, Sections)>,
    directions: PixelDirections,
}

/// What round things say of a pixel of a hole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RoundVotes {
    /// The direction of the nearest thing that goes on through it.
    pub(super) covering: Option<usize>,
    /// Things that go on through it.
    covering_count: u32,
    /// Things that end before it.
    ending_count: u32,
    /// Surfaces that tell neither.
    silent_count: u32,
}

impl RoundVotes {
    /// The share of the sky in the pixel, where it is `share` without them.
    pub(super) fn sky_share(&self, share: f32) -> f32 {
        let most = if self.covering.is_some() { MOST_SKY_OF_COVERED } else { 1.0 };
        let share = share.min(most);
        let doublings = self.ending_count.saturating_sub(self.silent_count).min(MOST_DOUBLINGS);
        let odds =
            (0..self.covering_count).fold((1_u32 << doublings) as f32, |odds, _| odds * ODDS_OF_COVERED);
        let sky = share * odds;
        if odds != 1.0 && sky > 0.0 { sky / (sky + 1.0 - share) } else { share }
    }
}

impl RoundThings {
    /// Forgets those of an earlier picture.
    pub(super) fn clear(&mut self) {
        for (pixel, _) in self.sections.drain(..) {
            self.numbers[pixel] = 0;
        }
    }

    /// Finds those of a picture of `target`, by the inverse depths of its `sources`, which are not [`NO_IMAGE`].
    pub(super) fn find(
        &mut self,
        depths: &[f32],
        sources: &[u32],
        target: &Camera,
        tolerance: SurfaceTolerance,
    ) {
        self.clear();
        let (width, _) = target.intrinsics.size();
        let directions = PixelDirections::new(target);
        let edge = HoleEdges {
            depths,
            sources,
            width,
            directions: &directions,
            joined: tolerance.factor(JOINED_PX),
        };
        let rows: Vec<Vec<(usize, Sections)>> =
            (0..depths.len() / width).into_par_iter().map(|y| edge.sections_of_row(y)).collect();
        self.numbers.resize(depths.len(), 0);
        for (pixel, sections) in rows.into_iter().flatten() {
            self.sections.push((pixel, sections));
            self.numbers[pixel] = self.sections.len() as u32;
        }
        self.directions = directions;
    }

    /// What they say of a pixel of a hole that sees `seen`. Whether a camera saw through its line of sight somewhere between two inverse
    /// depths, the nearer first, `is_seen_through` tells.
    pub(super) fn votes(
        &self,
        depths: &[f32],
        (x, y): (usize, usize),
        seen: &HoleNeighbors,
        is_seen_through: impl Fn([f32; 2]) -> bool,
    ) -> RoundVotes {
        let mut votes = RoundVotes::default();
        if self.sections.is_empty() {
            return votes;
        }
        let line = self.directions.to_depth_1((x, y));
        let mut nearest = 0.0;
        for direction in 0..8 {
            let pixel = seen.pixel[direction];
            if !(seen.distance_px[direction].is_finite() && depths[pixel] > 0.0) {
                continue;
            }
            let number = self.numbers[pixel] as usize;
            let section = if number > 0 { self.sections[number - 1].1[direction] } else { None };
            let Some(section) = section else {
                votes.silent_count += 1;
                continue;
            };
            if section.met_by(line).is_none_or(&is_seen_through) {
                votes.ending_count += 1;
                continue;
            }
            votes.covering_count += 1;
            if depths[pixel] > nearest {
                (nearest, votes.covering) = (depths[pixel], Some(direction));
            }
        }
        votes
    }
}

impl Section {
    /// Through three points in line, the last of them beside a hole; `None` where they lie straight, around a hollow, or on something large.
    fn through([start, middle, end]: [Vec3; 3]) -> Option<Self> {
        let (a, b) = (end - start, middle - start);
        let normal = a.cross(b);
        let square = normal.length_squared();
        if square <= f32::MIN_POSITIVE {
            return None;
        }
        let from_start = (b * a.length_squared() - a * b.length_squared()).cross(normal) / (2.0 * square);
        let center = start + from_start;
        let radius_squared = from_start.length_squared();
        let is_round = (center - middle).dot(middle) > 0.0;
        let is_small = radius_squared < LARGEST_RADIUS * LARGEST_RADIUS * middle.length_squared();
        (is_round && is_small).then_some(Self { center, radius_squared })
    }

    /// The inverse depths at which a line of sight meets the circle, and is halfway through it.
    fn met_by(&self, line: Vec3) -> Option<[f32; 2]> {
        let (along, square) = (self.center.dot(line), line.length_squared());
        let inside = along * along - square * (self.center.length_squared() - self.radius_squared);
        let front = along - inside.max(0.0).sqrt();
        (inside > 0.0 && front > 0.0).then(|| [square / front, square / along])
    }
}

/// A picture in which sections are looked for at the edges of holes.
struct HoleEdges<'a> {
    depths: &'a [f32],
    /// As in [`RoundThings::new`].
    sources: &'a [u32],
    width: usize,
    directions: &'a PixelDirections,
    /// The factor by which inverse depths of neighbors on one surface may differ.
    joined: f32,
}

impl HoleEdges<'_> {
    /// The pixels of a row that have sections, with these.
    fn sections_of_row(&self, y: usize) -> Vec<(usize, Sections)> {
        let row = |y: usize| &self.sources[y * self.width..][..self.width];
        let last = self.depths.len() / self.width - 1;
        let [above, here, below] = [row(y.saturating_sub(1)), row(y), row((y + 1).min(last))];
        // Most rows have no hole beside them: this is fast for those.
        let columns = above.iter().zip(here).zip(below);
        let is_hole = |source: &u32| *source == NO_IMAGE;
        let has_hole: Vec<bool> = columns.map(|((a, b), c)| is_hole(a) | is_hole(b) | is_hole(c)).collect();
        if !has_hole.iter().fold(false, |any, has_hole| any | has_hole) {
            return Vec::new();
        }
        let of_pixel = |x: usize| {
            let pixel = y * self.width + x;
            let is_beside = has_hole[x.saturating_sub(1)..(x + 2).min(self.width)].contains(&true);
            if !is_beside || is_hole(&here[x]) || self.depths[pixel] <= 0.0 {
                return None;
            }
            let sections: Sections = std::array::from_fn(|direction| self.section([x, y], direction));
            sections.iter().any(Option::is_some).then_some((pixel, sections))
        };
        (0..self.width).filter_map(of_pixel).collect()
    }

    /// The section at a pixel whose neighbor against a direction is a hole.
    fn section(&self, at: [usize; 2], direction: usize) -> Option<Section> {
        if self.sources[self.pixel(self.moved(at, direction, -1)?)] != NO_IMAGE {
            return None;
        }
        let mut last = self.depths[self.pixel(at)];
        let joins = |steps: &usize| {
            let Some(there) = self.moved(at, direction, *steps as isize) else { return false };
            let next = self.depths[self.pixel(there)];
            let is_surface = self.sources[self.pixel(there)] != NO_IMAGE && next > 0.0;
            let is_joined = is_surface && next.max(last) <= next.min(last) * self.joined;
            last = next;
            is_joined
        };
        let length = (1..=2 * SPACINGS[0]).take_while(joins).count();
        let spacing = SPACINGS.into_iter().find(|spacing| 2 * spacing <= length)?;
        let point = |nth: usize| {
            let there = self.moved(at, direction, (nth * spacing) as isize)?;
            Some(self.directions.to_depth_1(there.into()) / self.depths[self.pixel(there)])
        };
        Section::through([point(2)?, point(1)?, point(0)?])
    }

    fn pixel(&self, [x, y]: [usize; 2]) -> usize {
        y * self.width + x
    }

    /// The pixel some steps away; `None` beyond the picture.
    fn moved(&self, [x, y]: [usize; 2], direction: usize, steps: isize) -> Option<[usize; 2]> {
        let [across, down] = STEP[direction];
        let x = x.checked_add_signed(across * steps).filter(|x| *x < self.width)?;
        let y = y.checked_add_signed(down * steps).filter(|y| *y < self.depths.len() / self.width)?;
        Some([x, y])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use crate::settings::RenderSettings;
    use glam::DVec3;

    const SIZE: u32 = 96;
    const BALL: Vec3 = Vec3::new(0.0, 4.0, 0.0);
    const RADIUS: f32 = 0.5;

    fn camera() -> Camera {
        let lens = Intrinsics::from_horizontal_angle(SIZE, SIZE, 0.6);
        Camera::look_at("eye".to_owned(), lens, DVec3::ZERO, DVec3::Y, DVec3::Z)
    }

    /// Inverse depths of a ball, and which of them are seen: of its left half alone.
    fn half_seen() -> (Vec<f32>, Vec<u32>) {
        let camera = camera();
        let directions = PixelDirections::new(&camera);
        let ball = Section { center: BALL, radius_squared: RADIUS * RADIUS };
        let side = SIZE as usize;
        let depth = |pixel: usize| {
            let met = ball.met_by(directions.to_depth_1((pixel % side, pixel / side)));
            met.filter(|_| pixel % side < side / 2).map_or(-1.0, |[front, _]| front)
        };
        let depths: Vec<f32> = (0..side * side).map(depth).collect();
        let sources = depths.iter().map(|depth| if *depth > 0.0 { 0 } else { NO_IMAGE }).collect();
        (depths, sources)
    }

    fn votes(at: (usize, usize), is_seen_through: bool) -> RoundVotes {
        let (depths, sources) = half_seen();
        let camera = camera();
        let tolerance = SurfaceTolerance::new(&camera, &RenderSettings::default());
        let mut things = RoundThings::default();
        things.find(&depths, &sources, &camera, tolerance);
        let side = SIZE as usize;
        let mut rays = super::super::rays::HoleRays::default();
        rays.cast(&sources, (side, side));
        things.votes(&depths, at, &rays.neighbors(at), |_| is_seen_through)
    }

    #[test]
    fn a_ball_that_is_seen_half_goes_on_to_its_silhouette_and_no_farther() {
        let middle = SIZE as usize / 2;
        // The ball is 0.5 wide at a distance of 4: its silhouette lies at 0.126 in the plane at depth 1, whose half is 0.309.
        let silhouette = middle + (0.126 / 0.309 * SIZE as f32 / 2.0) as usize;
        let inside = votes((silhouette - 2, middle), false);
        assert_eq!(inside.covering, Some(0), "to the left");
        assert_eq!(inside.ending_count, 0);
        let outside = votes((silhouette + 2, middle), false);
        assert_eq!((outside.covering, outside.covering_count), (None, 0));
        assert!(outside.ending_count > 0);
    }

    #[test]
    fn nothing_goes_on_where_a_camera_saw_through() {
        let beside = votes((SIZE as usize / 2 + 3, SIZE as usize / 2), true);
        assert_eq!(beside.covering, None);
        assert!(beside.ending_count > 0);
    }

    #[test]
    fn what_is_flat_or_hollow_tells_nothing() {
        let wall = [0.0, 1.0, 2.0].map(|x| Vec3::new(x, 4.0, 0.0));
        assert!(Section::through(wall).is_none());
        let hollow = [[0.0, 4.0], [0.2, 4.1], [0.4, 4.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        assert!(Section::through(hollow).is_none());
        let round = [[0.0, 4.0], [0.2, 3.9], [0.4, 4.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        assert!(Section::through(round).is_some());
    }

    #[test]
    fn what_goes_on_leaves_little_sky_and_what_ends_leaves_more() {
        let share = |covering_count, ending_count, silent_count, share| {
            let covering = (covering_count > 0).then_some(0);
            RoundVotes { covering, covering_count, ending_count, silent_count }.sky_share(share)
        };
        assert_eq!(share(0, 0, 0, 0.3), 0.3);
        assert_eq!(share(0, 2, 2, 0.3), 0.3, "as many tell nothing");
        assert!(share(0, 2, 0, 0.3) > 0.6);
        assert!(share(1, 0, 0, 1.0) < 0.7);
        assert!(share(2, 0, 0, 1.0) < 0.1);
        assert_eq!([share(0, 8, 0, 0.0), share(0, 8, 0, 1.0)], [0.0, 1.0]);
    }
}
