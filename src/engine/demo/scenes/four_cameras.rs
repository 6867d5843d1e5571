//! The paper's second set-up, and what it was invented for: a crystallization. Crystals grow on a stone slab while a
//! ball bounces beside them; four cameras, long and still, one close.
//!
//! What moves, its shadow included, stays within few pixels: over all frames together about one in twenty.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec3, DVec4, Vec3};

use super::props::{self, brass, dark_brass, marble, plaster, rgb, slate, turned_wood, two_tone, walnut};
use super::{SceneCameras, vantage};
use crate::demo::tracer::{
    Backdrop, Light, Material, Pattern, SolidShape, WorldBuilder, block, cone, cylinder, hash, sphere, torus,
    upright_to,
};

const BENCH_TOP_M: f64 = 0.9;
const SLAB_TOP_M: f64 = BENCH_TOP_M + 0.06;

/// The scene at a moment, 0 to 1: the crystals grow from first to last, the ball's bounces close a loop.
pub(crate) fn stage(moment: f64) -> WorldBuilder {
    let mut stage = WorldBuilder::new(Light {
        to_sun: DVec3::new(-0.36, -0.3, 0.95).normalize_or_zero(),
        sun: Vec3::new(0.95, 0.88, 0.76),
        sun_spread: 0.04,
        zenith: Vec3::new(0.32, 0.37, 0.46),
        horizon: Vec3::new(0.47, 0.48, 0.5),
        ground: Vec3::new(0.2, 0.17, 0.14),
        backdrop: Backdrop::EVENING,
        contact: 0.09,
        lamp: None,
    });
    laboratory(&mut stage);
    glassware(&mut stage);
    molecule(&mut stage, DVec3::new(-0.52, 0.22, BENCH_TOP_M));
    crystals(&mut stage, DVec3::new(0.08, 0.02, SLAB_TOP_M), moment);
    ball(&mut stage, moment);
    stage
}

fn laboratory(stage: &mut WorldBuilder) {
    let floor = two_tone(Pattern::Tiles(0.35), 0x00b8_b4aa, 0x0070_7478);
    stage.add(block([3.5, 3.5, 0.1], 0.0), DVec3::new(0.0, 0.0, -0.1), floor);
    let glazed = two_tone(Pattern::Bricks(0.1), 0x00ca_d6cc, 0x008a_968e);
    stage.add(block([2.4, 0.1, 1.3], 0.0), DVec3::new(0.0, 1.25, 1.3), glazed);
    stage.add(block([0.1, 1.6, 1.3], 0.0), DVec3::new(-2.0, -0.2, 1.3), plaster(0x00a4_b0a8));
    stage.add(block([1.15, 0.55, 0.03], 0.01), DVec3::new(0.0, 0.1, BENCH_TOP_M - 0.03), walnut());
    stage.add(block([1.05, 0.47, 0.36], 0.01), DVec3::new(0.0, 0.1, BENCH_TOP_M - 0.42), turned_wood());
    for column in 0..4 {
        let x = -0.78 + 0.52 * f64::from(column);
        for z in [0.32, 0.68] {
            let front = DVec3::new(x, -0.375, z);
            stage.add(block([0.24, 0.012, 0.155], 0.008), front, walnut());
            stage.add(sphere(0.018), front - DVec3::Y * 0.025, brass());
        }
    }
    stage.add(block([0.36, 0.27, 0.03], 0.012), DVec3::new(0.08, 0.02, BENCH_TOP_M + 0.03), slate());
    let board = DVec3::new(0.1, 1.05, 1.62);
    stage.add(block([0.95, 0.1, 0.018], 0.004), board, walnut());
    let covers = [0x0070_2f2a, 0x002d_4a5c, 0x00a8_8c50, 0x0038_5038, 0x004c_3a5e, 0x008a_4a30];
    props::book_row(stage, board + DVec3::new(-0.85, 0.0, 0.02), &[covers, covers].concat());
    props::globe(stage, board + DVec3::new(0.1, -0.01, 0.018), 0.085);
    jars(stage, board + DVec3::new(0.36, 0.0, 0.018));
    props::books(stage, DVec3::new(0.83, 0.33, BENCH_TOP_M), &[(0x002d_4a5c, 0.3), (0x0070_2f2a, 0.7)]);
}

