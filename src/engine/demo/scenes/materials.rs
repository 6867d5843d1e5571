//! Materials that the demo scenes share.

use glam::Vec3;

use crate::demo::tracer::{Material, Pattern};

/// A linear color from a display's 8-bit one.
pub(crate) fn rgb(hex: u32) -> Vec3 {
    let channel = |shift: u32| crate::color::linear_from_srgb(((hex >> shift) & 0xff) as f32 / 255.0);
    Vec3::new(channel(16), channel(8), channel(0))
}

/// A pattern between two colors, as 8-bit ones of a display.
pub(crate) fn two_tone(pattern: Pattern, a: u32, b: u32) -> Material {
    Material::new(pattern, rgb(a), rgb(b))
}

pub(crate) fn brass() -> Material {
    two_tone(Pattern::Clouds(0.05), 0x00b9_8a3e, 0x00e0_b868)
}

pub(crate) fn dark_brass() -> Material {
    two_tone(Pattern::Clouds(0.04), 0x0080_5a26, 0x00a8_7a38)
}

pub(crate) fn walnut() -> Material {
    two_tone(Pattern::Planks(0.14), 0x008a_5a36, 0x004a_2c19)
}

pub(crate) fn oak() -> Material {
    two_tone(Pattern::Planks(0.12), 0x00c8_9f6a, 0x009a_6c3e)
}

pub(crate) fn turned_wood() -> Material {
    two_tone(Pattern::Rings(0.03), 0x009c_6238, 0x0058_3019)
}

pub(crate) fn brick() -> Material {
    two_tone(Pattern::Bricks(0.075), 0x00b0_644a, 0x00b8_ac9c)
}

pub(crate) fn plaster(color: u32) -> Material {
    let color = rgb(color);
    Material::new(Pattern::Clouds(0.35), color * 0.9, color * 1.06)
}

pub(crate) fn marble() -> Material {
    two_tone(Pattern::Marble(0.22), 0x00e4_ded2, 0x0070_6c70)
}

pub(crate) fn slate() -> Material {
    two_tone(Pattern::Marble(0.2), 0x0048_5058, 0x0098_a0a2)
}

/// Rivers on old paper: from across the room, a map.
pub(crate) fn map_canvas() -> Material {
    two_tone(Pattern::Marble(0.3), 0x00d8_b078, 0x002c_4a68)
}

pub(crate) fn book(cover: u32, band: u32, half_thickness: f32) -> Material {
    two_tone(Pattern::Book(half_thickness), cover, band)
}
