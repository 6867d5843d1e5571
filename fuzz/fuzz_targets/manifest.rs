//! Any text as a capture's manifest: it opens or is refused, and nothing panics.
#![no_main]

use libfuzzer_sys::fuzz_target;
use overlook::capture::transforms;
use overlook::settings::CaptureSettings;

fuzz_target!(|bytes: &[u8]| {
    let Ok(folder) = tempfile::tempdir() else { return };
    let path = folder.path().join("transforms.json");
    if std::fs::write(&path, bytes).is_ok() {
        let _ = transforms::open(&path, &CaptureSettings::default());
        let _ = transforms::open_views(&path);
    }
});
