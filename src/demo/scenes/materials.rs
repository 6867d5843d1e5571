//! Materials that the demo scenes share.

use glam::Vec3;

use crate::demo::tracer::{Material, Pattern};

/// A linear color from a display's 8-bit one.
pub(crate) fn rgb(hex: u32) -> Vec3 {
    let channel = |shift: u32| crate::color::linear_from_srgb(((hex >> shift) & 0xff) as f32 / 255.0);
    Vec3::new(channel(16), channel(8), channel(0))
}

pub(crate) fn brass() -> Material {
    Material::new(Pattern::Clouds(0.05), rgb(0x00b9_8a3e), rgb(0x00e0_b868))
}

pub(crate) fn dark_brass() -> Material {
    Material::new(Pattern::Clouds(0.04), rgb(0x0080_5a26), rgb(0x00a8_7a38))
}

pub(crate) fn walnut() -> Material {
    Material::new(Pattern::Planks(0.14), rgb(0x008a_5a36), rgb(0x004a_2c19))
}

pub(crate) fn oak() -> Material {
    Material::new(Pattern::Planks(0.12), rgb(0x00c8_9f6a), rgb(0x009a_6c3e))
}

pub(crate) fn turned_wood() -> Material {
    Material::new(Pattern::Rings(0.03), rgb(0x009c_6238), rgb(0x0058_3019))
}

pub(crate) fn brick() -> Material {
    Material::new(Pattern::Bricks(0.075), rgb(0x00b0_644a), rgb(0x00b8_ac9c))
}

pub(crate) fn plaster(color: u32) -> Material {
    let color = rgb(color);
    Material::new(Pattern::Clouds(0.35), color * 0.9, color * 1.06)
}

pub(crate) fn marble() -> Material {
    Material::new(Pattern::Marble(0.22), rgb(0x00e4_ded2), rgb(0x0070_6c70))
}

pub(crate) fn slate() -> Material {
    Material::new(Pattern::Marble(0.2), rgb(0x0048_5058), rgb(0x0098_a0a2))
}

/// Rivers on old paper: from across the room, a map.
pub(crate) fn map_canvas() -> Material {
    Material::new(Pattern::Marble(0.3), rgb(0x00d8_b078), rgb(0x002c_4a68))
}

pub(crate) fn book(cover: u32, band: u32, half_thickness: f32) -> Material {
    Material::new(Pattern::Book(half_thickness), rgb(cover), rgb(band))
}
