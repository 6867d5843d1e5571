//! The default scene: a brass orrery on a table, among things with fine texture.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DVec3, Vec3};

use super::props::{
    self, brass, brick, dark_brass, map_canvas, marble, plaster, slate, turned_wood, two_tone, walnut,
};
use super::{SceneCameras, vantage};
use crate::demo::tracer::{
    Backdrop, Lamp, Light, Material, Pattern, SolidShape, WorldBuilder, block, cone, cylinder, sphere, torus,
};

const TABLE_TOP_M: f64 = 0.76;
const SUN: DVec3 = DVec3::new(0.0, 0.0, TABLE_TOP_M + 0.42);

/// A planet: radius and distance from the sun in meters, revolutions per loop, where it starts (turns).
struct Planet {
    radius: f64,
    orbit: f64,
    revolutions: f64,
    start: f64,
    material: Material,
}

fn planets() -> [Planet; 5] {
    let planet =
        |radius, orbit, revolutions, start, material| Planet { radius, orbit, revolutions, start, material };
    [
        planet(0.022, 0.15, 3.0, 0.1, two_tone(Pattern::Moon(0.022), 0x00a8_9a8c, 0x006a_5d52)),
        planet(0.036, 0.235, 2.0, 0.52, two_tone(Pattern::Clouds(0.03), 0x00e8_c48a, 0x00b8_7c48)),
        planet(0.042, 0.335, 1.0, 0.86, two_tone(Pattern::Continents(0.042), 0x0024_5a9c, 0x004a_7a3a)),
        planet(0.082, 0.485, 1.0, 0.33, two_tone(Pattern::Bands(0.082), 0x00e2_c8a0, 0x0098_5a38)),
        planet(0.062, 0.665, 1.0, 0.64, two_tone(Pattern::Bands(0.062), 0x00ea_d8a4, 0x00c0_a064)),
    ]
}

/// The scene at a moment of its loop, 0 to 1.
pub(crate) fn stage(moment: f64) -> WorldBuilder {
    let mut stage = WorldBuilder::new(Light {
        to_sun: DVec3::new(0.42, -0.55, 0.83).normalize_or_zero(),
        sun: Vec3::new(0.98, 0.88, 0.7),
        sun_spread: 0.045,
        zenith: Vec3::new(0.27, 0.36, 0.52),
        horizon: Vec3::new(0.52, 0.49, 0.44),
        ground: Vec3::new(0.20, 0.15, 0.11),
        backdrop: Backdrop::EVENING,
        contact: 0.22,
        lamp: Some(Lamp { position: SUN, color: Vec3::new(2.0, 1.25, 0.5), reach: 0.95 }),
    });
    set(&mut stage);
    furniture(&mut stage);
    instrument(&mut stage, moment);
    stage
}

fn set(stage: &mut WorldBuilder) {
    let floor = two_tone(Pattern::Tiles(0.4), 0x00c8_bca6, 0x0086_7c70);
    stage.add(block([4.0, 4.0, 0.1], 0.0), DVec3::new(0.0, 0.0, -0.1), floor);
    let wall = block([2.3, 0.1, 1.3], 0.0);
    stage.add(wall, DVec3::new(0.1, 1.9, 1.3), plaster(0x0086_988c));
    let side = block([0.1, 2.0, 1.3], 0.0);
    stage.add(side, DVec3::new(-2.3, 0.0, 1.3), brick());
    let skirting = block([2.2, 0.02, 0.07], 0.008);
    stage.add(skirting, DVec3::new(0.0, 1.79, 0.07), walnut());
    props::arch(stage, DVec3::new(0.55, 1.72, 0.0), 0.52, 1.15);
    props::rug(stage, DVec3::new(0.0, -0.1, 0.0), (1.75, 1.3));
    props::plinth(stage, DVec3::new(-1.55, 1.2, 0.0), 0.85);
    stage.add(sphere(0.2), DVec3::new(-1.55, 1.2, 1.09), marble());
    props::frame(stage, DVec3::new(-0.75, 1.79, 1.65), (0.34, 0.26), map_canvas());
}

