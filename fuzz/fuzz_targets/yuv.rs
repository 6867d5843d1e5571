//! Any text as the cameras of MPEG immersive video beside raw video: it opens or is refused, and nothing panics.
#![no_main]

use libfuzzer_sys::fuzz_target;
use overlook::capture;
use overlook::settings::CaptureSettings;

fuzz_target!(|bytes: &[u8]| {
    let Ok(folder) = tempfile::tempdir() else { return };
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).is_ok();
    let is_there = put("cameras.json", bytes)
        && put("v0_texture_8x6_yuv420p.yuv", &[128; 144])
        && put("v0_depth_8x6_yuv420p16le.yuv", &[200; 288]);
    if is_there && let Ok(capture) = capture::open(folder.path(), &CaptureSettings::default()) {
        for frame in 0..capture.frame_count() {
            let _ = capture.frame(0, frame);
        }
    }
});