fn jars(stage: &mut WorldBuilder, place: DVec3) {
    for (index, color) in [0x0030_7080, 0x00c0_8030, 0x0080_3848, 0x0050_7040].into_iter().enumerate() {
        let foot = place + DVec3::X * (0.15 * index as f64);
        let glaze = two_tone(Pattern::Stripes(0.07), color, 0x00e0_d8c4);
        stage.add(cylinder(0.052, 0.065), foot + DVec3::Z * 0.065, glaze);
        stage.add(cone(0.045, 0.03, 0.012), foot + DVec3::Z * 0.142, turned_wood());
        stage.add(sphere(0.016), foot + DVec3::Z * 0.165, brass());
    }
}

fn glassware(stage: &mut WorldBuilder) {
    let glass = |tint: u32| Material::new(Pattern::Clouds(0.08), rgb(tint), rgb(tint) * 1.15);
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, BENCH_TOP_M + z);
    stage.add(cone(0.09, 0.024, 0.085), at(-0.22, 0.46, 0.085), glass(0x0068_a0a8));
    stage.add(cylinder(0.024, 0.04), at(-0.22, 0.46, 0.21), glass(0x00b8_ccd0));
    stage.add(torus(0.025, 0.006), at(-0.22, 0.46, 0.25), glass(0x00b8_ccd0));
    stage.add(sphere(0.085), at(0.5, 0.45, 0.15), glass(0x00c8_9048));
    stage.add(cylinder(0.02, 0.07), at(0.5, 0.45, 0.29), glass(0x00b8_ccd0));
    stage.add(torus(0.06, 0.008), at(0.5, 0.45, 0.075), dark_brass());
    for leg in 0..3 {
        let angle = TAU * f64::from(leg) / 3.0;
        let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let foot = at(0.5, 0.45, 0.0) + out * 0.085;
        stage.add_bar((foot, at(0.5, 0.45, 0.075) + out * 0.06), (0.006, 0.006), dark_brass());
    }
    let tray = at(0.72, -0.16, 0.0);
    stage.add(cylinder(0.13, 0.012), tray + DVec3::Z * 0.012, marble());
    stage.add(torus(0.13, 0.014), tray + DVec3::Z * 0.02, brass());
    props::hourglass(stage, at(0.98, 0.2, 0.0));
}

/// A model of a molecule: balls and sticks on a stand.
fn molecule(stage: &mut WorldBuilder, place: DVec3) {
    stage.add(cone(0.09, 0.07, 0.015), place + DVec3::Z * 0.015, turned_wood());
    let center = place + DVec3::Z * 0.3;
    stage.add_bar((place, center), (0.008, 0.008), brass());
    let carbon = two_tone(Pattern::Clouds(0.04), 0x0038_3a40, 0x0050_545c);
    let oxygen = two_tone(Pattern::Clouds(0.04), 0x00b8_3830, 0x00d0_5040);
    let hydrogen = two_tone(Pattern::Clouds(0.04), 0x00d8_d4cc, 0x00ec_e8e0);
    let turn = DMat3::from_rotation_x(1.1) * DMat3::from_rotation_y(0.3);
    for atom in 0..6 {
        let angle = |index: i32| TAU * f64::from(index) / 6.0;
        let at = |index: i32, radius: f64| {
            center + turn * DVec3::new(angle(index).cos(), angle(index).sin(), 0.0) * radius
        };
        stage.add(sphere(0.042), at(atom, 0.13), carbon);
        stage.add_bar((at(atom, 0.13), at(atom + 1, 0.13)), (0.011, 0.011), hydrogen);
        let outer = if atom % 3 == 0 { (oxygen, 0.036) } else { (hydrogen, 0.026) };
        stage.add(sphere(outer.1), at(atom, 0.225), outer.0);
        stage.add_bar((at(atom, 0.13), at(atom, 0.225)), (0.009, 0.009), hydrogen);
    }
}