fn furniture(stage: &mut WorldBuilder) {
    let top = block([1.2, 0.82, 0.03], 0.015);
    stage.add(top, DVec3::new(0.0, 0.0, TABLE_TOP_M - 0.03), walnut());
    let apron = block([1.08, 0.7, 0.05], 0.0);
    stage.add(apron, DVec3::new(0.0, 0.0, TABLE_TOP_M - 0.11), turned_wood());
    for (x, y) in [(-1.0, -0.62), (1.0, -0.62), (-1.0, 0.62), (1.0, 0.62)] {
        let foot = DVec3::new(x, y, 0.0);
        stage.add_bar((foot, foot + DVec3::Z * 0.7), (0.03, 0.05), turned_wood());
        stage.add(torus(0.045, 0.014), foot + DVec3::Z * 0.58, turned_wood());
    }
    let corner = DVec3::new(-0.92, 0.5, TABLE_TOP_M);
    let covers = [(0x0070_2f2a, 0.4), (0x002d_4a5c, -0.15), (0x00a8_8c50, 0.2), (0x0038_5038, -0.3)];
    props::books(stage, corner, &covers);
    props::globe(stage, DVec3::new(0.94, 0.5, TABLE_TOP_M), 0.15);
    props::hourglass(stage, DVec3::new(-0.96, -0.45, TABLE_TOP_M));
    props::books(stage, DVec3::new(0.93, -0.5, TABLE_TOP_M), &[(0x004c_3a5e, 0.9)]);
    stage.add(sphere(0.045), DVec3::new(0.93, -0.48, TABLE_TOP_M + 0.095), slate());
}

fn instrument(stage: &mut WorldBuilder, moment: f64) {
    let at = |z: f64| DVec3::new(0.0, 0.0, TABLE_TOP_M + z);
    stage.add(cylinder(0.19, 0.02), at(0.02), turned_wood());
    stage.add(torus(0.165, 0.018), at(0.045), brass());
    stage.add(cone(0.14, 0.05, 0.03), at(0.07), turned_wood());
    stage.add(cylinder(0.016, 0.16), at(0.24), brass());
    stage.add(sphere(0.03), at(0.12), brass());
    let mut sun = two_tone(Pattern::Clouds(0.05), 0x00ff_b030, 0x00ff_e08a);
    sun.glow = 0.55;
    stage.add(sphere(0.075), SUN, sun);
    for (index, planet) in planets().iter().enumerate() {
        arm(stage, planet, 0.345 - 0.042 * index as f64, moment);
    }
    gear(stage, at(0.155), 0.1, 20, moment);
    gear(stage, at(0.155) + DVec3::new(0.132, 0.02, 0.0), 0.034, 7, -3.0 * moment);
    stage.add(cylinder(0.007, 0.06), at(0.115) + DVec3::new(0.132, 0.02, 0.0), dark_brass());
    zodiac_ring(stage);
}

/// A planet on its arm, which leaves the column `height` meters above the table.
fn arm(stage: &mut WorldBuilder, planet: &Planet, height: f64, moment: f64) {
    let turn = TAU * (planet.start + planet.revolutions * moment);
    let outward = DVec3::new(turn.cos(), turn.sin(), 0.0);
    let root = DVec3::new(0.0, 0.0, TABLE_TOP_M + height);
    stage.add(cylinder(0.028, 0.012), root, brass());
    outer_arm(stage, planet, root, outward, moment);
}

