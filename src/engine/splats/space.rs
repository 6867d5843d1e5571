//! From the world to the axes of a format.

use glam::{DMat3, DQuat, DVec3, Vec3};

use super::options::SplatFormat;
use crate::samples::{SampleSet, are_far_from_origin};

/// World units beyond which a sample counts as one at infinity: squares of its coordinates leave single precision not much farther off.
pub(super) const FARTHEST: f64 = 1e15;

/// Whether a sample of some inverse depth has a place.
pub(super) fn is_near(inverse_depth: f32) -> bool {
    f64::from(inverse_depth) > 1.0 / FARTHEST
}

/// Which way the axes of a format point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axes {
    /// x right, y down, z forward: PLY, by custom.
    DownForward,
    /// x right, y up, z back: SPZ, glTF, USD.
    BackUp,
}

impl Axes {
    fn of(format: SplatFormat) -> Self {
        match format {
            SplatFormat::Ply => Self::DownForward,
            SplatFormat::Spz | SplatFormat::Glb | SplatFormat::Usda => Self::BackUp,
        }
    }

    /// From a world with z up.
    fn turn_of_z_up(self) -> DMat3 {
        match self {
            // (x, −z, y)
            Self::DownForward => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
            // (x, z, −y)
            Self::BackUp => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
        }
    }
}

/// Where the world lies in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Space {
    /// A rotation, from the axes of the world to those of the file.
    pub(super) turn: DMat3,
    /// What the origin of the file is in the world, in whole units; zero unless cameras stand far from the origin: files hold single
    /// precision.
    pub(super) origin_in_world: DVec3,
}

impl Space {
    /// The space of a set, in the axes of a format.
    pub(super) fn of(set: &SampleSet, format: SplatFormat) -> Self {
        let upright = set.up_in_world.try_normalize().map_or(DMat3::IDENTITY, |up| {
            if up == DVec3::Z {
                DMat3::IDENTITY
            } else {
                DMat3::from_quat(DQuat::from_rotation_arc(up, DVec3::Z))
            }
        });
        Self { turn: Axes::of(format).turn_of_z_up() * upright, ..Self::of_world(set) }
    }

    /// The space of a set, in the axes of its world.
    pub(super) fn of_world(set: &SampleSet) -> Self {
        let count = set.cameras.len().max(1) as f64;
        let middle = set.cameras.iter().map(|camera| camera.position_in_world() / count).sum::<DVec3>();
        let is_far = are_far_from_origin(&set.cameras);
        Self { turn: DMat3::IDENTITY, origin_in_world: if is_far { middle.round() } else { DVec3::ZERO } }
    }

    /// A point of the world in the file.
    pub(super) fn place(&self, point_in_world: DVec3) -> Vec3 {
        (self.turn * (point_in_world - self.origin_in_world)).as_vec3()
    }

    /// The file's origin in the file's axes, where one was taken: what has to be added to its numbers.
    pub(super) fn offset(&self) -> Option<DVec3> {
        (self.origin_in_world != DVec3::ZERO).then(|| self.turn * self.origin_in_world)
    }
}

#[cfg(test)]
impl Space {
    /// The space of a world with z up around its origin.
    pub(super) fn upright(axes: Axes) -> Self {
        Self { turn: axes.turn_of_z_up(), origin_in_world: DVec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::{Camera, Intrinsics};
    use crate::settings::Settings;
    use glam::DAffine3;

    fn set(up_in_world: DVec3, position: DVec3) -> SampleSet {
        let intrinsics = Intrinsics::from_horizontal_angle(4, 4, 0.9);
        let world_from_camera = DAffine3::from_translation(position);
        SampleSet {
            name: "s".into(),
            cameras: vec![Camera { name: "c".into(), intrinsics, world_from_camera }],
            frame_numbers: vec![0],
            up_in_world,
            settings: Settings::default(),
            images: Vec::new(),
            values: Vec::new(),
        }
    }

    #[test]
    fn a_world_with_z_up_keeps_every_bit_of_its_coordinates() {
        let set = set(DVec3::Z, DVec3::ZERO);
        let point = DVec3::new(1.25, 2.5, 3.75);
        assert_eq!(Space::of(&set, SplatFormat::Ply).place(point), Vec3::new(1.25, -3.75, 2.5));
        for format in [SplatFormat::Spz, SplatFormat::Glb, SplatFormat::Usda] {
            assert_eq!(Space::of(&set, format).place(point), Vec3::new(1.25, 3.75, -2.5));
        }
    }

    #[test]
    fn up_is_up_in_every_format_whichever_way_it_is_in_the_world_and_nothing_is_mirrored() {
        for up in [DVec3::Z, DVec3::Y, DVec3::NEG_Z, DVec3::new(0.0, 0.6, 0.8), DVec3::NEG_X, DVec3::ZERO] {
            let set = set(up, DVec3::ZERO);
            let expected = if up == DVec3::ZERO { DVec3::Z } else { up };
            for (format, is) in [(SplatFormat::Ply, Vec3::NEG_Y), (SplatFormat::Glb, Vec3::Y)] {
                let space = Space::of(&set, format);
                assert!((space.place(expected) - is).length() < 1e-6, "{up} {format}");
                assert!((space.turn.determinant() - 1.0).abs() < 1e-12);
            }
        }
        let of_y = Space::of(&set(DVec3::Y, DVec3::ZERO), SplatFormat::Glb);
        assert!((of_y.place(DVec3::new(1.0, 2.0, 3.0)) - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
    }

    #[test]
    fn millimeters_survive_far_from_the_origin_and_the_offset_gives_the_place_back() {
        let far = DVec3::new(447_512.25, 5_411_850.5, 312.0);
        let space = Space::of(&set(DVec3::Z, far), SplatFormat::Usda);
        let point = far + DVec3::new(10.001, -3.002, 1.003);
        let offset = space.offset().unwrap();
        let back = space.turn.transpose() * (space.place(point).as_dvec3() + offset);
        assert!((back - point).length() < 1e-5, "{back}");
        assert_eq!(offset, offset.round());
        assert_eq!(Space::of(&set(DVec3::Z, DVec3::ONE), SplatFormat::Ply).offset(), None);
    }
}
