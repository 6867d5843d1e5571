//! The kept samples as flat Gaussians, in the formats that viewers of splats open.
//!
//! ```text
//! SampleSet ─ field: spans, budget ─▶ normals ─ gaussian ─ backs ─▶ splats in the axes of a format ─ ply, spz, glb, usda ─▶ file
//!                       sky: far dome ──────────────────────────────▲ space, color   └▶ arrays: in the world, for programs
//! ```
//!
//! A splat is centered on its sample, lies in its surface and is as wide as its pixel there: nothing is trained. Wider ones behind them keep
//! surfaces opaque. Colors do not depend on direction. PLY and SPZ hold one frame; glTF and USD hold each splat once, with the span of frames over
//! which it is seen.

mod backs;
mod field;
mod gaussian;
mod glb;
mod normals;
mod options;
mod ply;
mod space;
mod spz;
mod timing;
mod usda;

use std::io::{BufWriter, Write};
use std::path::Path;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::SampleSet;
use crate::whole_file;

use field::Field;
use space::Space;
use timing::Timing;

pub use field::{SplatArrays, arrays};
pub use options::{SplatAmount, SplatFormat, SplatOptions, SplatSky};

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatSummary {
    /// Splats in the file, those of the sky included.
    pub splats: u64,
    /// Those behind surfaces, which keep them opaque.
    pub behind: u64,
    /// Those of the sky's dome.
    pub of_sky: u64,
    /// Samples that have a place: each is a splat, unless a budget merges some.
    pub samples: u64,
    /// Samples at infinity, which are no splats of their own.
    pub at_infinity: u64,
    /// What has to be added to the positions for those of the capture, in the axes of the file, where the file itself does not say so to
    /// a program; `None` where nothing has to.
    pub offset: Option<[f64; 3]>,
    /// Units of the file in a unit of the capture: 1, or a power of ten where the format needs another size.
    pub scale: f64,
    /// By how much a position differs at most from that of its sample for the format's sake, units of the capture; 0 where the file holds
    /// single precision.
    pub position_error: f64,
}

/// Writes a frame of a set, by its index, or in the formats that hold time all frames, where there is none given.
///
/// # Errors
/// `Io`, `Cancelled`; `Invalid` where the set holds no sample with a place, where so few splats cannot be had, where the format cannot
/// hold so many or so wide a scene, and where a format that holds one frame is asked for all. Nothing is written then.
pub fn write(
    path: &Path,
    set: &SampleSet,
    frame: Option<usize>,
    options: &SplatOptions,
    job: &Job,
) -> Result<SplatSummary> {
    let of_frame = frame.map(|frame| field::of_frame(set, frame));
    if of_frame.is_none() && !options.format.holds_time() {
        let what = "is not written: a file of this format holds one frame; choose one";
        return Err(Error::invalid(path.display(), what));
    }
    let set = of_frame.as_ref().unwrap_or(set);
    let space = Space::of(set, options.format);
    let written = Field::new(set, space, options.amount, true, job).and_then(|field| {
        whole_file::write(path, |target| write_field(target, path, set, &field, options, job))
    });
    // What is wrong is wrong with the file that is not written.
    written.map_err(|error| match error {
        Error::Invalid { place, what } if place == set.name => Error::invalid(path.display(), what),
        other => other,
    })
}

fn write_field(
    target: &mut BufWriter<&mut std::fs::File>,
    path: &Path,
    set: &SampleSet,
    field: &Field<'_>,
    options: &SplatOptions,
    job: &Job,
) -> Result<SplatSummary> {
    let io = |error| Error::io(path, error);
    let timing = Timing { frames: set.frame_count(), frames_per_second: options.frames_per_second };
    let mut summary = SplatSummary {
        splats: field.count(),
        behind: field.back_count(),
        of_sky: field.dome_count(),
        samples: field.placed,
        at_infinity: field.at_infinity,
        offset: None,
        scale: 1.0,
        position_error: 0.0,
    };
    match options.format {
        SplatFormat::Glb => glb::write(target, field, &set.name, timing, path, job)?,
        SplatFormat::Usda => usda::write(target, field, &set.name, timing, path, job)?,
        SplatFormat::Ply | SplatFormat::Spz => {
            let offset = field.space.offset();
            summary.offset = offset.map(|offset| offset.to_array());
            let mut splats = Vec::new();
            for span in &field.spans {
                splats.extend(field.splats(span, job)?);
            }
            if options.format == SplatFormat::Ply {
                ply::write(target, &set.name, &splats, offset).map_err(io)?;
            } else {
                let packed = spz::pack(&splats, &set.name)?;
                target.write_all(&packed.bytes).map_err(io)?;
                (summary.scale, summary.position_error) = (packed.scale, packed.error);
            }
        }
    }
    Ok(summary)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::preprocess::preprocess;
    use crate::settings::Settings;
    use std::sync::Arc;

    fn demo() -> Arc<SampleSet> {
        let demo = Demo::new(&DemoSpec::new("orrery").size((96, 72)).cameras(2).frames(4)).unwrap();
        let settings = Settings::default();
        preprocess(&demo.capture(&settings.capture), &settings, &Job::new()).unwrap().samples
    }

    fn options(format: SplatFormat) -> SplatOptions {
        SplatOptions {
            format,
            amount: SplatAmount { at_most: None, sky: SplatSky::Out },
            frames_per_second: 24.0,
        }
    }

    fn exported(
        set: &SampleSet,
        frame: Option<usize>,
        options: &SplatOptions,
    ) -> Result<(SplatSummary, u64)> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene");
        let written = write(&path, set, frame, options, &Job::new());
        assert_eq!(path.exists(), written.is_ok());
        written.map(|summary| (summary, path.metadata().unwrap().len()))
    }

    #[test]
    fn a_budget_is_kept_and_nearly_used_with_and_without_the_sky() {
        let set = demo();
        for format in [SplatFormat::Ply, SplatFormat::Glb] {
            let frame = (!format.holds_time()).then_some(0);
            let (whole, _) = exported(&set, frame, &options(format)).unwrap();
            for (sky, most) in
                [(SplatSky::Out, whole.splats / 3), (SplatSky::Dome, 10_000 + whole.splats / 2)]
            {
                let asked =
                    SplatOptions { amount: SplatAmount { at_most: Some(most), sky }, ..options(format) };
                let (fewer, _) = exported(&set, frame, &asked).unwrap();
                let found = fewer.splats;
                // A square of 32×32 pixels is merged as a whole.
                assert!(found <= most && found + 3 * 256 > most, "{format}, {sky}: {found} of {most}");
                assert_eq!(fewer.samples, whole.samples);
            }
            let amount = SplatAmount { at_most: Some(9), sky: SplatSky::Out };
            let said = exported(&set, frame, &SplatOptions { amount, ..options(format) });
            let said = said.unwrap_err().to_string();
            assert!(said.contains("more than the 9") && said.contains("allow more"), "{said}");
        }
    }
}
