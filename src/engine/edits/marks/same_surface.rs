//! The surface that a sample lies on, followed over the samples of all cameras.
//!
//! Source: region growing on points (T. Rabbani et al., 2006), where it goes on over neighbors with like normals, and not from where the
//! surface bends. What differs: neighbors are as near as pixels are wide there, not the nearest few, since cameras at different distances
//! meet on one surface; and a step may not leave the plane of the surface, so that it does not pass through thin things.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::placed_points::{Origin, points_of};
use super::point_tree::{Point, PointTree};
use crate::alignment::eigen;
use crate::edits::seen::ImageMarks;
use crate::error::Result;
use crate::job::Job;
use crate::samples::{ImageBuffer, SampleImage, SampleSet};

/// Around an edge, points are off their plane by more than this share of their variance.
const EDGE: f64 = 0.04;

/// Points that make a plane, at least.
const LEAST: usize = 5;

/// A step leaves the plane of the surface by at most this share of what a point reaches that is seen head-on.
const OFF_PLANE: f32 = 0.5;

/// Pixels that are seen at a slant reach at most this many times as far.
const MOST_STRETCHED: f32 = 8.0;

/// Steps between two looks at whether the work is cancelled.
const CHECKED: usize = 1024;

/// What is asked for.
pub(super) struct SurfaceRule {
    pub(super) seed_in_world: DVec3,
    pub(super) frame: usize,
    pub(super) footprints: f64,
    /// Between normals over one step.
    pub(super) least_cosine: f32,
    /// World units.
    pub(super) radius: Option<f64>,
}

/// The points of an image, and the normals that it has of some of them, by the indices of samples in their order.
type ImagePoints = (Vec<Point>, Vec<(u32, Vec3)>);

/// The direction of the surface at a point.
#[derive(Clone, Copy)]
enum Facing {
    Unknown,
    /// The surface bends here: it is not followed any farther.
    Edge,
    Normal(Vec3),
}

/// Samples of one frame, and those that were reached.
struct Flood<'a> {
    tree: &'a PointTree,
    /// Toward the camera of each image, from the origin.
    eyes: &'a [Vec3],
    facing: Vec<Facing>,
    is_reached: Vec<bool>,
    /// Points of each node that were not reached yet.
    left: Vec<u32>,
}

impl SurfaceRule {
    /// Marks the samples of the surface. The same samples give the same marks, whatever the number of threads.
    pub(super) fn marks(
        &self,
        images: &ImageBuffer,
        outline: &SampleSet,
        job: &Job,
    ) -> Result<Vec<ImageMarks>> {
        // From the first sample, so that coordinates are the most exact around it.
        let origin = Origin(self.seed_in_world);
        let shown: Vec<usize> =
            (0..images.len()).filter(|index| images.facts_of(*index).span.contains(self.frame)).collect();
        let found: Vec<ImagePoints> = shown
            .par_iter()
            .map(|&index| {
                job.check()?;
                let image = images.get(index)?;
                let camera = &outline.cameras[image.camera as usize];
                let mut points = points_of(&image, index, camera, origin, self.footprints);
                stretch(&mut points, &image, camera.intrinsics.size(), self.footprints);
                if let Some(radius) = self.radius {
                    points.retain(|point| f64::from(point.distance_squared([0.0; 3])) <= radius * radius);
                }
                let given = image.normal.as_ref().map_or_else(Vec::new, |normals| {
                    let with_normal =
                        points.iter().map(|point| (point.index, normals[point.index as usize].decode()));
                    with_normal.collect()
                });
                Ok((points, given))
            })
            .collect::<Result<_>>()?;
        let mut eyes = vec![Vec3::ZERO; images.len()];
        for &index in &shown {
            let camera = &outline.cameras[images.facts_of(index).camera as usize];
            // Parallel lines of sight come from far away.
            let eye = if camera.intrinsics.is_orthographic() {
                self.seed_in_world - 1e5 * camera.intrinsics.depth_scale(1.0) * camera.forward_in_world()
            } else {
                camera.position_in_world()
            };
            eyes[index] = Vec3::from(origin.to_point(eye));
        }
        let tree = PointTree::new(found.iter().flat_map(|(points, _)| points).copied().collect());
        job.check()?;
        let mut flood = Flood::new(&tree, &eyes);
        flood.take_normals(&shown, &found);
        flood.run(self.least_cosine, job)?;
        let mut marks = vec![None; images.len()];
        for (point, _) in tree.points().iter().zip(&flood.is_reached).filter(|(_, is_reached)| **is_reached) {
            let image = point.image as usize;
            let samples = images.facts_of(image).samples;
            marks[image].get_or_insert_with(|| vec![false; samples].into_boxed_slice())
                [point.index as usize] = true;
        }
        Ok(marks)
    }
}

/// Seen at a slant, neighboring pixels lie farther apart than they are wide: lets points reach as many neighbors there as elsewhere.
/// `points` are samples of the image, which reach so many `footprints`.
fn stretch(points: &mut [Point], image: &SampleImage, (width, height): (usize, usize), footprints: f64) {
    let mut places: Vec<Option<Vec3>> = vec![None; width * height];
    let pixels: Vec<[usize; 2]> = image.samples().map(|sample| [sample.x, sample.y]).collect();
    for point in points.iter() {
        let [x, y] = pixels[point.index as usize];
        if x < width && y < height {
            places[y * width + x] = Some(Vec3::from(point.at));
        }
    }
    for point in points {
        let [x, y] = pixels[point.index as usize];
        let here = Vec3::from(point.at);
        let to = |x: usize, y: usize| {
            let there = if x < width && y < height { places[y * width + x] } else { None };
            there.map_or(f32::INFINITY, |there| there.distance(here))
        };
        // The nearer one of both sides: the other one may lie behind a silhouette.
        let across = to(x.wrapping_sub(1), y).min(to(x + 1, y));
        let down = to(x, y.wrapping_sub(1)).min(to(x, y + 1));
        let apart = [across, down].into_iter().filter(|apart| apart.is_finite()).fold(0.0, f32::max);
        let pixel = point.reach / footprints as f32;
        point.reach *= (apart / pixel).clamp(1.0, MOST_STRETCHED);
    }
}

