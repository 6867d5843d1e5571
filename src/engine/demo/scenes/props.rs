//! Materials and props that the demo scenes share.

use std::f64::consts::PI;

use glam::{DMat3, DVec3, Vec3};

use crate::demo::tracer::{
    Material, Pattern, WorldBuilder, block, cone, cylinder, sphere, torus, upright_to,
};

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

/// A stack of books on `place`: cover color and turn (radians) of each, from the lowest.
pub(crate) fn books(stage: &mut WorldBuilder, place: DVec3, covers: &[(u32, f64)]) {
    let mut height = 0.0;
    for (index, (cover, turn)) in covers.iter().enumerate() {
        let half = DVec3::new(
            0.105 - 0.008 * index as f64,
            0.15 - 0.012 * index as f64,
            0.024 - 0.002 * index as f64,
        );
        let material = book(*cover, 0x00d8_b868, half.z as f32);
        let center = place + DVec3::Z * (height + half.z);
        stage.add_turned(block(half, 0.004), center, DMat3::from_rotation_z(*turn), material);
        height += 2.0 * half.z;
    }
}

/// A globe of the given radius on a turned foot, with its brass meridian.
pub(crate) fn globe(stage: &mut WorldBuilder, place: DVec3, radius: f64) {
    let center = place + DVec3::Z * (radius + 0.11);
    let tilt = DMat3::from_rotation_y(0.41);
    let earth = two_tone(Pattern::Continents(radius as f32), 0x002c_6088, 0x0056_7a3c);
    stage.add_turned(sphere(radius), center, tilt * DMat3::from_rotation_z(0.7), earth);
    let meridian = torus(radius + 0.014, 0.008);
    stage.add_turned(meridian, center, tilt * DMat3::from_rotation_x(0.5 * PI), brass());
    let axis = tilt * DVec3::Z * (radius + 0.04);
    stage.add_bar((center - axis, center + axis), (0.006, 0.006), dark_brass());
    stage.add(cone(0.1, 0.085, 0.012), place + DVec3::Z * 0.012, turned_wood());
    stage.add(cone(0.06, 0.018, 0.025), place + DVec3::Z * 0.049, turned_wood());
    stage.add(cylinder(0.014, 0.02), place + DVec3::Z * 0.082, brass());
}

/// An hourglass whose sand has run through.
pub(crate) fn hourglass(stage: &mut WorldBuilder, place: DVec3) {
    let sand = two_tone(Pattern::Speckles(0.012), 0x00d8_b888, 0x00a8_8050);
    for z in [0.008, 0.232] {
        stage.add(cylinder(0.07, 0.008), place + DVec3::Z * z, turned_wood());
    }
    stage.add(cone(0.05, 0.008, 0.05), place + DVec3::Z * 0.068, sand);
    let glass = two_tone(Pattern::Clouds(0.06), 0x00b8_ccd0, 0x0098_b4ba);
    stage.add(cone(0.008, 0.05, 0.053), place + DVec3::Z * 0.171, glass);
    for corner in 0..3 {
        let angle = 2.0 * PI * f64::from(corner) / 3.0;
        let foot = place + DVec3::new(0.058 * angle.cos(), 0.058 * angle.sin(), 0.01);
        stage.add_bar((foot, foot + DVec3::Z * 0.22), (0.006, 0.006), brass());
    }
}

/// A brick arch against a wall at `place`: half its width, and the height of its springing, m.
pub(crate) fn arch(stage: &mut WorldBuilder, place: DVec3, half_width: f64, springing: f64) {
    let pillar = block([0.11, 0.13, 0.5 * springing], 0.0);
    for side in [-1.0, 1.0] {
        let pillar_place = place + DVec3::new(side * (half_width + 0.11), 0.0, 0.5 * springing);
        stage.add(pillar.clone(), pillar_place, brick());
        let capital = block([0.14, 0.16, 0.035], 0.01);
        let capital_place = place + DVec3::new(side * (half_width + 0.11), 0.0, springing + 0.035);
        stage.add(capital, capital_place, marble());
    }
    let center = place + DVec3::Z * (springing + 0.07);
    let stones = 15_u32;
    for stone in 0..stones {
        let angle = PI * (f64::from(stone) + 0.5) / f64::from(stones);
        let outward = DVec3::new(angle.cos(), 0.0, angle.sin());
        let wide = 0.5 * PI * (half_width + 0.11) / f64::from(stones) - 0.004;
        let tone = [0x00a8_5c42, 0x00b8_7050, 0x0098_523c, 0x00b0_6648][(stone * 7 % 4) as usize];
        let rotation = DMat3::from_cols(outward.cross(DVec3::Y) * -1.0, DVec3::Y, outward);
        let material = Material::new(Pattern::Speckles(0.03), rgb(tone), rgb(tone) * 0.7);
        let stone_place = center + outward * (half_width + 0.11);
        stage.add_turned(block([wide, 0.13, 0.11], 0.008), stone_place, rotation, material);
    }
    let key = block([0.06, 0.15, 0.15], 0.01);
    stage.add(key, center + DVec3::Z * (half_width + 0.12), marble());
}

