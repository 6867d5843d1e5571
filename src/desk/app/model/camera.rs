//! The live view's virtual camera: orbits a pivot, flies, looks along axes, jumps to where cameras stood, and takes its pose in numbers.
//!
//! Heading is the compass direction of the line of sight: 0 looks along `north`, and it grows to the right. Pitch grows upward from
//! the horizon. Roll grows as the camera turns clockwise about its line of sight. All in radians.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3};

use crate::app::model::scene::OpenScene;
use overlook_engine::capture::{Camera, Intrinsics};

/// How near to straight up or down orbiting goes, as a cosine, so that up stays up.
const STEEPEST: f64 = 0.985;

/// The finest resting view: its pixels per recorded pixel, along each side. Finer views show little more than specks between samples
/// of slanted surfaces: on one capture 140 pixels of them at 1 (magnified), 320 at 2 and 1090 at 3.
const FINEST_AT_REST: f64 = 2.0;

/// Largest side of a picture in motion, in pixels, so that turning stays smooth on large displays.
const LARGEST_IN_MOTION: f64 = 1600.0;

/// Distance of the first vantage from the first camera, as a share of the way to the second.
const HOME_STEP: f64 = 0.3;

/// The least and largest distance from the pivot by zooming, in distances from the first camera to the point that the cameras look
/// at: a scene may be a molecule in meters, or a galaxy.
const ZOOM: [f64; 2] = [1e-5, 1e6];

/// Cameras at their pivot count as this far from it.
const LEAST_DISTANCE: f64 = 1e-12;

/// Narrowest and widest horizontal angle of view, radians.
pub(crate) const ANGLES_OF_VIEW: [f64; 2] = [PI / 180.0, 160.0 * PI / 180.0];

/// Lines of sight whose horizontal part is shorter are taken as vertical.
const VERTICAL: f64 = 1e-9;

/// Where a line of sight points, and how the camera is turned about it; radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ViewAngles {
    /// From north to the right, −π to π.
    pub heading: f64,
    /// From the horizon upward, −π/2 to π/2.
    pub pitch: f64,
    /// Clockwise about the line of sight, −π to π.
    pub roll: f64,
}

/// The pose and lens of the live view.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OrbitCamera {
    /// Camera space (x right, y down, z forward) to world space.
    pub world_from_camera: DAffine3,
    /// Distance to what is orbited, along the line of sight.
    pub pivot_distance: f64,
    /// From the first camera to what the cameras look at: how large the scene is.
    home_distance: f64,
    /// The lens, as the camera it was taken from had it.
    pub lens: Intrinsics,
    /// Unit length.
    pub up_in_world: DVec3,
}

impl OrbitCamera {
    /// The first view: a step from the first camera toward the second, on their circle about what they look at. With
    /// one camera, a step to its side.
    pub(crate) fn home(scene: &OpenScene, up_in_world: DVec3) -> Option<Self> {
        let first = scene.cameras.first()?;
        let pivot = scene.pivot_in_world;
        let eye_a = first.position_in_world() - pivot;
        let distance = home_distance(scene);
        let eye_b = scene.cameras.get(1).map_or_else(
            || DQuat::from_axis_angle(up_in_world, 0.4) * eye_a,
            |second| second.position_in_world() - pivot,
        );
        let radius = distance + (eye_b.length() - distance) * HOME_STEP;
        let aside = eye_a / distance * (1.0 - HOME_STEP) + eye_b.normalize_or_zero() * HOME_STEP;
        let eye = aside.try_normalize().unwrap_or_else(|| eye_a / distance) * radius;
        let camera = Camera::look_at("home", first.intrinsics, pivot + eye, pivot, up_in_world);
        Some(Self {
            world_from_camera: camera.world_from_camera,
            pivot_distance: radius.max(LEAST_DISTANCE),
            home_distance: distance,
            lens: first.intrinsics.in_perspective_from(distance),
            up_in_world,
        })
    }