/// A six-sided prism with a pointed top, its foot at the origin, as quartz grows.
pub(crate) fn crystal(radius: f64, height: f64) -> SolidShape {
    let mut planes = Vec::with_capacity(13);
    for side in 0..6 {
        let angle = PI * f64::from(side) / 3.0;
        let outward = DVec3::new(angle.cos(), angle.sin(), 0.0);
        planes.push(outward.extend(radius));
        let slant = DVec3::new(0.78 * outward.x, 0.78 * outward.y, 0.625_78).normalize_or_zero();
        planes.push(slant.extend(slant.z * height));
    }
    planes.push(DVec4::new(0.0, 0.0, -1.0, 0.0));
    let planes: Arc<[DVec4]> = planes.into();
    SolidShape::Convex { planes, half: DVec3::new(1.16 * radius, 1.16 * radius, height) }
}

/// A cluster around `place` in which one crystal after the other starts to grow.
fn crystals(stage: &mut WorldBuilder, place: DVec3, moment: f64) {
    for index in 0..13_i32 {
        let random = |salt: i32| f64::from(hash(index, salt, 5));
        let start = 0.045 * f64::from(index);
        let grown = ((moment - start) / (0.97 - start)).clamp(0.0, 1.0);
        // Growth slows as the solution thins; a seed is there from the start.
        let size = 0.12 + 0.88 * grown * (2.0 - grown);
        let angle = 2.399_963 * f64::from(index);
        let out = 0.014 * f64::from(index).sqrt();
        let lean = DVec3::new(angle.cos(), angle.sin(), 0.0) * (0.2 * f64::from(index).sqrt());
        let foot = place + DVec3::new(angle.cos(), angle.sin(), 0.0) * out;
        let height = (0.12 - 0.0055 * f64::from(index)) * (0.8 + 0.3 * random(1)) * size;
        let radius = (0.011 + 0.004 * random(2)) * size.sqrt();
        let tint = rgb(0x0058_3c8c).lerp(rgb(0x0088_70c0), random(3) as f32);
        let quartz = Material::new(Pattern::Clouds(0.03), tint, tint.lerp(Vec3::splat(0.85), 0.45));
        stage.add_turned(crystal(radius, height), foot, upright_to(DVec3::Z + lean), quartz);
    }
}

fn ball(stage: &mut WorldBuilder, moment: f64) {
    let beat = (12.0 * moment).fract();
    let height = 0.08 * 4.0 * beat * (1.0 - beat);
    let center = DVec3::new(0.72, -0.16, BENCH_TOP_M + 0.024 + 0.03 + height);
    let rubber = two_tone(Pattern::Stripes(0.024), 0x00c8_4030, 0x00f0_e0c8);
    let spin = DMat3::from_rotation_y(TAU * moment) * DMat3::from_rotation_x(0.5);
    stage.add_turned(sphere(0.03), center, spin, rubber);
}

/// Four cameras before the bench, the last close to the slab.
pub(crate) fn cameras() -> SceneCameras {
    let middle = [0.1, 0.15, 1.05];
    SceneCameras {
        cameras: vec![
            vantage("front", [0.1, -1.75, 1.55], middle, 52.0),
            vantage("left", [-1.25, -1.2, 1.5], middle, 52.0),
            vantage("right", [1.45, -1.15, 1.6], middle, 52.0),
            vantage("crystals", [-0.32, -0.72, 1.38], [0.02, 0.14, 1.0], 50.0),
        ],
        novel: vec![
            vantage("home", [0.7, -1.5, 1.62], middle, 52.0),
            vantage("novel1", [-0.55, -1.5, 1.6], middle, 52.0),
            vantage("novel2", [0.3, -1.0, 1.5], [0.08, 0.15, 1.0], 52.0),
        ],
        target: middle.into(),
        distance: (1.5, 1.9),
        azimuth_deg: (-150.0, -25.0),
        elevation_deg: (10.0, 45.0),
    }
}
