//! What is told when something is opened: noise is called noise and is no reason to warn, and settings that were kept are named.

use std::path::Path;
use std::sync::Arc;

use egui_kittest::kittest::{NodeT, Queryable};
use glam::DVec3;
use overlook::app::Start;
use overlook_engine::capture::transforms::write_capture;
use overlook_engine::capture::{Capture, CaptureParts, Frame, FrameSource};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::settings::CaptureSettings;

use super::driver::{
    SIZE, Window, click, demo, drop_on, open, open_view, pick, settle, shows, small_demo, told, wait,
};

/// Standard deviation of the depth of a noisy sensor, relative.
const NOISE: f32 = 0.02;

/// The orrery as cameras with noisy depth record it.
struct NoisyOrrery(Demo, Capture);

impl FrameSource for NoisyOrrery {
    fn load(&self, camera: usize, frame: usize) -> Result<Frame> {
        let mut recorded = self.0.render(&self.1.cameras[camera], frame);
        let mut draw = 977 * camera as u32 + 31 * frame as u32 + 1;
        for inverse_depth in recorded.inverse_depth.as_mut_slice() {
            // Twelve uniform draws add up to nearly a normal one.
            let mut sum = -6.0;
            for _ in 0..12 {
                draw = draw.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum += (draw >> 8) as f32 / (1 << 24) as f32;
            }
            *inverse_depth *= 1.0 + NOISE * sum;
        }
        recorded.normal_in_world = None;
        Ok(recorded)
    }

    fn place(&self, camera: usize, frame: usize) -> String {
        format!("noisy orrery, camera {camera}, frame {frame}")
    }
}

/// Writes the noisy orrery into a folder.
fn write_noisy(folder: &Path) {
    let spec = DemoSpec::new("orrery").frames(1).size((160, 120));
    let demo = Demo::new(&spec).unwrap();
    let exact = demo.capture(&CaptureSettings::default());
    let cameras = exact.cameras.clone();
    let parts = CaptureParts {
        name: "noisy".to_owned(),
        frame_numbers: vec![0],
        up_in_world: DVec3::Z,
        has_normals: false,
        antialiased_color: false,
        warnings: Vec::new(),
        source: Arc::new(NoisyOrrery(demo, exact)),
        cameras,
    };
    write_capture(folder, &Capture::new(parts, 64 << 20), &[], &Job::new()).unwrap();
}

fn is_warned(window: &Window) -> bool {
    told(window, "Check the capture")
}

#[test]
fn noisy_depth_is_called_noise_in_the_matrix_and_is_no_reason_to_doubt_poses() {
    let folder = tempfile::tempdir().unwrap();
    write_noisy(folder.path());
    let mut window = open(Start::Path(folder.path().to_path_buf()), SIZE);
    settle(&mut window);
    assert!(!is_warned(&window), "{:?}", window.state().observed().notices);
    open_view(&mut window, "Report");
    assert!(shows(&window, "Noise: cameras differ by as much as the noise"));
    let noisy = scale_of_matrix(&window);
    let mut window = open(demo(5, 1, (160, 120)), SIZE);
    settle(&mut window);
    open_view(&mut window, "Report");
    assert!(shows(&window, "No camera contradicts the others."));
    let exact = scale_of_matrix(&window);
    assert!(noisy > 3.0 * exact, "colors go as far as cameras are apart: {noisy} and {exact} footprints");
}

/// How many footprints the lightest color of the matrix of agreement stands for.
fn scale_of_matrix(window: &Window) -> f64 {
    let end = window.query_all_by_label_contains(" footprints or more").next().expect("a scale");
    let text = end.accesskit_node().value().unwrap();
    text.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn settings_that_differ_are_told_with_the_next_capture_and_lead_to_where_they_are_reset() {
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    assert!(!shows(&window, "Settings were kept"), "nothing differs yet");
    pick(&mut window, "Presets", "Aggressive");
    settle(&mut window);
    click(&mut window, "Report");
    let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture");
    drop_on(&mut window, &capture);
    wait(&mut window, "the capture", |window| window.state().observed().scene_name == Some("small_capture"));
    // The message goes by itself after a while.
    window.run_steps(2);
    assert!(shows(&window, "Settings were kept") && shows(&window, "5 settings differ from the defaults"));
    click(&mut window, "Show in Settings");
    assert!(window.state().observed().views_in_sight.contains(&"Settings"));
    window.get_by_label("Reset all").scroll_to_me();
    window.run_steps(3);
    click(&mut window, "Reset all");
    settle(&mut window);
    assert!(shows(&window, "Every setting has its default"));
}
