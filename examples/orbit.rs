//! Renders a store from places between its cameras, one after another as a window does while it is dragged, and tells what a picture
//! takes: median, and ninth of ten.
//!
//! ```sh
//! cargo run --release --example orbit -- scene.ovl 640x480 40 --set render.antialias=off
//! ```

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use overlook_engine::capture::Camera;
use overlook_engine::job::Job;
use overlook_engine::render::{Renderer, Vantage};
use overlook_engine::settings::{Backend, Settings};
use overlook_engine::store;

/// The `nth` of `count` vantages, on the way from each camera to the next with the size of picture that is asked for.
fn vantage(cameras: &[Camera], nth: usize, count: usize, size: (u32, u32)) -> Vantage {
    let at = nth as f64 / count as f64 * (cameras.len() - 1) as f64;
    let (from, to) = (&cameras[at as usize], &cameras[(at as usize + 1).min(cameras.len() - 1)]);
    let share = at.fract();
    let (position, next) = (from.position_in_world(), to.position_in_world());
    let [a, b] = [from, to].map(|camera| glam::DQuat::from_mat3(&camera.world_from_camera.matrix3));
    let mut camera = from.clone();
    camera.world_from_camera =
        glam::DAffine3::from_rotation_translation(a.slerp(b, share), position.lerp(next, share));
    let lens = &mut camera.intrinsics;
    let (across, down) =
        (f64::from(size.0) / f64::from(lens.width), f64::from(size.1) / f64::from(lens.height));
    (lens.fx, lens.cx, lens.fy, lens.cy) =
        (lens.fx * across, lens.cx * across, lens.fy * across, lens.cy * down);
    (lens.width, lens.height) = size;
    Vantage { camera, frame: 0 }
}

fn main() -> Result<(), Box<dyn Error>> {
    let usage = "orbit STORE WIDTHxHEIGHT PICTURES [--set KEY=VALUE …]";
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [path, size, count, rest @ ..] = args.as_slice() else { return Err(usage.into()) };
    let (width, height) = size.split_once('x').ok_or(usage)?;
    let (size, count) = ((width.parse()?, height.parse()?), count.parse::<usize>()?);
    let mut settings = Settings::default();
    settings.render.backend = Backend::Cpu;
    for pair in rest.iter().filter(|word| *word != "--set") {
        settings.set_text(pair)?;
    }
    let job = Job::new();
    let (samples, _) = store::read(Path::new(path), &job)?;
    let samples = Arc::new(samples);
    let mut renderer = Renderer::new();
    let mut times = Vec::new();
    for nth in 0..count {
        let vantage = vantage(&samples.cameras, nth, count, size);
        let started = Instant::now();
        renderer.render(&samples, &vantage, &settings.render, &job)?;
        times.push(started.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    println!("median {:.1} ms, ninth of ten {:.1} ms", times[count / 2], times[count * 9 / 10]);
    Ok(())
}
