//! Reads everything in a store, as playing it would, and reports what is damaged.

use std::path::Path;
use std::time::Instant;

use super::player::Playback;
use crate::error::Result;
use crate::job::Job;
use crate::store::file::Store;

/// Decoded images that are kept meanwhile, bytes.
const CACHE_BYTES: u64 = 256 << 20;

/// Bytes of one input pixel as 8-bit color and 32-bit depth.
const INPUT_PIXEL_BYTES: f64 = 7.0;

/// What became of the reading.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Verification {
    /// Images read.
    pub images: usize,
    /// Frames played, in their order.
    pub frames: usize,
    /// Samples by the index of the store.
    pub samples: u64,
    /// Bytes of the file.
    pub bytes: u64,
    /// Wall-clock seconds from opening the file to the first frame's samples.
    pub seconds_to_first_frame: f64,
    /// Wall-clock seconds of all frames.
    pub seconds: f64,
    /// Bytes of the input, as 8-bit color and 32-bit depth, that one second of reading frames represents, in 10⁹.
    pub input_gb_per_s: f64,
    /// One line for everything that is damaged: which chunk, at which byte, and what of it is lost.
    pub damage: Vec<String>,
}

/// Reads every chunk of a store: checksums, tables, and every sample.
///
/// # Errors
/// As [`Store::open`], where nothing of the store can be shown; `Io` and `Cancelled`. Damaged images are no error:
/// see [`Verification::damage`].
pub fn verify(path: &Path, job: &Job) -> Result<Verification> {
    let started = Instant::now();
    let playback = Playback::new(Store::open(path)?, CACHE_BYTES);
    let info = playback.store().info();
    let frames = info.frame_numbers.len();
    let mut seconds_to_first_frame = 0.0;
    job.start("Reading the store", frames);
    for frame in 0..frames {
        job.check()?;
        playback.at(frame, job)?;
        if frame == 0 {
            seconds_to_first_frame = started.elapsed().as_secs_f64();
        }
        job.advance(1);
    }
    let seconds = started.elapsed().as_secs_f64();
    let pixels: usize = info.cameras.iter().map(|camera| camera.intrinsics.pixel_count()).sum();
    let input_bytes = INPUT_PIXEL_BYTES * (pixels * frames) as f64;
    let mut damage = playback.store().check_chunks()?;
    damage.extend(playback.store().damage());
    Ok(Verification {
        images: info.images.len(),
        frames,
        samples: info.sample_count(),
        bytes: info.bytes,
        seconds_to_first_frame,
        seconds,
        input_gb_per_s: input_bytes / seconds.max(1e-9) / 1e9,
        damage,
    })
}