    /// Where `camera` stood, with its lens.
    pub(crate) fn at_camera(scene: &OpenScene, camera: &Camera) -> Self {
        let along = (scene.pivot_in_world - camera.position_in_world()).dot(camera.forward_in_world());
        let distance = (scene.pivot_in_world - camera.position_in_world()).length();
        let pivot_distance = if along > 0.0 { along } else { distance.max(LEAST_DISTANCE) };
        Self {
            world_from_camera: camera.world_from_camera,
            pivot_distance,
            home_distance: home_distance(scene),
            // The live view moves through space, which parallel lines of sight do not show.
            lens: camera.intrinsics.in_perspective_from(pivot_distance),
            up_in_world: scene.up_in_world,
        }
    }

    /// The virtual camera for a picture of `width × height` pixels: the lens's whole picture fits inside.
    pub(crate) fn camera(&self, width: u32, height: u32) -> Camera {
        let (lens_width, lens_height) = (f64::from(self.lens.width), f64::from(self.lens.height));
        let scale = (f64::from(width) / lens_width).min(f64::from(height) / lens_height);
        let intrinsics = Intrinsics {
            width,
            height,
            fx: self.lens.fx * scale,
            fy: self.lens.fy * scale,
            cx: f64::from(width) / 2.0 + (self.lens.cx - lens_width / 2.0) * scale,
            cy: f64::from(height) / 2.0 + (self.lens.cy - lens_height / 2.0) * scale,
            projection: self.lens.projection,
        };
        Camera { name: "live view".to_owned(), intrinsics, world_from_camera: self.world_from_camera }
    }

    /// This pose with the lens of [`Self::camera`] for a picture of `width × height` pixels: views of any shape show all of that picture.
    pub(crate) fn framed(&self, [width, height]: [u32; 2]) -> Self {
        Self { lens: self.camera(width, height).intrinsics, ..self.clone() }
    }

    /// The size at which a view of `width × height` pixels is painted while it moves: no finer than the lens recorded, and no larger
    /// than [`LARGEST_IN_MOTION`].
    pub(crate) fn size_in_motion(&self, size: [u32; 2]) -> [u32; 2] {
        let size = self.painted_size(size, 1.0);
        let scale = LARGEST_IN_MOTION / f64::from(size[0].max(size[1]));
        size.map(|side| ((f64::from(side) * scale.min(1.0)).round() as u32).max(1))
    }

    /// The size at which it is painted once it rests. Outlines are then as sharp as the view, and surfaces that another camera saw from
    /// nearer have their detail; beyond [`FINEST_AT_REST`] nothing more is visible.
    pub(crate) fn size_at_rest(&self, size: [u32; 2]) -> [u32; 2] {
        self.painted_size(size, FINEST_AT_REST)
    }

    /// At most `finest` pixels a side for each one of the lens.
    fn painted_size(&self, [width, height]: [u32; 2], finest: f64) -> [u32; 2] {
        let scale = (f64::from(width) / f64::from(self.lens.width))
            .min(f64::from(height) / f64::from(self.lens.height));
        let scale = (scale / finest).max(1.0);
        [width, height].map(|side| ((f64::from(side) / scale).round() as u32).max(1))
    }

    fn pivot(&self) -> DVec3 {
        self.world_from_camera.transform_point3(DVec3::Z * self.pivot_distance)
    }

    /// Shifts the view so that its pivot is there.
    fn move_pivot_to(&mut self, point_in_world: DVec3) {
        self.world_from_camera.translation += point_in_world - self.pivot();
    }

    fn turn_about(&mut self, center: DVec3, rotation: DQuat) {
        let turn = DAffine3::from_translation(center)
            * DAffine3::from_quat(rotation)
            * DAffine3::from_translation(-center);
        let turned = turn * self.world_from_camera;
        // Thousands of small turns would let the axes drift from unit length.
        self.world_from_camera = DAffine3::from_rotation_translation(
            DQuat::from_mat3(&turned.matrix3).normalize(),
            turned.translation,
        );
    }

