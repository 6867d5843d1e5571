//! Any bytes as a store: what can be read is read, whole and from a vantage, and nothing panics.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use overlook::job::Job;
use overlook::store::file::Store;
use overlook::store::playback::Playback;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(store) = Store::over(Path::new("fuzzed.ovl"), Box::new(bytes.to_vec())) {
        let _ = store.head(0);
        let _ = store.read_all(&Job::new());
        let _ = store.unknown_chunks();
        let playback = Playback::new(store, 1 << 20);
        let camera = playback.outline().cameras.first().cloned();
        let _ = camera.map(|camera| playback.seen_from(&camera, 0, &Job::new()));
        let _ = playback.at(0, &Job::new());
    }
});
