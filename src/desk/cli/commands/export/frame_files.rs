//! A frame of a store by its number, and a file for each frame.

use std::path::Path;

use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::samples::SampleSet;
use overlook_engine::store::playback::Playback;
use overlook_engine::whole_file;

/// The index of the frame that bears a number in the capture; `store` is named where there is none.
pub(super) fn frame_index(playback: &Playback, number: i64, store: &Path) -> Result<usize> {
    let numbers = &playback.store().info().frame_numbers;
    numbers
        .binary_search(&number)
        .map_err(|_| Error::invalid(store.display(), format!("there is no frame {number} in it")))
}

/// Writes a file for each frame into a folder, as 0001.ply with the number of the frame, all of them or none. `write` gets the name of a
/// file, and the samples of the frame with its index; what it gives is given frame by frame.
pub(super) fn write_frames<T>(
    out: &Path,
    extension: &str,
    playback: &Playback,
    job: &Job,
    mut write: impl FnMut(&Path, &SampleSet, usize) -> Result<T>,
) -> Result<Vec<T>> {
    let numbers = &playback.store().info().frame_numbers;
    job.start("Writing frames", numbers.len());
    whole_file::write_folder(out, |folder| {
        let files = numbers.iter().enumerate().map(|(frame, number)| {
            let set = playback.at(frame, job)?;
            let written = write(&folder.join(format!("{number:04}.{extension}")), &set, frame)?;
            job.advance(1);
            Ok(written)
        });
        files.collect()
    })
}
