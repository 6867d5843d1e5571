//! Gaussian splats.

use std::path::Path;

use super::shared::{FileKind, Frames, Options, Scope, Shared, Size, WayOut, at, write_frames};
use crate::text::count_of;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::render::film::FilmSource;
use overlook_engine::splats::{self, SplatAmount, SplatFormat, SplatOptions, SplatSky, SplatSummary};

pub(crate) const WAY: WayOut = WayOut {
    name: "Splats",
    used: "Gaussian splats for other viewers and engines: every kept sample is one, as wide as its pixel. Nothing is trained.",
    button: "Make the splats…",
    command: "splats",
    about: "Samples as Gaussian splats, in formats that other viewers open: PLY, SPZ, glTF, USD",
    kind: |options| match options.format {
        SplatFormat::Ply => &PLY,
        SplatFormat::Spz => &SPZ,
        SplatFormat::Glb => &GLB,
        SplatFormat::Usda => &USDA,
    },
    size,
    write: Some((&[PLY, SPZ, GLB, USDA], share)),
};

/// Splats by their format.
pub(crate) const PLY: FileKind = FileKind::of_samples("Share splats", &["ply"], "");
pub(crate) const SPZ: FileKind = FileKind { endings: &["spz"], ..PLY };
pub(crate) const GLB: FileKind = FileKind { endings: &["glb"], ..PLY };
pub(crate) const USDA: FileKind = FileKind { endings: &["usda"], ..PLY };

/// Splats of the dome that the sky becomes.
const DOME: u64 = 10_000;

/// Splats for each sample with a place, measured: some lie behind surfaces.
const PER_SAMPLE: f64 = 1.2;

/// Bytes of a splat, measured; SPZ is compressed, and the others hold numbers as they are.
fn bytes_of_splat(format: SplatFormat) -> f64 {
    match format {
        SplatFormat::Ply => 68.0,
        SplatFormat::Spz => 12.0,
        SplatFormat::Glb => 64.0,
        SplatFormat::Usda => 178.0,
    }
}

fn size(scope: &Scope, options: &Options) -> Size {
    let facts = &scope.facts;
    let here = facts.placed_here + facts.at_infinity_here;
    let placed = if options.format.holds_time() {
        // As large a share of all samples as of those at this frame.
        (facts.samples as f64 * facts.placed_here as f64 / here.max(1) as f64) as u64
    } else {
        facts.placed_here
    };
    let placed = (placed as f64 * PER_SAMPLE) as u64;
    let dome = if options.sky == SplatSky::Dome && facts.at_infinity_here > 0 { DOME } else { 0 };
    let all = placed + dome;
    let splats = options.splats_at_most().map_or(all, |most| all.min(most));
    let each = bytes_of_splat(options.format);
    let merged =
        if splats < all { format!(" merged from {}", count_of(all, "sample")) } else { String::new() };
    let reason = format!("{} of {each:.0} B{merged}", count_of(splats, "splat"));
    Size::about(splats as f64 * each, reason)
}

fn share(path: &Path, source: &FilmSource, shared: &Shared, job: &Job) -> Result<(String, usize)> {
    let format = match *shared.kind {
        SPZ => SplatFormat::Spz,
        GLB => SplatFormat::Glb,
        USDA => SplatFormat::Usda,
        _ => SplatFormat::Ply,
    };
    let options = SplatOptions {
        format,
        amount: SplatAmount { at_most: shared.options.splats_at_most(), sky: shared.options.sky },
        frames_per_second: shared.frames_per_second,
    };
    let frame = if let Frames::One(frame) = shared.frames { Some(frame) } else { None };
    let frame = frame.filter(|_| !format.holds_time());
    let written = write(path, source, frame, &options, job)?.remove(0);
    let mut said = (shared.count)(written.splats, "splat");
    if written.of_sky == 0 && written.at_infinity > 0 {
        said = format!("{said}, without {} of the sky", (shared.count)(written.at_infinity, "sample"));
    }
    if let Some([x, y, z]) = written.offset {
        said = format!("{said}, less the offset ({x}, {y}, {z})");
    }
    Ok((said, 1))
}

/// Writes splats of a frame, or of all time: one file where the format holds it, else a folder with one for each frame. Gives what was
/// written, file by file.
///
/// # Errors
/// As [`splats::write`].
pub(crate) fn write(
    path: &Path,
    source: &FilmSource,
    frame: Option<usize>,
    options: &SplatOptions,
    job: &Job,
) -> Result<Vec<SplatSummary>> {
    let set = match (frame, source) {
        (Some(frame), _) => at(source, frame, job)?,
        (None, _) if !options.format.holds_time() => {
            return write_frames(path, options.format.name(), source, job, |path, set, frame| {
                splats::write(path, set, Some(frame), options, job)
            });
        }
        (None, FilmSource::Memory(samples)) => samples.clone(),
        (None, FilmSource::Disk(playback)) => playback.store().read_all(job)?.into(),
    };
    Ok(vec![splats::write(path, &set, frame, options, job)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ways_out::{Facts, page};

    fn scope() -> Scope {
        let facts = Facts {
            samples: 1_000_000,
            placed_here: 300_000,
            at_infinity_here: 100_000,
            store_bytes: 2e6,
            picture: None,
        };
        Scope {
            facts,
            cameras: 3,
            frames: 1,
            is_far: false,
            frames_per_second: 24.0,
            film_pictures: 0,
            film_size: [0; 2],
            figure_size: [0; 2],
        }
    }

    #[test]
    fn a_bound_is_what_a_larger_page_takes_and_nothing_to_a_smaller_one() {
        let text = |options| (page::WAY.size)(&scope(), &options).text;
        let unbounded = text(Options::default());
        assert!(unbounded.starts_with("about 2.") && unbounded.ends_with(" MB"), "{unbounded}");
        let bounded =
            |page_megabytes| text(Options { page_is_bounded: true, page_megabytes, ..Options::default() });
        assert_eq!((bounded(1.0), bounded(50.0)), ("about 1.00 MB".to_owned(), unbounded));
    }

    #[test]
    fn splats_are_those_with_a_place_of_this_frame_or_of_all_time() {
        let splats = |options| size(&scope(), &options);
        let of_frame = splats(Options::default());
        assert_eq!(
            (of_frame.text.as_str(), of_frame.reason.as_str()),
            ("about 25.2 MB", "370 k splats of 68 B")
        );
        assert_eq!(splats(Options { format: SplatFormat::Glb, ..Options::default() }).text, "about 58.2 MB");
        let options = Options { splats_are_bounded: true, kilosplats: 100, ..Options::default() };
        assert_eq!(splats(options).text, "about 6.80 MB");
    }
}
