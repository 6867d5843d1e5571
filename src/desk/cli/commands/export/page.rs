//! `overlook export page`.

use std::path::PathBuf;

use clap::Args;

use super::path::{self, Stops};
use crate::cli::input::{self, BarredValueArgs, StoreArgs};
use crate::cli::output::{self, CommandError};
use crate::ways_out;
use overlook_engine::capture::transforms::Easing;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::page::{self, PageOptions, PagePath, PageScalarBar, PageSummary};
use overlook_engine::render::colored_samples;
use overlook_engine::render::film::FilmSource;
use overlook_engine::render::output::kept_values;
use overlook_engine::store::file::{Store, StoreInfo};
use overlook_lab::chart::ColorBar;

#[derive(Debug, Args)]
pub(crate) struct PageArgs {
    #[command(flatten)]
    from: StoreArgs,
    /// The page, as in scene.html.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The title [default: the name of the capture].
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// A text about the scene; empty lines part its paragraphs.
    #[arg(long, value_name = "TEXT")]
    text: Option<String>,
    /// A camera path that the page can follow: a manifest of views, as export video takes it.
    #[arg(long, value_name = "TRANSFORMS")]
    path: Option<PathBuf>,
    /// Frames a second.
    #[arg(long, default_value_t = 24.0, value_parser = super::pictures::frames_per_second)]
    fps: f64,
    /// Most bytes of the page, as in 3000000, 500k or 3M: what shows least is made coarser until it fits.
    #[arg(long, value_name = "BYTES", value_parser = input::amount)]
    at_most: Option<u64>,
    #[command(flatten)]
    values: BarredValueArgs,
}

impl PageArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        self.from.check_out(&self.out, Some("scene.html"))?;
        self.values.values.refuse_transparent("a page")?;
        if let Some(path) = &self.path {
            output::refuse_view_files(path, &self.out)?;
        }
        let playback = self.from.open()?;
        let path = self.path.as_ref().map(|path| page_path(path, playback.store().info(), self.fps));
        let options = PageOptions {
            path: path.transpose()?,
            title: self.title.clone(),
            text: self.text.clone(),
            scalar_bar: None,
            frames_per_second: self.fps,
            at_most: self.at_most,
        };
        let channels = &playback.outline().values;
        let colored = self.values.values.channel(channels, &self.from.store.display().to_string())?;
        let form = colored.is_none().then_some("a page");
        output::export(std::slice::from_ref(&playback), form, |job| {
            let written = match colored {
                Some(channel) => self.write_colored(playback.store(), channel, options, job)?,
                None => ways_out::page::write(&self.out, &FilmSource::Disk(playback.clone()), &options, job)?,
            };
            let of_store = match written.samples_of_store {
                all if all == written.samples => String::new(),
                all => format!(" in place of {}", output::count(all)),
            };
            let said = format!(
                "Wrote {}, {}{of_store}, to {}\nNext: open it in a browser",
                output::bytes(written.bytes),
                output::count_of(written.samples, "sample"),
                self.out.display()
            );
            Ok((said, None))
        })
    }

    /// Writes the page of samples in the colors of a value. Shares of a range are those of the samples of the first frame.
    fn write_colored(
        &self,
        store: &Store,
        channel: usize,
        options: PageOptions,
        job: &Job,
    ) -> Result<PageSummary> {
        let set = store.read_all(job)?;
        let place = self.from.store.display().to_string();
        let value = self.values.values.shown(&set.values, channel, &kept_values(&set, 0, channel), &place)?;
        let ColorBar { title, colors, ticks } = value.bar;
        let scalar_bar = self.values.has_bar().then_some(PageScalarBar { title, colors, ticks });
        let colored = colored_samples(&set, channel, &value.colors);
        page::write_set(&self.out, &colored, &PageOptions { scalar_bar, ..options }, job)
    }
}

fn page_path(manifest: &std::path::Path, store: &StoreInfo, rate: f64) -> Result<PagePath> {
    let pace = path::Pace { frame: None, pictures: None, easing: Easing::Linear, rate };
    let Stops { vantages, .. } = path::along(manifest, store, pace)?;
    Ok(PagePath {
        first_frame: vantages[0].frame,
        lens: vantages[0].camera.intrinsics,
        poses: vantages.into_iter().map(|vantage| vantage.camera.world_from_camera).collect(),
    })
}
