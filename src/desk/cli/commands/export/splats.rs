//! `overlook export splats`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::input::{self, StoreArgs};
use crate::cli::output::{self, CommandError};
use crate::ways_out::splats;
use overlook_engine::plural::counted;
use overlook_engine::render::film::FilmSource;
use overlook_engine::splats::{SplatAmount, SplatFormat, SplatOptions, SplatSky, SplatSummary};

#[derive(Debug, Args)]
pub(crate) struct SplatsArgs {
    #[command(flatten)]
    from: StoreArgs,
    /// The file format.
    #[arg(long, value_parser = input::choice::<SplatFormat>(SplatFormat::NAMES))]
    format: SplatFormat,
    /// The file, as in scene.glb; of PLY and SPZ without --frame a folder, in which each frame gets a file.
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
    /// Only this frame, by its number in the capture.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// Most splats of a file, as in 300000, 500k or 1.5M: samples are merged where that shows least.
    #[arg(long, value_name = "N", value_parser = input::amount)]
    at_most_splats: Option<u64>,
    /// What becomes of samples at infinity: a far dome of splats, which also closes holes behind the scene, or nothing.
    #[arg(long, default_value = SplatSky::Dome.name(), value_parser = input::choice::<SplatSky>(SplatSky::NAMES))]
    sky: SplatSky,
    /// Frames a second of a scene in time, as GLB and USDA hold it.
    #[arg(long, default_value_t = 24.0, value_parser = super::pictures::frames_per_second)]
    fps: f64,
}

impl SplatsArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        let example = format!("scene.{}", self.format);
        self.from.check_out(&self.out, self.is_one_file().then_some(&example))?;
        let playback = self.from.open()?;
        let options = SplatOptions {
            format: self.format,
            amount: SplatAmount { at_most: self.at_most_splats, sky: self.sky },
            frames_per_second: self.fps,
        };
        let frame = self.from.frame(&playback, self.frame)?;
        let source = FilmSource::Disk(playback.clone());
        output::export(&[playback], Some("a file of splats"), |job| {
            Ok((self.said(&splats::write(&self.out, &source, frame, &options, job)?), None))
        })
    }

    fn is_one_file(&self) -> bool {
        self.frame.is_some() || self.format.holds_time()
    }

    /// What was done, in one line.
    fn said(&self, written: &[SplatSummary]) -> String {
        let sum = |of: fn(&SplatSummary) -> u64| written.iter().map(of).sum::<u64>();
        let (splats, behind, of_sky) = (sum(|one| one.splats), sum(|one| one.behind), sum(|one| one.of_sky));
        let samples = sum(|one| one.samples);
        let mut said = vec![format!("Wrote {} to {}", output::count_of(splats, "splat"), self.out.display())];
        if !self.is_one_file() {
            said.push(counted(written.len(), "file"));
        }
        if splats - behind - of_sky != samples {
            said.push(format!("merged from {}", output::count_of(samples, "sample")));
        }
        if behind > 0 {
            said.push(format!("{} of them behind surfaces", output::count(behind)));
        }
        match (of_sky, sum(|one| one.at_infinity)) {
            (0, 0) => {}
            (0, left) => said.push(format!("without {} of the sky", output::count_of(left, "sample"))),
            (dome, _) => said.push(format!("{} of them the sky as a far dome", output::count(dome))),
        }
        if let Some([x, y, z]) = written.first().and_then(|one| one.offset) {
            said.push(format!("less the offset ({x}, {y}, {z})"));
        }
        if let Some(one) = written.iter().find(|one| one.scale != 1.0) {
            said.push(format!("in units of {} of the capture's", 1.0 / one.scale));
        }
        let error = written.iter().map(|one| one.position_error).fold(0.0, f64::max);
        if error > 0.0 {
            said.push(format!("positions within {error:.1e}"));
        }
        said.join("; ")
    }
}
