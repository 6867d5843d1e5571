//! Splats as PLY.
//!
//! Source: Kerbl et al., *3D Gaussian Splatting for Real-Time Radiance Field Rendering*, SIGGRAPH 2023, the files of its program. What
//! differs: colors do not depend on direction, and normals are written, where that program writes zeros.

use std::io::{self, Write};

use glam::{DVec3, Vec3};

use super::gaussian::{Gaussian, coefficients};

/// Floats of a splat, in their order.
const PROPERTIES: [&str; 17] = [
    "x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1",
    "scale_2", "rot_0", "rot_1", "rot_2", "rot_3",
];

/// Writes splats. `offset` is what has to be added to the positions for those of the capture, in the axes of the file.
pub(super) fn write(
    target: &mut impl Write,
    name: &str,
    splats: &[Gaussian],
    offset: Option<DVec3>,
) -> io::Result<()> {
    let name = name.replace(['\n', '\r'], " ");
    let offset = offset
        .map_or(String::new(), |offset| format!("comment offset {} {} {}\n", offset.x, offset.y, offset.z));
    let properties = PROPERTIES.map(|name| format!("property float {name}\n")).concat();
    let count = splats.len();
    write!(
        target,
        "ply\nformat binary_little_endian 1.0\ncomment {name}, by overlook\n{offset}element vertex {count}\n{properties}end_header\n"
    )?;
    for splat in splats {
        target.write_all(bytemuck::bytes_of(&floats(splat).map(|float| float.to_bits().to_le())))?;
    }
    Ok(())
}

fn floats(splat: &Gaussian) -> [f32; PROPERTIES.len()] {
    let [red, green, blue] = coefficients(splat.color);
    let normal = splat.rotation * Vec3::Z;
    let opacity = (splat.opacity / (1.0 - splat.opacity)).ln();
    let [long, short, flat] = splat.radii.to_array().map(f32::ln);
    let (center, rotation) = (splat.center, splat.rotation);
    [
        center.x, center.y, center.z, normal.x, normal.y, normal.z, red, green, blue, opacity, long, short,
        flat, rotation.w, rotation.x, rotation.y, rotation.z,
    ]
}
