//! A depth picture as surfaces: inverse depth at the corners of its pixels.
//!
//! Purpose: depth is carried into another camera's pixels without holes within a surface, and without bridges across depth steps.
//!
//! Source: the triangulated depth image that is cut at depth steps (Waschbüsch et al.: Scalable 3D Video of Dynamic Scenes, 2005,
//! and many others). What differs: pixels, not the spaces between them, are the cells. Each pixel keeps its own depth at its
//! center; at a corner it has the mean of what the pixels around it that belong to its surface expect there. Inverse depth of a
//! plane is linear in the picture, so planes stay exact, and silhouettes keep their outer half pixels.

/// Two neighbors belong to one surface while their depths differ by no more than this many pixel footprints.
const FOOTPRINTS: f32 = 8.0;
/// The same, relative: steps of depth sensors at a distance stay below.
const RELATIVE: f32 = 0.02;

/// Inverse depth by pixel, with what belongs together.
pub(super) struct SurfaceMesh<'a> {
    inverse_depth: &'a [f32],
    size: (usize, usize),
    /// Largest relative difference within a surface.
    step: f32,
    /// Change of inverse depth from a pixel to the next, along rows and columns.
    gradients: Vec<[f32; 2]>,
}

impl<'a> SurfaceMesh<'a> {
    /// `focal_px` is the focal length of the depth camera; negative values are no depth.
    pub(super) fn new(inverse_depth: &'a [f32], size: (usize, usize), focal_px: f64) -> Self {
        let step = (FOOTPRINTS / focal_px as f32).max(RELATIVE);
        let mut mesh = Self { inverse_depth, size, step, gradients: Vec::new() };
        let pixels = size.0 * size.1;
        mesh.gradients = (0..pixels).map(|index| mesh.gradient(index % size.0, index / size.0)).collect();
        mesh
    }

    fn at(&self, x: usize, y: usize) -> f32 {
        self.inverse_depth[y * self.size.0 + x]
    }

    /// The inverse depth of a neighbor; `None` outside of the picture, and for a neighbor on another surface than inverse depth `own`.
    fn neighbor(&self, own: f32, x: isize, y: isize) -> Option<f32> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        let other = (x < self.size.0 && y < self.size.1).then(|| self.at(x, y))?;
        let is_same = other >= 0.0 && (own - other).abs() <= self.step * own.max(other);
        is_same.then_some(other)
    }

    fn gradient(&self, x: usize, y: usize) -> [f32; 2] {
        let own = self.at(x, y);
        if own < 0.0 {
            return [0.0; 2];
        }
        let (x, y) = (x as isize, y as isize);
        let along = |before: Option<f32>, after: Option<f32>| match (before, after) {
            (Some(before), Some(after)) => 0.5 * (after - before),
            (Some(before), None) => own - before,
            (None, Some(after)) => after - own,
            (None, None) => 0.0,
        };
        [
            along(self.neighbor(own, x - 1, y), self.neighbor(own, x + 1, y)),
            along(self.neighbor(own, x, y - 1), self.neighbor(own, x, y + 1)),
        ]
    }

    /// Inverse depth of pixel `x`, `y` at its center, and at its corners: top left, top right, bottom right, bottom left. `None`
    /// where it has no depth.
    pub(super) fn pixel(&self, x: usize, y: usize) -> Option<(f32, [f32; 4])> {
        let own = self.at(x, y);
        if own < 0.0 {
            return None;
        }
        let corner = |right: isize, down: isize| {
            let (mut sum, mut count) = (0.0, 0.0);
            for dy in [down - 1, down] {
                for dx in [right - 1, right] {
                    let (nx, ny) = (x as isize + dx, y as isize + dy);
                    let Some(value) = self.neighbor(own, nx, ny) else { continue };
                    let [gx, gy] = self.gradients[ny as usize * self.size.0 + nx as usize];
                    let (toward_x, toward_y) = ((right - dx) as f32 - 0.5, (down - dy) as f32 - 0.5);
                    sum += value + gx * toward_x + gy * toward_y;
                    count += 1.0;
                }
            }
            (sum / count).max(0.0)
        };
        Some((own, [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_stays_exact_to_its_border_and_a_step_is_not_bridged() {
        let plane = |x: f32, y: f32| 0.5 + 0.001 * x - 0.002 * y;
        let inverse: Vec<f32> = (0..20).map(|i| plane((i % 5) as f32 + 0.5, (i / 5) as f32 + 0.5)).collect();
        let mesh = SurfaceMesh::new(&inverse, (5, 4), 100.0);
        for (x, y) in [(0, 0), (4, 3), (2, 1)] {
            let (own, corners) = mesh.pixel(x, y).unwrap();
            assert_eq!(own, inverse[y * 5 + x]);
            let expected =
                [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(dx, dy)| plane((x + dx) as f32, (y + dy) as f32));
            for (corner, expected) in corners.iter().zip(expected) {
                assert!((corner - expected).abs() < 1e-6, "{corners:?} {expected:?}");
            }
        }
        let step = [1.0, 1.0, 0.5, 0.5];
        let mesh = SurfaceMesh::new(&step, (4, 1), 100.0);
        assert_eq!(mesh.pixel(1, 0).unwrap().1, [1.0; 4]);
        assert_eq!(mesh.pixel(2, 0).unwrap().1, [0.5; 4]);
        assert_eq!(SurfaceMesh::new(&[-1.0], (1, 1), 100.0).pixel(0, 0), None);
    }
}