/// What of an arm turns about its `root`, toward `outward`.
fn outer_arm(stage: &mut WorldBuilder, planet: &Planet, root: DVec3, outward: DVec3, moment: f64) {
    let elbow = root + outward * planet.orbit;
    let center = DVec3::new(elbow.x, elbow.y, SUN.z);
    stage.add_bar((root - outward * 0.09, elbow), (0.007, 0.006), brass());
    stage.add(sphere(0.02), root - outward * 0.1, dark_brass());
    stage.add(sphere(0.011), elbow, dark_brass());
    stage.add_bar((elbow, center), (0.004, 0.004), brass());
    let spin = DMat3::from_rotation_x(0.35) * DMat3::from_rotation_z(TAU * (2.0 * moment + planet.start));
    stage.add_turned(sphere(planet.radius), center, spin, planet.material);
    if planet.radius == 0.062 {
        let tilt = DMat3::from_rotation_x(0.42);
        let ring = two_tone(Pattern::Grooves(0.018), 0x00d8_c296, 0x0090_7850);
        let shape = SolidShape::Ring { inner: 0.082, outer: 0.138, half_height: 0.002 };
        stage.add_turned(shape, center, tilt, ring);
    }
    if planet.radius == 0.042 {
        let (sin, cos) = (TAU * 4.0 * moment).sin_cos();
        let moon = center + DVec3::new(0.085 * cos, 0.085 * sin, 0.02);
        stage.add_bar((center - DVec3::Z * 0.05, moon), (0.0025, 0.0025), brass());
        let gray = two_tone(Pattern::Moon(0.014), 0x00c4_c0b8, 0x007c_7872);
        stage.add(sphere(0.014), moon, gray);
    }
}

/// A gear of the given radius whose teeth are blocks.
fn gear(stage: &mut WorldBuilder, center: DVec3, radius: f64, teeth: usize, turns: f64) {
    stage.add(cylinder(radius - 0.006, 0.006), center, brass());
    for tooth in 0..teeth {
        let angle = TAU * (tooth as f64 / teeth as f64 + turns);
        let rotation = DMat3::from_rotation_z(angle);
        let block = block([0.008, 0.3 * PI * radius / teeth as f64, 0.0055], 0.0);
        let place = center + rotation * DVec3::X * radius;
        stage.add_turned(block, place, rotation, dark_brass());
    }
}

/// The graduated ring around the instrument, on four feet.
fn zodiac_ring(stage: &mut WorldBuilder) {
    let ring = two_tone(Pattern::Checker(0.045), 0x00e4_d6b4, 0x0030_3c54);
    let center = DVec3::new(0.0, 0.0, TABLE_TOP_M + 0.05);
    stage.add(SolidShape::Ring { inner: 0.705, outer: 0.765, half_height: 0.006 }, center, ring);
    stage.add(torus(0.77, 0.009), center, brass());
    stage.add(torus(0.7, 0.009), center, brass());
    for foot in 0..8 {
        let angle = TAU * (f64::from(foot) + 0.5) / 8.0;
        let place = DVec3::new(0.735 * angle.cos(), 0.735 * angle.sin(), TABLE_TOP_M + 0.022);
        stage.add(cone(0.02, 0.01, 0.022), place, dark_brass());
    }
}

/// Five cameras around the open sides, the last close to the globe.
pub(crate) fn cameras() -> SceneCameras {
    let middle = [0.0, 0.1, 0.98];
    SceneCameras {
        cameras: vec![
            vantage("front", [0.15, -2.35, 1.62], middle, 52.0),
            vantage("left", [-1.55, -1.75, 1.42], middle, 52.0),
            vantage("right", [1.95, -1.5, 1.5], middle, 52.0),
            vantage("high", [0.75, -1.35, 2.55], [0.0, 0.1, 0.85], 52.0),
            vantage("globe", [1.32, -0.32, 1.2], [0.82, 0.55, 0.98], 48.0),
        ],
        novel: vec![
            vantage("home", [0.85, -2.0, 1.68], middle, 52.0),
            vantage("novel1", [-0.75, -2.0, 1.75], middle, 52.0),
            vantage("novel2", [1.3, -1.05, 1.6], [0.3, 0.3, 0.95], 52.0),
        ],
        target: middle.into(),
        distance: (1.9, 2.5),
        azimuth_deg: (-150.0, 10.0),
        elevation_deg: (8.0, 55.0),
    }
}