    /// Turns about the pivot by angles in radians, to the right and downward as the picture moves.
    pub(crate) fn orbit(&mut self, angles: DVec2) {
        self.turn_about(self.pivot(), DQuat::from_axis_angle(self.up_in_world, -angles.x));
        let DMat3 { x_axis: right, z_axis: forward, .. } = self.world_from_camera.matrix3;
        let tilt = DQuat::from_axis_angle(right, -angles.y);
        let steepness = (tilt * forward).dot(self.up_in_world).abs();
        if steepness < STEEPEST || steepness < forward.dot(self.up_in_world).abs() {
            self.turn_about(self.pivot(), tilt);
        }
    }

    /// A distance that zooming may reach: within [`ZOOM`], or no farther out of it than the view is already.
    fn zoomed(&self, distance: f64) -> f64 {
        let [nearest, farthest] = ZOOM.map(|share| share * self.home_distance);
        distance.clamp(nearest.min(self.pivot_distance), farthest.max(self.pivot_distance))
    }

    /// Goes nearer to the pivot (factor below 1) or farther from it.
    pub(crate) fn dolly(&mut self, factor: f64) {
        let pivot = self.pivot();
        self.pivot_distance = self.zoomed(self.pivot_distance * factor);
        self.move_pivot_to(pivot);
    }

    /// Goes nearer to a point (factor below 1) or farther from it; the point stays where it is on the screen.
    pub(crate) fn dolly_to(&mut self, factor: f64, point_in_world: DVec3) {
        let eye = self.world_from_camera.translation;
        self.world_from_camera.translation = point_in_world + (eye - point_in_world) * factor;
        self.pivot_distance = self.zoomed(self.pivot_distance * factor);
    }

    /// Shifts the view so that a point is in its middle, and orbits it from now on.
    pub(crate) fn look_at(&mut self, point_in_world: DVec3) {
        let forward = self.world_from_camera.matrix3.z_axis;
        let along = (point_in_world - self.world_from_camera.translation).dot(forward);
        self.pivot_distance = along.max(ZOOM[0] * self.home_distance);
        self.move_pivot_to(point_in_world);
    }

    /// Looks at the point from so far that all within `radius` of it is in view; with parallel lines of sight, or radius 0, the distance
    /// stays.
    pub(crate) fn frame(&mut self, point_in_world: DVec3, radius: f64) {
        self.look_at(point_in_world);
        if self.lens.is_orthographic() || radius <= 0.0 {
            return;
        }
        let halves = [f64::from(self.lens.width) / self.lens.fx, f64::from(self.lens.height) / self.lens.fy];
        let half_angle = (halves[0].min(halves[1]) / 2.0).atan();
        self.dolly(radius / half_angle.sin() / self.pivot_distance);
    }

    /// Five units from the origin, for tests.
    #[cfg(test)]
    pub(crate) fn for_tests() -> Self {
        let lens = Intrinsics::from_horizontal_angle(64, 48, 1.0);
        let camera = Camera::look_at("c", lens, DVec3::new(0.0, -5.0, 1.0), DVec3::ZERO, DVec3::Z);
        let distance = camera.position_in_world().length();
        let (world_from_camera, up_in_world) = (camera.world_from_camera, DVec3::Z);
        Self { world_from_camera, pivot_distance: distance, home_distance: distance, lens, up_in_world }
    }

    /// Shifts the view sideways: `share` of the picture's height, right and down.
    pub(crate) fn pan(&mut self, share: DVec2) {
        let height_at_pivot = f64::from(self.lens.height) / self.lens.fy * self.pivot_distance;
        let shift = DVec3::new(-share.x, -share.y, 0.0) * height_at_pivot;
        self.world_from_camera.translation += self.world_from_camera.matrix3 * shift;
    }

    /// Flies: right, down and forward in camera space, in pivot distances.
    pub(crate) fn fly(&mut self, steps: DVec3) {
        self.world_from_camera.translation += self.world_from_camera.matrix3 * steps * self.pivot_distance;
    }

    /// East and north on the ground: for an up of z, x and y.
    fn compass(&self) -> [DVec3; 2] {
        let up = self.up_in_world;
        let about = if up.y.abs() < 0.9 { DVec3::Y } else { DVec3::NEG_Z };
        let east = about.cross(up).normalize_or_zero();
        [east, up.cross(east)]
    }

