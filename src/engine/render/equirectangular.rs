//! Pictures of all directions around a viewpoint: six square pictures, the faces of a cube, resampled by longitude and latitude.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use super::vantage::{Picture, Vantage};
use crate::capture::{Camera, Intrinsics};
use crate::grid::Grid;
use crate::settings::choice::choice;

choice! {
    /// What the pictures of a film show.
    pub enum Projection {
        /// The view through the lens of the path.
        Perspective = "perspective",
        /// All directions around the camera, with a level horizon.
        Equirectangular = "equirectangular",
    }
}

/// Pixels by which each face reaches over its neighbors, so that pixels at an edge are blended from one face alone.
const MARGIN: u32 = 8;

/// Along each side of a pixel, places whose colors are averaged: near the corners of a face its pixels are finer than the picture's.
const PLACES: usize = 2;

/// Right, down and forward of each face in axes of the camera (x right, y down, z forward).
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::Y, DVec3::Z],
    [DVec3::NEG_Z, DVec3::Y, DVec3::X],
    [DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z],
    [DVec3::Z, DVec3::Y, DVec3::NEG_X],
    [DVec3::X, DVec3::Z, DVec3::NEG_Y],
    [DVec3::X, DVec3::NEG_Z, DVec3::Y],
];

/// The number of pictures that [`equirectangular`] is made of.
pub const FACE_COUNT: usize = FACES.len();

/// The lens of a face for a picture of `width` columns: its pixels are as fine in the middle as that picture needs at the horizon,
/// and half as wide again.
fn lens(width: u32) -> Intrinsics {
    let focal = f64::from(width.max(4) / 4);
    let side = 2 * (width.max(4) / 4 + MARGIN);
    Intrinsics::centered(side, side, focal)
}

/// What has to be rendered for the equirectangular picture of `width` columns around a viewpoint. The horizon is level: `up` is the
/// direction up in the world. The middle of the picture is where the camera looks.
#[must_use]
pub fn faces_around(vantage: &Vantage, up: DVec3, width: u32) -> [Vantage; FACE_COUNT] {
    let pose = level(&vantage.camera.world_from_camera, up);
    let intrinsics = lens(width);
    FACES.map(|[right, down, forward]| {
        let turn = DMat3::from_cols(right, down, forward);
        let world_from_camera = DAffine3::from_mat3_translation(pose.matrix3 * turn, pose.translation);
        let camera = Camera { intrinsics, world_from_camera, ..vantage.camera.clone() };
        Vantage { camera, frame: vantage.frame }
    })
}

/// A pose of the same place and heading that looks at the horizon.
fn level(pose: &DAffine3, up: DVec3) -> DAffine3 {
    let flat = |direction: DVec3| direction.reject_from(up).try_normalize().filter(|flat| flat.is_finite());
    let ahead = pose.matrix3.z_axis.normalize_or_zero();
    // A camera that looks straight down has its heading at its upper edge, one that looks up at its lower edge.
    let heading = if ahead.dot(up.normalize_or_zero()).abs() > 0.999 {
        flat(pose.matrix3.y_axis * ahead.dot(up))
    } else {
        flat(ahead)
    };
    let (Some(forward), Some(down)) = (heading, (-up).try_normalize()) else { return *pose };
    let axes = DMat3::from_cols(down.cross(forward), down, forward);
    DAffine3::from_mat3_translation(axes, pose.translation)
}

/// The equirectangular picture of `width` columns and half as many rows, from the rendered [`faces_around`]: columns are longitudes
/// from behind over the left, the middle and the right to behind again, rows latitudes from straight up to straight down. Its inverse
/// depth is the reciprocal of the distance from the viewpoint.
#[must_use]
pub fn equirectangular(faces: &[Picture; FACE_COUNT], width: u32) -> Picture {
    let (columns, rows) = (width as usize, (width / 2) as usize);
    let lens = lens(width);
    let direction = |x: f64, y: f64| {
        let (longitude, latitude) = (x / columns as f64 * TAU - PI, PI / 2.0 - y / rows as f64 * PI);
        DVec3::new(latitude.cos() * longitude.sin(), -latitude.sin(), latitude.cos() * longitude.cos())
    };
    let pixel = |index: usize| {
        let (x, y) = ((index % columns) as f64, (index / columns) as f64);
        let mut color = [0.0; 3];
        for place in 0..PLACES * PLACES {
            let within = |nth: usize| (nth as f64 + 0.5) / PLACES as f64;
            let (face, at) =
                on_face(direction(x + within(place % PLACES), y + within(place / PLACES)), &lens);
            let seen = blended(&faces[face].color, at);
            color = [0, 1, 2].map(|channel| color[channel] + seen[channel] / (PLACES * PLACES) as f32);
        }
        let ahead = direction(x + 0.5, y + 0.5);
        let (face, at) = on_face(ahead, &lens);
        let nearest = at.map(|at| (at.round().max(0.0) as usize).min(lens.width as usize - 1));
        let nearest = (nearest[0], nearest[1]);
        let planar = faces[face].inverse_depth[nearest];
        let inverse = if planar > 0.0 { planar * ahead.dot(FACES[face][2]) as f32 } else { planar };
        (color, inverse, faces[face].image[nearest])
    };
    let pixels: Vec<_> = (0..columns * rows).into_par_iter().map(pixel).collect();
    let at = |x: usize, y: usize| &pixels[y * columns + x];
    Picture {
        color: Grid::from_fn(columns, rows, |x, y| at(x, y).0),
        inverse_depth: Grid::from_fn(columns, rows, |x, y| at(x, y).1),
        image: Grid::from_fn(columns, rows, |x, y| at(x, y).2),
        ..Picture::empty(0, 0)
    }
}

