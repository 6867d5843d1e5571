//! The paper's first set-up: a room with nine cameras, one of them close to an object. A toy train circles on the
//! floor and a pendulum swings; everything else rests.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3, Vec3};

use super::props::{
    self, brass, dark_brass, map_canvas, marble, oak, plaster, rgb, turned_wood, two_tone, walnut,
};
use super::{SceneCameras, vantage};
use crate::demo::tracer::{
    Backdrop, Light, Material, Pattern, WorldBuilder, block, cone, cylinder, sphere, torus,
};

const TRACK_CENTER: DVec3 = DVec3::new(0.25, -0.35, 0.0);
const TRACK_RADIUS_M: f64 = 0.8;

/// The scene at a moment of its loop, 0 to 1.
pub(crate) fn stage(moment: f64) -> WorldBuilder {
    let mut stage = WorldBuilder::new(Light {
        to_sun: DVec3::new(0.62, -0.42, 0.78).normalize_or_zero(),
        sun: Vec3::new(0.98, 0.86, 0.66),
        sun_spread: 0.05,
        zenith: Vec3::new(0.30, 0.38, 0.53),
        horizon: Vec3::new(0.56, 0.52, 0.46),
        ground: Vec3::new(0.24, 0.18, 0.13),
        backdrop: Backdrop::EVENING,
        contact: 0.3,
        lamp: None,
    });
    room(&mut stage);
    sofa(&mut stage);
    shelf(&mut stage);
    table(&mut stage);
    pendulum_clock(&mut stage, moment);
    railway(&mut stage, moment);
    stage
}

fn room(stage: &mut WorldBuilder) {
    stage.add(block([3.2, 3.2, 0.1], 0.0), DVec3::new(0.0, 0.0, -0.1), oak());
    stage.add(block([2.6, 0.1, 1.35], 0.0), DVec3::new(0.0, 2.1, 1.35), plaster(0x00a9_b6a6));
    stage.add(block([0.1, 2.2, 1.35], 0.0), DVec3::new(-2.5, 0.0, 1.35), plaster(0x00d4_c4a4));
    stage.add(block([2.5, 0.02, 0.06], 0.006), DVec3::new(0.0, 1.98, 0.06), plaster(0x00e8_e2d6));
    stage.add(block([0.02, 2.1, 0.063], 0.006), DVec3::new(-2.38, 0.0, 0.063), plaster(0x00e8_e2d6));
    props::rug(stage, DVec3::new(0.25, -0.35, 0.0), (1.35, 1.1));
    props::frame(stage, DVec3::new(-0.55, 1.98, 1.7), (0.5, 0.32), map_canvas());
    let planet = two_tone(Pattern::Bands(0.3), 0x00e2_c8a0, 0x0098_5a38);
    props::frame(stage, DVec3::new(0.35, 1.98, 1.78), (0.2, 0.26), planet);
    props::plant(stage, DVec3::new(-2.0, 1.6, 0.0), 26);
}

fn sofa(stage: &mut WorldBuilder) {
    let cloth = two_tone(Pattern::Weave(0.03), 0x0030_5862, 0x004c_7a84);
    let cushion = two_tone(Pattern::Checker(0.09), 0x00d8_a048, 0x00b4_7430);
    let at = |x: f64, y: f64, z: f64| DVec3::new(-0.35 + x, 1.4 + y, z);
    stage.add(block([0.85, 0.4, 0.13], 0.04), at(0.0, 0.0, 0.22), cloth);
    stage.add(block([0.85, 0.12, 0.36], 0.07), at(0.0, 0.34, 0.5), cloth);
    for side in [-1.0, 1.0] {
        stage.add(block([0.11, 0.42, 0.26], 0.07), at(side * 0.88, 0.0, 0.32), cloth);
        stage.add(block([0.36, 0.34, 0.07], 0.05), at(side * 0.38, -0.05, 0.4), cloth);
        let lean = DMat3::from_rotation_x(-0.35) * DMat3::from_rotation_y(side * 0.12);
        stage.add_turned(block([0.19, 0.06, 0.19], 0.05), at(side * 0.52, 0.12, 0.62), lean, cushion);
        for depth in [-0.34, 0.34] {
            stage.add(cylinder(0.025, 0.05), at(side * 0.8, depth, 0.05), turned_wood());
        }
    }
}