    /// Heading, pitch and roll.
    pub(crate) fn angles(&self) -> ViewAngles {
        let ([east, north], up) = (self.compass(), self.up_in_world);
        let DMat3 { x_axis: right, y_axis: down, z_axis: forward } = self.world_from_camera.matrix3;
        let pitch = forward.dot(up).clamp(-1.0, 1.0).asin();
        let level = forward - up * forward.dot(up);
        // Straight up or down, the heading is where the picture's upper edge points.
        let ahead = if level.length() > VERTICAL { level } else { down * forward.dot(up).signum() };
        let heading = ahead.dot(east).atan2(ahead.dot(north));
        let level_right = east * heading.cos() - north * heading.sin();
        let level_up = level_right.cross(forward);
        ViewAngles { heading, pitch, roll: (-right.dot(level_up)).atan2(right.dot(level_right)) }
    }

    /// Turns about the eye until the angles are these.
    pub(crate) fn set_angles(&mut self, angles: ViewAngles) {
        let ([east, north], up) = (self.compass(), self.up_in_world);
        let ViewAngles { heading, pitch, roll } = angles;
        let pitch = pitch.clamp(-PI / 2.0, PI / 2.0);
        let ahead = north * heading.cos() + east * heading.sin();
        let forward = (ahead * pitch.cos() + up * pitch.sin()).normalize_or_zero();
        let level_right = east * heading.cos() - north * heading.sin();
        let right = level_right * roll.cos() - level_right.cross(forward) * roll.sin();
        let axes = DMat3::from_cols(right, forward.cross(right), forward);
        self.world_from_camera = DAffine3::from_mat3_translation(axes, self.world_from_camera.translation);
    }

    /// Looks at the pivot along a direction in world space, from as far away as now.
    pub(crate) fn look_along(&mut self, direction_in_world: DVec3) {
        let Some(direction) = direction_in_world.try_normalize() else { return };
        let pivot = self.pivot();
        let [east, north] = self.compass();
        let pitch = direction.dot(self.up_in_world).clamp(-1.0, 1.0).asin();
        let heading = if pitch.abs() > 1.5 { 0.0 } else { direction.dot(east).atan2(direction.dot(north)) };
        self.set_angles(ViewAngles { heading, pitch, roll: 0.0 });
        self.move_pivot_to(pivot);
    }

    /// The horizontal angle of view of the lens, radians.
    pub(crate) fn angle_of_view(&self) -> f64 {
        2.0 * (f64::from(self.lens.width) / (2.0 * self.lens.fx)).atan()
    }

    /// Gives the lens another horizontal angle of view, radians, within [`ANGLES_OF_VIEW`].
    pub(crate) fn set_angle_of_view(&mut self, angle: f64) {
        let [narrowest, widest] = ANGLES_OF_VIEW;
        let focal = f64::from(self.lens.width) / (2.0 * (angle.clamp(narrowest, widest) / 2.0).tan());
        (self.lens.fx, self.lens.fy) = (focal, self.lens.fy * focal / self.lens.fx);
    }

    /// Turns about the line of sight until the horizon is level.
    pub(crate) fn level(&mut self) {
        self.set_angles(ViewAngles { roll: 0.0, ..self.angles() });
    }
}

