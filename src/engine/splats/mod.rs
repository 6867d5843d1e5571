//! The kept samples as flat Gaussians, in the formats that viewers of splats open.
//!
//! ```text
//! SampleSet ─ field: spans, budget ─▶ normals ─ gaussian ─▶ splats in the axes of a format ─ ply, spz, glb, usda ─▶ file
//!                       sky: far dome ──────────────────────────────▲ space, color   └▶ arrays: in the world, for programs
//! ```
//!
//! A splat is centered on its sample, lies in its surface and is as wide as its pixel there: nothing is trained. Colors do not depend on
//! direction. PLY and SPZ hold one frame; glTF and USD hold each splat once, with the span of frames over which it is seen.

mod field;
mod gaussian;
mod glb;
mod normals;
mod ply;
mod space;
mod spz;
mod usda;

use std::io::{BufWriter, Write};
use std::path::Path;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::{SampleSet, Span};
use crate::settings::choice::choice;
use crate::whole_file;
use field::Field;
pub use field::{SplatArrays, arrays};
use space::Space;

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatSummary {
    /// Splats in the file, those of the sky included.
    pub splats: u64,
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
    let written = Field::new(set, space, options.amount, job).and_then(|field| {
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

choice! {
    /// A file format of Gaussian splats.
    pub enum SplatFormat {
        /// One frame as PLY, as the authors of Gaussian splatting write it: nearly every program reads it, 68 bytes a splat.
        Ply = "ply",
        /// One frame as SPZ, version 3: some 10 to 15 bytes a splat.
        Spz = "spz",
        /// The whole scene as glTF with its extension for splats: a node for each span of frames, shown by an animation.
        Glb = "glb",
        /// The whole scene as USD, a particle field for each span of frames, shown by its visibility.
        Usda = "usda",
    }
}

choice! {
    /// What becomes of samples at infinity.
    pub enum SplatSky {
        /// They are left out: no format has a place for them.
        Out = "out",
        /// Their colors, continued into all directions, become a far dome around the scene.
        Dome = "dome",
    }
}

impl SplatFormat {
    /// Whether a file holds the whole scene in time; of the others each holds one frame.
    #[must_use]
    pub fn holds_time(self) -> bool {
        matches!(self, Self::Glb | Self::Usda)
    }
}

/// How many splats there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SplatAmount {
    /// Most splats, the dome's included; samples are merged where that loses least until they fit.
    pub at_most: Option<u64>,
    /// What becomes of samples at infinity.
    pub sky: SplatSky,
}

/// How splats are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplatOptions {
    /// The format.
    pub format: SplatFormat,
    /// How many splats a file has.
    pub amount: SplatAmount,
    /// Frames a second, where the format holds time; above 0.
    pub frames_per_second: f64,
}

/// The frames of a scene in time.
#[derive(Clone, Copy, Debug)]
struct Timing {
    /// How many there are.
    frames: usize,
    /// Above 0.
    frames_per_second: f64,
}

impl Timing {
    /// Frames at which a span appears or goes, or the scene begins or ends, each with whether the span is seen from there on.
    fn changes(self, span: Span) -> Vec<(u32, bool)> {
        let last = self.frames as u32;
        let mut frames = vec![0, span.start, span.end, last];
        frames.dedup();
        let is_seen = |frame: u32| frame >= span.start && (frame < span.end || span.end == last);
        frames.into_iter().map(|frame| (frame, is_seen(frame))).collect()
    }

    /// Whether a span is that of all frames.
    fn is_always(self, span: Span) -> bool {
        span.len() == self.frames
    }

    /// Seconds from the first frame to one.
    fn seconds(self, frame: u32) -> f32 {
        (f64::from(frame) / self.frames_per_second) as f32
    }
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

    #[test]
    fn a_span_is_seen_from_its_first_frame_until_the_one_after_its_last() {
        let timing = Timing { frames: 8, frames_per_second: 4.0 };
        let changes = |start: u32, end: u32| timing.changes(Span { start, end });
        assert_eq!(changes(0, 4), [(0, true), (4, false), (8, false)]);
        assert_eq!(changes(3, 5), [(0, false), (3, true), (5, false), (8, false)]);
        assert_eq!(changes(4, 8), [(0, false), (4, true), (8, true)]);
        assert!(timing.is_always(Span { start: 0, end: 8 }) && !timing.is_always(Span { start: 0, end: 4 }));
        assert_eq!(timing.seconds(6), 1.5);
    }
}