fn shelf(stage: &mut WorldBuilder) {
    let place = DVec3::new(1.45, 1.78, 0.0);
    props::shelf(stage, place, DVec3::new(0.6, 0.17, 0.85), 4);
    let covers = [0x0070_2f2a, 0x002d_4a5c, 0x00a8_8c50, 0x0038_5038, 0x004c_3a5e, 0x008a_4a30, 0x0028_3440];
    let board = |index: f64, x: f64| place + DVec3::new(x, -0.05, 0.072 + 0.40625 * index);
    props::book_row(stage, board(1.0, -0.54), &[covers, covers].concat());
    props::book_row(stage, board(2.0, -0.54), &covers);
    props::book_row(stage, board(2.0, 0.2), &covers[2..]);
    props::book_row(stage, board(3.0, 0.0), &[&covers[3..], &covers[..5]].concat());
    stage.add(sphere(0.1), board(3.0, -0.3) + DVec3::Z * 0.1, marble());
    props::globe(stage, board(4.0, -0.3), 0.13);
    let vase = two_tone(Pattern::Stripes(0.06), 0x0030_5a78, 0x00d8_d0bc);
    stage.add(cone(0.05, 0.1, 0.07), board(4.0, 0.25) + DVec3::Z * 0.07, vase);
    stage.add(cone(0.1, 0.035, 0.06), board(4.0, 0.25) + DVec3::Z * 0.2, vase);
    stage.add(block([0.2, 0.12, 0.1], 0.02), board(0.0, -0.3) + DVec3::Z * 0.1, turned_wood());
    props::books(stage, board(0.0, 0.2) - DVec3::Y * 0.02, &[(0x0070_2f2a, 1.4), (0x002d_4a5c, 1.7)]);
}

fn table(stage: &mut WorldBuilder) {
    let place = DVec3::new(0.25, -0.35, 0.0);
    stage.add(cylinder(0.42, 0.018), place + DVec3::Z * 0.44, walnut());
    stage.add(torus(0.42, 0.018), place + DVec3::Z * 0.44, dark_brass());
    for leg in 0..3 {
        let angle = TAU * (f64::from(leg) + 0.25) / 3.0;
        let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let ends = (place + out * 0.36, place + out * 0.16 + DVec3::Z * 0.43);
        stage.add_bar(ends, (0.018, 0.028), turned_wood());
    }
    let top = place + DVec3::Z * 0.458;
    props::books(stage, top + DVec3::new(-0.16, 0.1, 0.0), &[(0x00a8_8c50, 0.6), (0x0038_5038, 0.25)]);
    let clay = two_tone(Pattern::Stripes(0.045), 0x00e0_d4c0, 0x0034_5a70);
    let pot = top + DVec3::new(0.15, -0.05, 0.0);
    stage.add(sphere(0.085), pot + DVec3::Z * 0.08, clay);
    let (handle, upright) = (pot + DVec3::new(0.095, 0.0, 0.085), DMat3::from_rotation_x(0.25 * TAU));
    stage.add_turned(torus(0.05, 0.011), handle, upright, clay);
    let spout = (pot + DVec3::new(-0.07, 0.0, 0.07), pot + DVec3::new(-0.15, 0.0, 0.13));
    stage.add_bar(spout, (0.02, 0.011), clay);
    stage.add(sphere(0.016), pot + DVec3::Z * 0.175, brass());
}

fn pendulum_clock(stage: &mut WorldBuilder, moment: f64) {
    let place = DVec3::new(-2.26, -0.15, 0.0);
    stage.add(block([0.13, 0.22, 0.1], 0.01), place + DVec3::Z * 0.1, walnut());
    stage.add(block([0.03, 0.18, 0.75], 0.005), place + DVec3::new(-0.09, 0.0, 0.9), turned_wood());
    for side in [-1.0, 1.0] {
        stage.add(block([0.12, 0.02, 0.75], 0.005), place + DVec3::new(0.0, side * 0.19, 0.9), walnut());
    }
    stage.add(block([0.13, 0.23, 0.21], 0.02), place + DVec3::Z * 1.75, walnut());
    let face = two_tone(Pattern::Grooves(0.07), 0x00ec_e4d0, 0x00d0_c2a0);
    let upright = DMat3::from_rotation_y(0.25 * TAU);
    let dial = place + DVec3::new(0.135, 0.0, 1.75);
    stage.add_turned(cylinder(0.16, 0.008), dial, upright, face);
    stage.add_turned(torus(0.165, 0.014), dial, upright, brass());
    let black = Material::plain(rgb(0x0024_2220));
    for (turns, length) in [(0.14, 0.13), (0.83, 0.09)] {
        let (sin, cos) = (TAU * f64::from(turns as f32)).sin_cos();
        let hub = dial + DVec3::X * 0.015;
        stage.add_bar((hub, hub + DVec3::new(0.0, sin, cos) * length), (0.006, 0.004), black);
    }
    let swing = 0.17 * (TAU * 3.0 * moment).sin();
    let pivot = place + DVec3::new(0.02, 0.0, 1.52);
    let bob = pivot + DVec3::new(0.0, swing.sin(), -swing.cos()) * 0.85;
    stage.add_bar((pivot, bob), (0.006, 0.006), brass());
    stage.add_turned(cylinder(0.075, 0.012), bob, upright, brass());
}