/// From the first camera to what the cameras look at.
fn home_distance(scene: &OpenScene) -> f64 {
    let first =
        scene.cameras.first().map(|camera| (camera.position_in_world() - scene.pivot_in_world).length());
    first.unwrap_or(1.0).max(LEAST_DISTANCE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbiting_keeps_the_pivot_and_its_distance_and_never_goes_over_the_top() {
        let mut orbit = OrbitCamera::for_tests();
        for i in 0..1000 {
            orbit.orbit(DVec2::new(0.1, if i % 3 == 0 { 0.2 } else { -0.05 }));
        }
        assert!(orbit.pivot().length() < 1e-6);
        assert!((orbit.world_from_camera.translation.length() - 26.0_f64.sqrt()).abs() < 1e-6);
        assert!((orbit.world_from_camera.matrix3.determinant() - 1.0).abs() < 1e-9);
        assert!(orbit.world_from_camera.matrix3.y_axis.z < 0.0, "up is still up");
    }

    #[test]
    fn a_view_shows_all_of_a_framed_picture_and_is_no_other_where_it_did_so_already() {
        let orbit = OrbitCamera::for_tests();
        let wide = [128, 48];
        let framed = orbit.camera(128, 48);
        assert_eq!((framed.intrinsics.fx, framed.intrinsics.cx), (orbit.lens.fx, 64.0), "it is as high");
        let corner = framed.unproject(DVec2::new(128.0, 0.0), 3.0);
        // A square view has bars above and below the frame, and its corner at its edge.
        let (place, _) = orbit.framed(wide).camera(64, 64).project(corner).unwrap();
        assert!((place - DVec2::new(64.0, 20.0)).length() < 1e-9, "{place}");
        assert_eq!(orbit.framed(wide).camera(256, 48), orbit.camera(256, 48));
        assert_eq!(orbit.framed([32, 24]).camera(64, 64), orbit.camera(64, 64));
    }

    #[test]
    fn a_view_in_motion_is_painted_no_finer_than_it_was_recorded_and_one_at_rest_as_fine_as_it_helps() {
        let both = |size| {
            [OrbitCamera::for_tests().size_in_motion(size), OrbitCamera::for_tests().size_at_rest(size)]
        };
        assert_eq!(both([640, 480]), [[64, 48], [128, 96]]);
        assert_eq!(both([1280, 480]), [[128, 48], [256, 96]]);
        assert_eq!(both([96, 72]), [[64, 48], [96, 72]]);
        assert_eq!(both([32, 24]), [[32, 24]; 2]);
        let lens = Intrinsics::from_horizontal_angle(4096, 2304, 1.0);
        let of_a_large_lens = OrbitCamera { lens, ..OrbitCamera::for_tests() };
        assert_eq!(of_a_large_lens.size_in_motion([1920, 1080]), [1600, 900]);
        assert_eq!(of_a_large_lens.size_at_rest([1920, 1080]), [1920, 1080]);
    }

    #[test]
    fn zooming_to_a_point_leaves_it_where_it_is_and_framing_puts_it_in_the_middle() {
        let mut orbit = OrbitCamera::for_tests();
        let point = DVec3::new(0.4, 0.1, 0.3);
        let before = orbit.camera(64, 48).project(point).unwrap();
        orbit.dolly_to(0.5, point);
        let after = orbit.camera(64, 48).project(point).unwrap();
        assert!((before.0 - after.0).length() < 1e-9 && (after.1 - before.1 / 2.0).abs() < 1e-9);
        orbit.frame(point, 0.0);
        let (middle, depth) = orbit.camera(64, 48).project(point).unwrap();
        assert!((middle - DVec2::new(32.0, 24.0)).length() < 1e-9);
        assert!((orbit.pivot_distance - depth).abs() < 1e-9);
        orbit.frame(point, 0.2);
        let camera = orbit.camera(64, 48);
        let tangent = (0.2_f64 / orbit.pivot_distance).asin();
        let [right, down, forward] = [0, 1, 2].map(|axis| camera.world_from_camera.matrix3.col(axis) * 0.2);
        // Where the line of sight touches the ball at its lower side.
        let touched = point + down * tangent.cos() - forward * tangent.sin();
        assert!((camera.project(touched).unwrap().0.y - 48.0).abs() < 1e-6);
        assert!(camera.project(point + right).unwrap().0.x < 64.0);
    }

    #[test]
    fn tiny_and_huge_scenes_are_zoomed_as_ordinary_ones_are() {
        for unit in [1e-9, 1.0, 1e9] {
            let mut orbit = OrbitCamera::for_tests();
            orbit.world_from_camera.translation *= unit;
            orbit.pivot_distance *= unit;
            orbit.home_distance *= unit;
            let eye = orbit.world_from_camera.translation;
            for _ in 0..10 {
                orbit.dolly(0.5);
            }
            assert!((orbit.world_from_camera.translation * 1024.0 - eye).length() < 1e-6 * unit, "{unit}");
            orbit.look_at(orbit.pivot());
            for _ in 0..10 {
                orbit.dolly_to(2.0, DVec3::ZERO);
            }
            assert!((orbit.world_from_camera.translation - eye).length() < 1e-6 * unit, "{unit}");
            assert!((orbit.pivot_distance - eye.length()).abs() < 1e-6 * unit, "{unit}");
            orbit.dolly(1e-9);
            assert!((orbit.pivot_distance / orbit.home_distance - ZOOM[0]).abs() < 1e-9, "{unit}: no nearer");
        }
    }

    #[test]
    fn flying_and_zooming_move_along_the_line_of_sight() {
        let mut orbit = OrbitCamera::for_tests();
        let before = orbit.pivot_distance;
        orbit.dolly(0.5);
        assert!(orbit.pivot().length() < 1e-9 && (orbit.pivot_distance - before / 2.0).abs() < 1e-9);
        orbit.fly(DVec3::Z);
        assert!(orbit.world_from_camera.translation.length() < 1e-9);
    }

    #[test]
    fn angles_that_are_set_are_those_that_are_read_and_the_eye_stays() {
        let mut orbit = OrbitCamera::for_tests();
        let eye = orbit.world_from_camera.translation;
        for up in [DVec3::Z, DVec3::Y, DVec3::NEG_Y, DVec3::new(0.6, 0.0, 0.8)] {
            orbit.up_in_world = up;
            for (heading, pitch, roll) in
                [(0.0, 0.0, 0.0), (1.0, 0.4, -0.3), (-2.5, -1.2, 2.0), (3.0, 1.5, 0.1)]
            {
                orbit.set_angles(ViewAngles { heading, pitch, roll });
                let read = orbit.angles();
                for (read, set) in [(read.heading, heading), (read.pitch, pitch), (read.roll, roll)] {
                    assert!((read - set).abs() < 1e-9, "{up}: {read} for {set}");
                }
                assert!((orbit.world_from_camera.matrix3.determinant() - 1.0).abs() < 1e-12);
                assert_eq!(orbit.world_from_camera.translation, eye);
            }
        }
        orbit.up_in_world = DVec3::Z;
        orbit.set_angles(ViewAngles { heading: 0.0, pitch: 0.0, roll: 0.0 });
        let axes = orbit.world_from_camera.matrix3;
        assert!((axes.z_axis - DVec3::Y).length() < 1e-12, "a level view to the north");
        assert!((axes.x_axis - DVec3::X).length() < 1e-12, "has the east on its right");
    }

    #[test]
    fn a_view_is_leveled_by_another_up_and_looks_where_it_looked() {
        let mut orbit = OrbitCamera::for_tests();
        let forward = orbit.world_from_camera.matrix3.z_axis;
        orbit.up_in_world = DVec3::X;
        orbit.level();
        let DMat3 { x_axis: right, y_axis: down, z_axis } = orbit.world_from_camera.matrix3;
        assert!((z_axis - forward).length() < 1e-12);
        assert!(right.dot(DVec3::X).abs() < 1e-12 && down.dot(DVec3::X) < 0.0);
    }

    #[test]
    fn a_view_along_an_axis_keeps_the_pivot_and_its_distance() {
        for direction in [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            let mut orbit = OrbitCamera::for_tests();
            orbit.look_along(direction);
            assert!((orbit.world_from_camera.matrix3.z_axis - direction).length() < 1e-9, "{direction}");
            assert!(orbit.pivot().length() < 1e-9);
            let angles = orbit.angles();
            assert!(angles.roll.abs() < 1e-9 && angles.pitch.is_finite(), "{angles:?}");
        }
    }

    #[test]
    fn the_angle_of_view_keeps_the_shape_of_pixels_and_stays_in_its_range() {
        let mut orbit = OrbitCamera::for_tests();
        orbit.lens.fy = 2.0 * orbit.lens.fx;
        orbit.set_angle_of_view(0.5);
        assert!((orbit.angle_of_view() - 0.5).abs() < 1e-12);
        assert!((orbit.lens.fy - 2.0 * orbit.lens.fx).abs() < 1e-9);
        orbit.set_angle_of_view(0.0);
        assert!((orbit.angle_of_view() - ANGLES_OF_VIEW[0]).abs() < 1e-9);
    }
}
