//! Preprocesses a static scene that a moving camera recorded, and tells what that took: how time and memory grow with the number of
//! views. The camera walks along a wall, so that each view overlaps with a bounded number of others however many there are, or around
//! a table, so that all overlap. Pictures are computed on demand. Or a recording of one place is repeated as if there were many such
//! places beside each other, each of its poses off by a little more.
//!
//! ```sh
//! cargo run --release --example many_views -- walk 1000 640x480
//! cargo run --release --example many_views -- path/to/recording 1000
//! cargo run --release --example many_views -- around 64 320x240 noisy --set capture.memory=64
//! ```

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::{DAffine3, DQuat, DVec2, DVec3};
use half::f16;
use overlook_engine::capture::{Camera, Capture, CaptureParts, Frame, FrameSource, Intrinsics, Values, open};
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess_buffered;
use overlook_engine::samples::SampleImage;
use overlook_engine::settings::Settings;

/// How far the camera walks from view to view, m.
const STEP_M: f64 = 0.25;
/// Distance of the wall, m.
const WALL_M: f64 = 3.0;
/// Relative standard deviation of depth where it is noisy.
const NOISE: f64 = 0.01;

/// A wall with columns before it on a floor, or a table of spheres.
struct Walk {
    cameras: Vec<Camera>,
    is_noisy: bool,
}

/// Sixteen pseudo-random bits of three numbers.
fn mixed(a: u64, b: u64, c: u64) -> f64 {
    let mut z = a.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ b.wrapping_mul(0xbf58_476d_1ce4_e5b9) ^ c;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 48) as f64 / 65536.0
}

/// The factor by which a ray has to be as long to meet a sphere.
fn meets_sphere(eye: DVec3, ray: DVec3, center: DVec3, radius: f64) -> Option<f64> {
    let (a, b) = (ray.length_squared(), ray.dot(eye - center));
    let root = b * b - a * ((eye - center).length_squared() - radius * radius);
    let nearest = (-b - root.max(0.0).sqrt()) / a;
    (root > 0.0 && nearest > 1e-6).then_some(nearest)
}

impl Walk {
    fn new(around: bool, views: usize, size: (u32, u32), is_noisy: bool) -> Self {
        let lens = Intrinsics::from_horizontal_angle(size.0, size.1, 1.0);
        let camera = |index: usize| {
            let at = index as f64;
            let name = format!("view{index}");
            if around {
                // Spread over a part of a sphere by the golden angle.
                let (turn, up) = (at * 2.399_963, 0.3 + 0.9 * (at + 0.5) / views as f64);
                let eye = DVec3::new(up.cos() * turn.cos(), up.cos() * turn.sin(), up.sin()) * 2.5;
                return Camera::look_at(name, lens, eye, DVec3::Z * 0.3, DVec3::Z);
            }
            let eye = DVec3::new(STEP_M * at, 0.2 * (0.7 * at).sin(), 1.5 + 0.1 * (1.3 * at).cos());
            let target = DVec3::new(eye.x + 0.4 * (0.5 * at).sin(), WALL_M, 1.2);
            Camera::look_at(name, lens, eye, target, DVec3::Z)
        };
        Self { cameras: (0..views).map(camera).collect(), is_noisy }
    }

    /// Nearest hit: how many times as long as the ray, and what stands there.
    fn hit(eye: DVec3, ray: DVec3) -> (f64, u64) {
        let mut nearest = (f64::INFINITY, 0);
        let mut offer = |length: f64, what: u64| {
            if length > 1e-6 && length < nearest.0 {
                nearest = (length, what);
            }
        };
        offer((WALL_M - eye.y) / ray.y, 1);
        offer((-WALL_M - eye.y) / ray.y, 1);
        offer(-eye.z / ray.z, 2);
        offer((3.0 - eye.z) / ray.z, 3);
        // Spheres before the wall, one a meter: those that the ray passes.
        let through = eye.x + ray.x * (WALL_M - 0.5 - eye.y) / ray.y;
        for nth in [through.floor() - 1.0, through.floor(), through.floor() + 1.0] {
            let place = DVec3::new(nth + 0.5, WALL_M - 0.5, 1.0 + mixed(nth as i64 as u64, 1, 2));
            if let Some(length) = meets_sphere(eye, ray, place, 0.3) {
                offer(length, 4);
            }
        }
        nearest
    }