impl<'a> Flood<'a> {
    fn new(tree: &'a PointTree, eyes: &'a [Vec3]) -> Self {
        let count = tree.points().len();
        let mut left = vec![0; tree.node_count()];
        (0..count).flat_map(|point| tree.nodes_of(point)).for_each(|node| left[node] += 1);
        Self { tree, eyes, facing: vec![Facing::Unknown; count], is_reached: vec![false; count], left }
    }

    /// Takes the normals that a store holds. `shown` are the indices of the images.
    fn take_normals(&mut self, shown: &[usize], found: &[ImagePoints]) {
        for (facing, point) in self.facing.iter_mut().zip(self.tree.points()) {
            let of_image = shown.binary_search(&(point.image as usize)).ok().map(|at| &found[at].1);
            let given = of_image.and_then(|given| {
                let at = given.binary_search_by_key(&point.index, |(index, _)| *index).ok()?;
                given[at].1.try_normalize()
            });
            if let Some(normal) = given {
                *facing = Facing::Normal(normal);
            }
        }
    }

    fn run(&mut self, least_cosine: f32, job: &Job) -> Result<()> {
        let Some(first) = self.first() else { return Ok(()) };
        self.reach(first);
        let (mut next, mut near) = (vec![first], Vec::new());
        let mut steps = 0_usize;
        while let Some(place) = next.pop() {
            steps += 1;
            if steps.is_multiple_of(CHECKED) {
                job.check()?;
            }
            let Facing::Normal(normal) = self.facing_of(place) else { continue };
            let here = self.tree.points()[place];
            near.clear();
            let left = &self.left;
            self.tree.for_each_near(
                here.at,
                here.reach,
                |node| left[node] > 0,
                |other| {
                    near.push(other);
                    true
                },
            );
            for &other in &near {
                if self.is_reached[other] {
                    continue;
                }
                let there = self.tree.points()[other];
                let step = Vec3::from(there.at) - Vec3::from(here.at);
                if step.dot(normal).abs() > OFF_PLANE * here.head_on.max(there.head_on) {
                    continue;
                }
                let (is_same, goes_on) = match self.facing_of(other) {
                    Facing::Normal(theirs) => (theirs.dot(normal) >= least_cosine, true),
                    _ => (true, false),
                };
                if is_same {
                    self.reach(other);
                    if goes_on {
                        next.push(other);
                    }
                }
            }
        }
        Ok(())
    }

    /// The nearest sample that reaches the seed and lies on a plane, or else on an edge.
    fn first(&mut self) -> Option<usize> {
        let mut near = Vec::new();
        self.tree.for_each_near(
            [0.0; 3],
            0.0,
            |_| true,
            |place| {
                near.push(place);
                true
            },
        );
        near.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|place| self.tree.points()[place]);
            let [to_a, to_b] = [a, b].map(|point| point.distance_squared([0.0; 3]));
            to_a.total_cmp(&to_b).then_with(|| (a.image, a.index).cmp(&(b.image, b.index)))
        });
        let plane = near.iter().copied().find(|place| matches!(self.facing_of(*place), Facing::Normal(_)));
        plane.or(near.first().copied())
    }

    fn reach(&mut self, place: usize) {
        self.is_reached[place] = true;
        for node in self.tree.nodes_of(place) {
            self.left[node] -= 1;
        }
    }

    /// The normal at a point: where none is given, that of the plane through the points that it reaches.
    fn facing_of(&mut self, place: usize) -> Facing {
        if matches!(self.facing[place], Facing::Unknown) {
            self.facing[place] = self.plane_at(place);
        }
        self.facing[place]
    }

    fn plane_at(&self, place: usize) -> Facing {
        let here = self.tree.points()[place];
        let mut around: Vec<DVec3> = Vec::new();
        self.tree.for_each_near(
            here.at,
            here.reach,
            |_| true,
            |other| {
                let there = self.tree.points()[other];
                if there.distance_squared(here.at) <= here.reach * here.reach {
                    around.push((Vec3::from(there.at) - Vec3::from(here.at)).as_dvec3());
                }
                true
            },
        );
        if around.len() < LEAST {
            return Facing::Edge;
        }
        let mean = around.iter().sum::<DVec3>() / around.len() as f64;
        let mut spread = [[0.0; 3]; 3];
        for offset in around.iter().map(|point| (*point - mean).to_array()) {
            for (row, a) in spread.iter_mut().zip(offset) {
                row.iter_mut().zip(offset).for_each(|(sum, b)| *sum += a * b);
            }
        }
        let mut axes = eigen(spread);
        axes.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let all: f64 = axes.iter().map(|(value, _)| value.max(0.0)).sum();
        // Points on a line have no plane.
        if axes[0].0.max(0.0) > EDGE * all || axes[1].0 <= EDGE * all {
            return Facing::Edge;
        }
        let normal = DVec3::from(axes[0].1).as_vec3();
        let toward_camera = self.eyes[here.image as usize] - Vec3::from(here.at);
        Facing::Normal(if normal.dot(toward_camera) < 0.0 { -normal } else { normal })
    }
}