fn railway(stage: &mut WorldBuilder, moment: f64) {
    let rail = Material::plain(rgb(0x0078_7c84));
    for side in [-0.04, 0.04] {
        let place = TRACK_CENTER + DVec3::Z * 0.034;
        stage.add(torus(TRACK_RADIUS_M + side, 0.007), place, rail);
    }
    for sleeper in 0..48 {
        let rotation = DMat3::from_rotation_z(TAU * f64::from(sleeper) / 48.0);
        let place = TRACK_CENTER + rotation * DVec3::X * TRACK_RADIUS_M + DVec3::Z * 0.022;
        stage.add_turned(block([0.075, 0.017, 0.007], 0.0), place, rotation, turned_wood());
    }
    let colors = [0x00b0_302c, 0x002c_5c9c, 0x00d8_a430, 0x003c_7c48];
    for (index, color) in colors.into_iter().enumerate() {
        let angle = TAU * (moment - 0.052 * index as f64);
        carriage(stage, angle, index == 0, color);
    }
}

/// A carriage of the train at an angle on the track; the first is the engine.
fn carriage(stage: &mut WorldBuilder, angle: f64, is_engine: bool, color: u32) {
    let rotation = DMat3::from_rotation_z(angle);
    let to_world = |x: f64, y: f64, z: f64| {
        TRACK_CENTER + rotation * (DVec3::X * TRACK_RADIUS_M + DVec3::new(x, y, z + 0.04))
    };
    let paint = Material::new(Pattern::Clouds(0.08), rgb(color), rgb(color) * 1.25);
    let black = Material::plain(rgb(0x002a_2a2c));
    stage.add_turned(block([0.05, 0.105, 0.016], 0.004), to_world(0.0, 0.0, 0.045), rotation, black);
    if is_engine {
        let ends = (to_world(0.0, -0.05, 0.105), to_world(0.0, 0.1, 0.105));
        stage.add_bar(ends, (0.044, 0.044), paint);
        stage.add_turned(block([0.05, 0.04, 0.06], 0.006), to_world(0.0, -0.065, 0.12), rotation, paint);
        stage.add_turned(block([0.06, 0.05, 0.008], 0.004), to_world(0.0, -0.065, 0.185), rotation, black);
        stage.add(cone(0.012, 0.024, 0.03), to_world(0.0, 0.07, 0.17), black);
        stage.add(sphere(0.02), to_world(0.0, 0.01, 0.15), brass());
    } else {
        stage.add_turned(block([0.05, 0.095, 0.045], 0.01), to_world(0.0, 0.0, 0.1), rotation, paint);
        let cargo = two_tone(Pattern::Speckles(0.03), 0x0050_4038, 0x00a0_8460);
        stage.add_turned(block([0.04, 0.085, 0.03], 0.02), to_world(0.0, 0.0, 0.135), rotation, cargo);
    }
    for (x, y) in [(-0.05, -0.06), (0.05, -0.06), (-0.05, 0.06), (0.05, 0.06)] {
        let upright = rotation * DMat3::from_rotation_y(0.25 * TAU);
        stage.add_turned(cylinder(0.026, 0.008), to_world(x, y, 0.026), upright, brass());
    }
}

/// Nine cameras on the two open sides, the last close to the table.
pub(crate) fn cameras() -> SceneCameras {
    let middle = [-0.05, 0.35, 0.6];
    SceneCameras {
        cameras: vec![
            vantage("front", [0.2, -3.0, 1.55], middle, 58.0),
            vantage("front left", [-1.2, -2.7, 1.3], middle, 58.0),
            vantage("front right", [1.6, -2.6, 1.4], middle, 58.0),
            vantage("right", [2.6, -1.3, 1.6], middle, 58.0),
            vantage("far right", [2.6, 0.3, 1.4], [-0.4, 0.3, 0.6], 58.0),
            vantage("left", [-2.0, -1.9, 1.9], [0.35, 0.5, 0.55], 58.0),
            vantage("high", [0.4, -1.9, 2.7], [0.0, 0.3, 0.3], 58.0),
            vantage("shelf", [0.55, 0.35, 1.25], [1.4, 1.75, 0.95], 58.0),
            vantage("tea table", [0.85, -1.05, 0.88], [0.22, -0.3, 0.48], 46.0),
        ],
        novel: vec![
            vantage("home", [0.95, -2.5, 1.75], middle, 58.0),
            vantage("novel1", [-0.5, -2.45, 1.6], middle, 58.0),
            vantage("novel2", [1.9, -1.3, 1.2], [0.2, 0.3, 0.5], 58.0),
        ],
        target: middle.into(),
        distance: (2.4, 3.1),
        azimuth_deg: (-125.0, 5.0),
        elevation_deg: (10.0, 45.0),
    }
}