    fn color(point: DVec3, what: u64) -> [f16; 3] {
        let cell = (point * 20.0).floor();
        let cell = mixed(cell.x as i64 as u64, cell.y as i64 as u64, cell.z as i64 as u64 ^ what << 40);
        let wave = |a: f64, b: f64, c: f64| 0.3 + 0.15 * (a * point.x + b * point.y + c * point.z).sin();
        [wave(1.3, 0.4, 2.0), wave(0.5, 1.7, 3.1), wave(0.8, 0.9, 1.2)]
            .map(|level| f16::from_f64(level + 0.1 * cell))
    }
}

impl FrameSource for Walk {
    fn load(&self, camera: usize, _frame: usize) -> overlook_engine::error::Result<Frame> {
        let view = &self.cameras[camera];
        let (width, height) = view.intrinsics.size();
        let eye = view.position_in_world();
        let (mut color, mut inverse_depth) =
            (Grid::filled(width, height, [f16::ZERO; 3]), Grid::filled(width, height, 0.0));
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let in_camera = view.intrinsics.ray_in_camera(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            let ray = view.world_from_camera.matrix3 * in_camera;
            let (length, what) = Self::hit(eye, ray);
            color[(x, y)] = Self::color(eye + ray * length, what);
            let draws = || (0..4).map(|nth| mixed(camera as u64, (y * width + x) as u64, nth) - 0.5);
            let noise = if self.is_noisy { NOISE * 3.0_f64.sqrt() * draws().sum::<f64>() } else { 0.0 };
            inverse_depth[(x, y)] = (1.0 / (length * (1.0 + noise))) as f32;
        }
        Ok(Frame {
            color,
            inverse_depth,
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: Values::default(),
        })
    }

    fn place(&self, camera: usize, _frame: usize) -> String {
        format!("view {camera}")
    }
}

/// The pictures of a recording, again and again.
struct Repeated(Capture);

impl FrameSource for Repeated {
    fn load(&self, camera: usize, _frame: usize) -> overlook_engine::error::Result<Frame> {
        Ok(Frame::clone(&*self.0.frame(camera % self.0.cameras.len(), 0)?))
    }

    fn place(&self, camera: usize, _frame: usize) -> String {
        format!("view {camera}")
    }
}

/// How far repetitions of a recording lie apart: nothing of one is seen from another.
const PLACE_APART: f64 = 1000.0;
/// By how much poses of a repetition are off at most: radians, and the capture's unit.
const JITTER: (f64, f64) = (1e-3, 2e-3);

/// So many views of a recording that is repeated.
fn repeated(folder: &Path, views: usize) -> Result<CaptureParts, Box<dyn Error>> {
    let recording = open(folder, &Settings::default().capture)?;
    let camera = |index: usize| {
        let (nth, again) = (index % recording.cameras.len(), index / recording.cameras.len());
        let draw = |nth: u64| 2.0 * mixed(index as u64, nth, 7) - 1.0;
        let turn = DVec3::new(draw(0), draw(1), draw(2)) * JITTER.0;
        let shift = DVec3::new(draw(3), draw(4), draw(5)) * JITTER.1;
        let jitter = DAffine3::from_rotation_translation(DQuat::from_scaled_axis(turn), shift);
        let mut camera = recording.cameras[nth].clone();
        if again > 0 {
            camera.world_from_camera = DAffine3::from_translation(DVec3::X * PLACE_APART * again as f64)
                * camera.world_from_camera
                * jitter;
        }
        camera.name = format!("{} ({again})", camera.name);
        camera
    };
    Ok(CaptureParts {
        cameras: (0..views).map(camera).collect(),
        frame_numbers: vec![0],
        source: Arc::new(Repeated(recording.clone())),
        ..(*recording).clone()
    })
}

