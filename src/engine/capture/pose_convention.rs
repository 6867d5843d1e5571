//! How a file means the pose of a camera: which way the matrix maps, and where the camera's axes point.
//!
//! A program's axes are named by where they point in the picture: OpenGL's x, y, z point right, up, back; OpenCV's right, down,
//! forward, which are ours. A matrix of either direction, with any of the 48 signed orders of axes, gives the same pose.

use glam::{DAffine3, DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Which way the matrix of a pose maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseDirection {
    /// Camera space to world space; its last column is the camera's position.
    #[default]
    CameraToWorld,
    /// World space to camera space: an extrinsic matrix.
    WorldToCamera,
}

impl PoseDirection {
    /// As the manifest has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::CameraToWorld => "camera_to_world",
            Self::WorldToCamera => "world_to_camera",
        }
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::CameraToWorld => "camera to world",
            Self::WorldToCamera => "world to camera",
        }
    }
}

/// Where an axis of camera space points, as the picture shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AxisDirection {
    /// To the right of the picture.
    Right,
    /// To its left.
    Left,
    /// To its top.
    Up,
    /// To its bottom.
    Down,
    /// Into the picture, along the line of sight.
    Forward,
    /// Toward the viewer.
    #[serde(alias = "backward")]
    Back,
}

impl AxisDirection {
    const ALL: [Self; 6] = [Self::Right, Self::Left, Self::Up, Self::Down, Self::Forward, Self::Back];

    /// In our camera space: x right, y down, z forward.
    #[must_use]
    pub fn in_camera(self) -> DVec3 {
        match self {
            Self::Right => DVec3::X,
            Self::Left => DVec3::NEG_X,
            Self::Up => DVec3::NEG_Y,
            Self::Down => DVec3::Y,
            Self::Forward => DVec3::Z,
            Self::Back => DVec3::NEG_Z,
        }
    }

    /// As the manifest has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
            Self::Up => "up",
            Self::Down => "down",
            Self::Forward => "forward",
            Self::Back => "back",
        }
    }
}

/// Where the x, y and z axis of a file's camera space point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "[AxisDirection; 3]", into = "[AxisDirection; 3]")]
pub struct CameraAxes([AxisDirection; 3]);

impl CameraAxes {
    /// OpenGL's, Blender's and nerfstudio's: x right, y up, z back.
    pub const OPENGL: Self = Self([AxisDirection::Right, AxisDirection::Up, AxisDirection::Back]);
    /// OpenCV's and COLMAP's, and ours: x right, y down, z forward.
    pub const OPENCV: Self = Self([AxisDirection::Right, AxisDirection::Down, AxisDirection::Forward]);
    /// Direct3D's, which are left-handed: x right, y up, z forward.
    pub const DIRECT3D: Self = Self([AxisDirection::Right, AxisDirection::Up, AxisDirection::Forward]);

    /// All 48; those that are right-handed first.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let every = || AxisDirection::ALL.into_iter();
        let triples = every().flat_map(|x| every().flat_map(move |y| every().map(move |z| [x, y, z])));
        let mut all: Vec<Self> = triples.filter_map(|axes| Self::try_from(axes).ok()).collect();
        all.sort_by_key(|axes| !axes.is_right_handed());
        all
    }

    /// The file's camera space from ours: a signed permutation. Its rows are the directions of the file's axes.
    #[must_use]
    pub fn file_from_camera(self) -> DMat3 {
        let [x, y, z] = self.0.map(AxisDirection::in_camera);
        DMat3::from_cols(x, y, z).transpose()
    }

    /// Whether x, y and z are a right-handed frame, as OpenGL's and OpenCV's; Unity's are not.
    #[must_use]
    pub fn is_right_handed(self) -> bool {
        self.file_from_camera().determinant() > 0.0
    }

    /// In words: `x right, y up, z back`.
    #[must_use]
    pub fn words(self) -> String {
        let [x, y, z] = self.0.map(AxisDirection::name);
        format!("x {x}, y {y}, z {z}")
    }

    /// As a value of JSON.
    #[must_use]
    pub fn json(self) -> String {
        let [x, y, z] = self.0.map(AxisDirection::name);
        format!("[\"{x}\", \"{y}\", \"{z}\"]")
    }
}

impl TryFrom<[AxisDirection; 3]> for CameraAxes {
    type Error = String;