/// A rug with the given half extents (x, y).
pub(crate) fn rug(stage: &mut WorldBuilder, place: DVec3, (x, y): (f64, f64)) {
    let pattern = Pattern::Rug(x as f32, y as f32);
    let material = Material::new(pattern, rgb(0x007c_2c2c), rgb(0x0028_3a54));
    stage.add(block([x, y, 0.008], 0.0), place + DVec3::Z * 0.008, material);
}

/// A fluted stone plinth of the given height.
pub(crate) fn plinth(stage: &mut WorldBuilder, place: DVec3, height: f64) {
    let stone = plaster(0x00cc_c2b0);
    stage.add(block([0.24, 0.24, 0.05], 0.01), place + DVec3::Z * 0.05, stone);
    stage.add(block([0.24, 0.24, 0.03], 0.01), place + DVec3::Z * (height - 0.03), stone);
    stage.add(cylinder(0.15, 0.5 * height - 0.08), place + DVec3::Z * (0.5 * height + 0.02), stone);
    for flute in 0..16 {
        let angle = PI * f64::from(flute) / 8.0;
        let foot = place + DVec3::new(0.15 * angle.cos(), 0.15 * angle.sin(), 0.1);
        stage.add_bar((foot, foot + DVec3::Z * (height - 0.16)), (0.018, 0.018), stone);
    }
    stage.add(torus(0.165, 0.025), place + DVec3::Z * 0.125, stone);
    stage.add(torus(0.165, 0.02), place + DVec3::Z * (height - 0.08), stone);
}

/// A framed canvas with the given half extents (x, z), on a wall that faces −y.
pub(crate) fn frame(stage: &mut WorldBuilder, place: DVec3, (x, z): (f64, f64), canvas: Material) {
    stage.add(block([x, 0.012, z], 0.0), place, canvas);
    for side in [-1.0, 1.0] {
        stage.add(block([0.025, 0.025, z + 0.025], 0.008), place + DVec3::X * (side * x), dark_brass());
        stage.add(block([x + 0.027, 0.027, 0.025], 0.008), place + DVec3::Z * (side * z), dark_brass());
    }
}

/// A chest of open shelves, `half` its half extents, its back toward +y.
pub(crate) fn shelf(stage: &mut WorldBuilder, place: DVec3, half: DVec3, boards: u32) {
    for side in [-1.0, 1.0] {
        let upright = place + DVec3::new(side * (half.x - 0.015), 0.0, half.z);
        stage.add(block([0.015, half.y, half.z], 0.003), upright, walnut());
    }
    let back = place + DVec3::new(0.0, half.y - 0.008, half.z);
    stage.add(block([half.x, 0.008, half.z], 0.0), back, turned_wood());
    for board in 0..=boards {
        let z = 0.06 + (2.0 * half.z - 0.075) * f64::from(board) / f64::from(boards);
        stage.add(block([half.x - 0.03, half.y - 0.01, 0.012], 0.003), place + DVec3::Z * z, walnut());
    }
}

/// Upright books along x, from `place`: as many as there are colors, with their spines toward −y.
pub(crate) fn book_row(stage: &mut WorldBuilder, place: DVec3, covers: &[u32]) {
    let mut x = 0.0;
    for (index, cover) in covers.iter().enumerate() {
        let thick = 0.014 + 0.004 * ((index * 7) % 4) as f64;
        let tall = 0.1 + 0.012 * ((index * 5) % 4) as f64;
        // The solid's −x, the spine, faces the room; its z runs along the shelf.
        let rotation = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
        let half = DVec3::new(0.075, tall, thick);
        let center = place + DVec3::new(x + thick, 0.0, tall);
        let material = book(*cover, [0x00d8_b868, 0x00e0_d8c0][index % 2], thick as f32);
        stage.add_turned(block(half, 0.003), center, rotation, material);
        x += 2.0 * thick + 0.001;
    }
}

/// A potted plant with leaves in a spiral.
pub(crate) fn plant(stage: &mut WorldBuilder, place: DVec3, leaves: u32) {
    let clay = two_tone(Pattern::Stripes(0.09), 0x00b8_6a48, 0x00d0_8a62);
    stage.add(cone(0.12, 0.17, 0.16), place + DVec3::Z * 0.16, clay);
    let soil = Material::plain(rgb(0x0034_261c));
    stage.add(cylinder(0.15, 0.005), place + DVec3::Z * 0.322, soil);
    for leaf in 0..leaves {
        let share = f64::from(leaf) / f64::from(leaves);
        let angle = 2.399_963 * f64::from(leaf);
        let lean = 0.2 + 0.75 * (1.0 - share);
        let outward = DVec3::new(angle.cos() * lean, angle.sin() * lean, 1.0 - 0.45 * lean);
        let length = 0.42 + 0.25 * share;
        let root = place + DVec3::Z * (0.32 + 0.12 * share);
        let green = two_tone(Pattern::Stripes(0.05), 0x0040_6c38, 0x0068_9848);
        let rotation = upright_to(outward);
        let half = DVec3::new(0.035, 0.006, 0.5 * length);
        stage.add_turned(block(half, 0.006), root + outward * (0.5 * length), rotation, green);
    }
}