/// Memory in use, MiB.
fn used_mib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let used = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap_or("");
    used.split_whitespace().next().and_then(|text| text.parse::<u64>().ok()).unwrap_or(0) >> 10
}

/// The most memory that each stage of the work uses, by looking again and again until the work is done.
fn watch(job: &Job, is_done: &AtomicBool) -> Vec<(String, u64)> {
    let mut stages: Vec<(String, u64)> = Vec::new();
    while !is_done.load(Ordering::Relaxed) {
        let (stage, used) = (job.progress().stage, used_mib());
        match stages.last_mut().filter(|(last, _)| *last == stage) {
            Some((_, most)) => *most = used.max(*most),
            None => stages.push((stage, used)),
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    stages
}

/// A number that tells kept samples from others.
fn hash(of: u64, image: &SampleImage) -> u64 {
    let mixed = |hash: u64, next: u64| (hash ^ next).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(23);
    let color = image.color.iter().flatten().map(|channel| u64::from(channel.to_bits()));
    let places = image.tiles.iter().flat_map(|tile| tile.rows).map(u64::from);
    let depth = image.depth.low().iter().map(|low| u64::from(*low));
    let doubtful = image.doubtful.iter().flat_map(|tile| tile.rows).map(u64::from);
    places.chain(color).chain(depth).chain(doubtful).fold(mixed(of, u64::from(image.camera)), mixed)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let usage = "give walk or around, the number of views, and WIDTHxHEIGHT, or a recording and the number of views; then noisy, and --set KEY=VALUE";
    let [path, views, rest @ ..] = arguments.as_slice() else { return Err(usage.into()) };
    let views: usize = views.parse()?;
    let mut settings = Settings::default();
    for assignment in rest.iter().filter(|word| word.contains('=')) {
        settings.set_text(assignment)?;
    }
    let parts = if Path::new(path).exists() {
        repeated(Path::new(path), views)?
    } else {
        let (width, height) = rest.first().and_then(|size| size.split_once('x')).ok_or(usage)?;
        let is_noisy = rest.iter().any(|word| word == "noisy");
        let source = Walk::new(path == "around", views, (width.parse()?, height.parse()?), is_noisy);
        CaptureParts {
            name: "walk".to_owned(),
            cameras: source.cameras.clone(),
            frame_numbers: vec![0],
            up_in_world: DVec3::Z,
            has_normals: false,
            antialiased_color: false,
            warnings: Vec::new(),
            source: Arc::new(source),
        }
    };
    let capture = Capture::new(parts, 16 << 20);
    let (job, is_done) = (Job::new(), AtomicBool::new(false));
    let started = Instant::now();
    let (result, stages) = std::thread::scope(|threads| {
        let watcher = std::thread::Builder::new()
            .name("memory".to_owned())
            .spawn_scoped(threads, || watch(&job, &is_done));
        let result = preprocess_buffered(&capture, &settings, &job);
        is_done.store(true, Ordering::Relaxed);
        (result, watcher.ok().and_then(|watcher| watcher.join().ok()).unwrap_or_default())
    });
    let result = result?;
    let seconds = started.elapsed().as_secs_f64();
    let images = &result.images;
    let hash = (0..images.len())
        .try_fold(0, |of, index| Ok::<_, overlook_engine::error::Error>(hash(of, &*images.get(index)?)))?;
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("").trim();
    let report = &result.report;
    println!(
        "{views} views: {seconds:.2} s, {:.1} ms a view, {:.0} ns a pixel; peak {peak}; {} of {} samples kept, {} doubtful, noisy: {}, {hash:016x}",
        1e3 * seconds / views as f64,
        1e9 * seconds / report.samples_in as f64,
        report.samples_kept,
        report.samples_in,
        report.samples_doubtful,
        report.is_noisy(),
    );
    for (stage, mib) in stages.iter().filter(|(stage, _)| !stage.is_empty()) {
        println!("  {stage}: {mib} MiB");
    }
    Ok(())
}