    /// # Errors
    /// If two of them are along one line.
    fn try_from(axes: [AxisDirection; 3]) -> Result<Self, String> {
        let [x, y, z] = axes.map(AxisDirection::in_camera);
        if x.dot(y.cross(z)).abs() > 0.5 {
            Ok(Self(axes))
        } else {
            Err(format!("{} do not span a space", Self(axes).words()))
        }
    }
}

impl From<CameraAxes> for [AxisDirection; 3] {
    fn from(axes: CameraAxes) -> Self {
        axes.0
    }
}

/// How the matrix of a pose is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct PoseConvention {
    /// Which way it maps.
    pub direction: PoseDirection,
    /// Where the axes of the file's camera space point.
    pub axes: CameraAxes,
}

impl Default for PoseConvention {
    /// nerfstudio's: camera to world, OpenGL's axes.
    fn default() -> Self {
        Self { direction: PoseDirection::CameraToWorld, axes: CameraAxes::OPENGL }
    }
}

impl PoseConvention {
    /// World space from our camera space, given the matrix as the file has it.
    ///
    /// It mirrors where the file's world is left-handed; see [`upright`].
    #[must_use]
    pub fn world_from_camera(self, matrix: &DAffine3) -> DAffine3 {
        let axes = DAffine3::from_mat3(self.axes.file_from_camera());
        match self.direction {
            PoseDirection::CameraToWorld => *matrix * axes,
            PoseDirection::WorldToCamera => matrix.inverse() * axes,
        }
    }

    /// The matrix as a file of this convention has it.
    #[must_use]
    pub fn matrix(self, world_from_camera: &DAffine3) -> DAffine3 {
        let matrix = *world_from_camera * DAffine3::from_mat3(self.axes.file_from_camera().transpose());
        match self.direction {
            PoseDirection::CameraToWorld => matrix,
            PoseDirection::WorldToCamera => matrix.inverse(),
        }
    }
}

/// The mirror image of a world along its y axis.
pub const MIRROR: DAffine3 =
    DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0)), translation: DVec3::ZERO };

/// The same pose in a right-handed world: one of a left-handed world is mirrored along its y axis. All cameras of a capture have
/// poses of one handedness, so that all are mirrored or none.
#[must_use]
pub fn upright(world_from_camera: DAffine3) -> DAffine3 {
    if world_from_camera.matrix3.determinant() < 0.0 { MIRROR * world_from_camera } else { world_from_camera }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_48_axes_and_half_of_them_are_right_handed() {
        let all = CameraAxes::all();
        assert_eq!(all.len(), 48);
        assert_eq!(all.iter().filter(|axes| axes.is_right_handed()).count(), 24);
        assert!(CameraAxes::OPENGL.is_right_handed() && CameraAxes::OPENCV.is_right_handed());
    }

    #[test]
    fn a_matrix_of_any_convention_gives_the_pose_it_was_made_of() {
        let pose = DAffine3::from_rotation_y(0.4) * DAffine3::from_translation(DVec3::new(1.0, -2.0, 3.0));
        for axes in CameraAxes::all() {
            for direction in [PoseDirection::CameraToWorld, PoseDirection::WorldToCamera] {
                let convention = PoseConvention { direction, axes };
                let again = convention.world_from_camera(&convention.matrix(&pose));
                assert!(again.abs_diff_eq(pose, 1e-12), "{convention:?}");
            }
        }
    }

    #[test]
    fn opengl_differs_from_ours_by_half_a_turn_about_x() {
        let flip = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
        assert_eq!(CameraAxes::OPENGL.file_from_camera(), flip);
        assert_eq!(CameraAxes::OPENCV.file_from_camera(), DMat3::IDENTITY);
    }

    #[test]
    fn axes_along_one_line_are_refused() {
        assert!(serde_json::from_str::<CameraAxes>("[\"right\", \"left\", \"up\"]").is_err());
        let axes: CameraAxes = serde_json::from_str("[\"right\", \"up\", \"backward\"]").unwrap();
        assert_eq!(axes, CameraAxes::OPENGL);
    }

    #[test]
    fn a_left_handed_world_is_mirrored_whole() {
        let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert!(upright(mirrored).matrix3.determinant() > 0.0);
        assert_eq!(upright(DAffine3::IDENTITY), DAffine3::IDENTITY);
    }
}