/// The face that a direction meets, and where: the middle of its first pixel is 0, 0.
fn on_face(direction: DVec3, lens: &Intrinsics) -> (usize, [f64; 2]) {
    let ahead = |face: &usize| direction.dot(FACES[*face][2]);
    let face = (0..FACE_COUNT).max_by(|a, b| ahead(a).total_cmp(&ahead(b))).unwrap_or(0);
    let [right, down, forward] = FACES[face].map(|axis| direction.dot(axis));
    (face, [lens.cx + lens.fx * right / forward - 0.5, lens.cy + lens.fy * down / forward - 0.5])
}

/// The color between four pixels.
fn blended(color: &Grid<[f32; 3]>, [x, y]: [f64; 2]) -> [f32; 3] {
    let (left, top) = (x.floor().max(0.0), y.floor().max(0.0));
    let (across, along) = ((x - left) as f32, (y - top) as f32);
    let pixel = |dx: usize, dy: usize| {
        color[((left as usize + dx).min(color.width() - 1), (top as usize + dy).min(color.height() - 1))]
    };
    let [a, b, c, d] = [pixel(0, 0), pixel(1, 0), pixel(0, 1), pixel(1, 1)];
    [0, 1, 2].map(|channel| {
        let row = |left: [f32; 3], right: [f32; 3]| left[channel] + (right[channel] - left[channel]) * across;
        row(a, b) + (row(c, d) - row(a, b)) * along
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vantage(eye: DVec3, target: DVec3) -> Vantage {
        let lens = Intrinsics::centered(64, 48, 70.0);
        Vantage { camera: Camera::look_at("path", lens, eye, target, DVec3::Z), frame: 3 }
    }

    /// The faces, where every pixel has the color of its direction in the world, at a distance of 4.
    fn painted(faces: &[Vantage; FACE_COUNT]) -> [Picture; FACE_COUNT] {
        faces.each_ref().map(|face| {
            let Intrinsics { width, height, fx, fy, cx, cy, .. } = face.camera.intrinsics;
            let mut picture = Picture::empty(width as usize, height as usize);
            for (x, y) in (0..height as usize).flat_map(|y| (0..width as usize).map(move |x| (x, y))) {
                let ray = DVec3::new((x as f64 + 0.5 - cx) / fx, (y as f64 + 0.5 - cy) / fy, 1.0);
                let world = (face.camera.world_from_camera.matrix3 * ray).normalize_or_zero();
                picture.color[(x, y)] = (world * 0.5 + 0.5).as_vec3().to_array();
                picture.inverse_depth[(x, y)] = (ray.length() / 4.0) as f32;
                picture.image[(x, y)] = 0;
            }
            picture
        })
    }

    #[test]
    fn every_pixel_shows_its_direction_without_a_seam() {
        let faces =
            faces_around(&vantage(DVec3::new(0.0, -5.0, 1.0), DVec3::new(0.0, 0.0, 3.0)), DVec3::Z, 256);
        assert!(faces.iter().all(|face| face.frame == 3));
        let picture = equirectangular(&painted(&faces), 256);
        assert_eq!(picture.color.size(), (256, 128));
        for (x, y) in (0..128).flat_map(|y| (0..256).map(move |x| (x, y))) {
            let (longitude, latitude) =
                ((x as f64 + 0.5) / 256.0 * TAU - PI, PI / 2.0 - (y as f64 + 0.5) / 128.0 * PI);
            // The camera looks along y, so that x is to its right; the horizon is level though it looks upward.
            let world = DVec3::new(
                latitude.cos() * longitude.sin(),
                latitude.cos() * longitude.cos(),
                latitude.sin(),
            );
            let expected = (world * 0.5 + 0.5).as_vec3().to_array();
            let apart = [0, 1, 2].map(|channel| (picture.color[(x, y)][channel] - expected[channel]).abs());
            assert!(apart.iter().all(|apart| *apart < 1e-3), "{x} {y}: {apart:?}");
            assert!((picture.inverse_depth[(x, y)] - 0.25).abs() < 2e-3, "{x} {y}");
        }
    }

    #[test]
    fn a_camera_that_looks_straight_down_keeps_its_heading() {
        // Right is x, the upper edge is toward y.
        let axes = DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z);
        let pose = level(&DAffine3::from_mat3_translation(axes, DVec3::ONE), DVec3::Z);
        assert!((pose.matrix3.z_axis - DVec3::Y).length() < 1e-12, "{pose:?}");
        assert!((pose.matrix3.x_axis - DVec3::X).length() < 1e-12 && pose.translation == DVec3::ONE);
    }
}
