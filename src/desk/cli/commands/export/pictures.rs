//! `overlook export pictures` and `overlook export video`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use glam::DVec3;
use image::RgbaImage;

use super::path::{self, Pace, Stops};
use crate::cli::input::{self, BarredValueArgs, RenderingArgs, ShownValue, StoreArgs, choice};
use crate::cli::output::{self, CommandError, PicturePaths};
use overlook_engine::capture::transforms::Easing;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::plural::counted;
use overlook_engine::render::film::{
    self, FilmComparison, FilmEncoder, FilmPainter, FilmPicture, FilmSource,
};
use overlook_engine::render::output::{PictureValues, shown_values, with_below};
use overlook_engine::render::{
    FACE_COUNT, Picture, Projection, Renderer, Vantage, equirectangular, faces_around,
};
use overlook_engine::settings::RenderSettings;
use overlook_engine::store::file::{Store, StoreInfo};
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback};
use overlook_engine::whole_file;
use overlook_lab::chart::{Caption, ColorBar, SideNames};

/// Where a film is painted from, and how.
#[derive(Debug, Args)]
pub(crate) struct FilmArgs {
    #[command(flatten)]
    pub(crate) from: StoreArgs,
    /// The camera path: views at some frames, between which the camera moves smoothly, or every picture of a film, as the window and
    /// nerfstudio's viewer write it. In a scene of one frame every view is a picture.
    #[arg(long, value_name = "TRANSFORMS")]
    path: PathBuf,
    /// Hold the scene at this frame, by its number: every view of the path is a picture of one moment.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// So many pictures, spread evenly over the path; more than it has frames are slow motion.
    #[arg(long, value_name = "N", value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..1_000_000))]
    pictures: Option<usize>,
    /// How the camera sets off and arrives over the whole path; `path_easing` of a view does so from that view to the next.
    #[arg(long, default_value = "linear", value_parser = choice::<Easing>(Easing::NAMES))]
    easing: Easing,
    /// What the pictures show: the view through the lens of the path, or all directions around the camera, with a level horizon, in
    /// pictures twice as wide as they are high.
    #[arg(long, default_value = "perspective", value_parser = choice::<Projection>(Projection::NAMES))]
    projection: Projection,
    /// Columns of equirectangular pictures [default: those of the path's pictures].
    #[arg(long, value_name = "COLUMNS", value_parser = clap::value_parser!(u32).range(4..=16_384))]
    width: Option<u32>,
    /// Orthographic pictures in place of those through the path's lens: this many world units from the left edge to the right one. What
    /// lies behind the camera is not shown.
    #[arg(long, value_name = "WIDTH", value_parser = input::length, conflicts_with = "projection")]
    orthographic: Option<f64>,
    /// Show this store beside the first from the same places: one of the same frames, as of the same scene with other settings.
    /// It is shown as it is: edits act on the first.
    #[arg(long, value_name = "STORE", conflicts_with = "projection")]
    compare: Option<PathBuf>,
    /// How two stores are compared.
    #[arg(long, requires = "compare", default_value = "wipe", value_parser = choice::<FilmComparison>(FilmComparison::NAMES))]
    mode: FilmComparison,
    #[command(flatten)]
    values: BarredValueArgs,
    #[command(flatten)]
    rendering: RenderingArgs,
}

impl FilmArgs {
    /// Refuses a file that the film is made from beside its store.
    pub(crate) fn refuse_inputs(&self, out: &Path) -> Result<()> {
        self.compare.iter().try_for_each(|store| output::refuse_input(store, out))?;
        self.rendering.settings.refuse_inputs(out)?;
        output::refuse_view_files(&self.path, out)
    }

    /// The film at a rate of pictures a second.
    pub(crate) fn plan(&self, rate: f64) -> Result<Film, CommandError> {
        if self.width.is_some() && self.projection == Projection::Perspective {
            let what =
                "only equirectangular pictures have a width of their own; the path says that of others";
            return Err(Error::invalid("--width", what).into());
        }
        whole_file::refuse_pipe(&self.path)?;
        self.rendering.settings.only("render")?;
        let playback = self.from.open()?;
        let info = playback.store().info();
        let settings = self.rendering.of_store(info)?;
        let pace = Pace { frame: self.frame, pictures: self.pictures, easing: self.easing, rate };
        let stops = path::along(&self.path, info, pace)?;
        let up = info.up_in_world;
        let size = stops.vantages[0].camera.intrinsics.size();
        let panorama = (self.projection == Projection::Equirectangular)
            .then(|| Panorama { width: self.width.unwrap_or(size.0 as u32).max(4).next_multiple_of(4), up });
        let place = self.from.store.display().to_string();
        let colored = self.values.values.channel(&playback.outline().values, &place)?;
        if colored.is_some() && panorama.is_some() {
            let what = "equirectangular pictures blend colors, which values do not bear; use --projection perspective";
            return Err(Error::invalid("--color-by", what).into());
        }
        if colored.is_some() && self.compare.is_some() {
            let what =
                "a comparison shows recorded colors; leave out --compare, or make one film of each store";
            return Err(Error::invalid("--color-by", what).into());
        }
        let compared =
            self.compare.as_ref().map(|store| self.compared(store, info, &stops, rate)).transpose()?;
        Ok(Film {
            playback,
            stops,
            settings,
            panorama,
            orthographic: self.orthographic,
            values: colored.map(|channel| (self.values.clone(), channel)),
            place,
            compared,
        })
    }

    /// The other side of a comparison: a store at the places of a film of the store with `info`.
    fn compared(
        &self,
        store: &Path,
        info: &StoreInfo,
        stops: &Stops,
        rate: f64,
    ) -> Result<ComparedSide, CommandError> {
        let opened = Store::open(store)?;
        output::warn(&opened.info().warnings);
        let playback = Playback::new(opened, DEFAULT_CACHE_BYTES);
        let other = playback.store().info();
        let settings = self.rendering.of_store(other)?;
        let there = |vantage: &Vantage| {
            let number = info.frame_numbers[vantage.frame];
            let frame = other.frame_numbers.binary_search(&number).map_err(|_| {
                let what = format!(
                    "has no frame {number}, which {} shows in the film; compare stores of the same frames, or hold one that both \
                     have with --frame NUMBER",
                    self.from.store.display()
                );
                Error::invalid(store.display(), what)
            })?;
            Ok(Vantage { frame, ..vantage.clone() })
        };
        let vantages = stops.vantages.iter().map(there).collect::<Result<Vec<_>>>()?;
        let names = told_apart([&self.from.store, store]);
        Ok(ComparedSide { playback: Arc::new(playback), vantages, settings, mode: self.mode, rate, names })
    }
}

/// The names of two stores: those of their files, or their paths where these are the same.
fn told_apart(stores: [&Path; 2]) -> [String; 2] {
    let names = stores.map(|store| store.file_stem().unwrap_or_default().to_string_lossy().into_owned());
    if names[0] == names[1] { stores.map(|store| store.display().to_string()) } else { names }
}

/// What a film is compared with.
struct ComparedSide {
    playback: Arc<Playback>,
    /// The places of the film at its own frames.
    vantages: Vec<Vantage>,
    settings: RenderSettings,
    mode: FilmComparison,
    /// Pictures a second.
    rate: f64,
    /// The names of the film's store and of this one.
    names: [String; 2],
}

/// A film that is planned.
pub(crate) struct Film {
    pub(crate) playback: Arc<Playback>,
    pub(crate) stops: Stops,
    settings: RenderSettings,
    /// Set in films that show all directions.
    pub(crate) panorama: Option<Panorama>,
    /// Width of orthographic pictures, world units.
    orthographic: Option<f64>,
    /// How a value is shown, and its channel, where colors are those of a value.
    values: Option<(BarredValueArgs, usize)>,
    /// The store, for errors.
    place: String,
    compared: Option<ComparedSide>,
}

/// A picture of a film.
pub(crate) struct FilmFrame<'a> {
    /// As it was rendered.
    rendered: &'a Picture,
    /// In the colors of a value, above its scalar bar, with all values, where colors are those of a value.
    colored: Option<(Picture, PictureValues)>,
}

impl FilmFrame<'_> {
    /// What is to be seen.
    pub(crate) fn shown(&self) -> &Picture {
        self.colored.as_ref().map_or(self.rendered, |(colored, _)| colored)
    }

    fn write(&self, paths: &PicturePaths) -> Result<()> {
        match &self.colored {
            Some((colored, values)) => paths.write_with_values(self.rendered, values, colored, false),
            None => paths.write(self.rendered),
        }
    }
}

/// All directions around the camera.
#[derive(Clone, Copy)]
pub(crate) struct Panorama {
    width: u32,
    /// In the world.
    up: DVec3,
}

impl Film {
    /// Columns and rows of its pictures.
    pub(crate) fn size(&self) -> [usize; 2] {
        let own = self.stops.vantages[0].camera.intrinsics.size();
        let has_bar = self.values.as_ref().is_some_and(|(args, _)| args.has_bar());
        let below = match &self.compared {
            Some(_) => SideNames::rows(own.0),
            None if has_bar => ColorBar::strip_rows(own.0),
            None => 0,
        };
        let all_around = |panorama: Panorama| [panorama.width as usize, panorama.width as usize / 2];
        self.panorama.map_or([own.0, own.1 + below], all_around)
    }

    /// Renders every stop in order and passes each picture on with its index; returns a notice if another renderer than requested was
    /// used.
    pub(crate) fn paint(
        &self,
        job: &Job,
        mut take: impl FnMut(usize, &FilmFrame<'_>) -> Result<()>,
    ) -> Result<Option<String>> {
        let mut renderer = Renderer::strict(self.settings.backend)?;
        let source = FilmSource::Disk(self.playback.clone());
        let vantages = &self.stops.vantages;
        if let Some(other) = &self.compared {
            return self.paint_beside(other, &mut renderer, job, take);
        }
        let Some(Panorama { width, up }) = self.panorama else {
            let mut look = None;
            let take = |nth: usize, shown: &FilmPicture| take(nth, &self.frame(shown, &mut look)?);
            let (width, settings) = (self.orthographic, &self.settings);
            film::paint(&source, vantages, width, &mut renderer, settings, job, take)?;
            return Ok(renderer.notice().map(str::to_owned));
        };
        let faces: Vec<_> = vantages.iter().flat_map(|vantage| faces_around(vantage, up, width)).collect();
        let mut painted = Vec::with_capacity(FACE_COUNT);
        film::paint(&source, &faces, None, &mut renderer, &self.settings, job, |nth, face| {
            painted.push(Picture::clone(&face.picture));
            match <&[Picture; FACE_COUNT]>::try_from(painted.as_slice()) {
                Ok(all) => {
                    let rendered = &equirectangular(all, width);
                    take(nth / FACE_COUNT, &FilmFrame { rendered, colored: None })?;
                }
                Err(_) => return Ok(()),
            }
            painted.clear();
            Ok(())
        })?;
        Ok(renderer.notice().map(str::to_owned))
    }

    /// A picture in its colors. `look` is how the value is shown and what lies below pictures: the first one decides, so that colors mean
    /// the same in all of them.
    fn frame<'a>(
        &self,
        shown: &'a FilmPicture,
        look: &mut Option<(ShownValue, Option<RgbaImage>)>,
    ) -> Result<FilmFrame<'a>> {
        let rendered: &Picture = &shown.picture;
        let Some((args, channel)) = &self.values else { return Ok(FilmFrame { rendered, colored: None }) };
        let values = shown.values();
        if look.is_none() {
            let in_view = shown_values(rendered, &values, *channel);
            let value = args.values.shown(&values.channels, *channel, &in_view, &self.place)?;
            let strip = args.strip(&value, rendered.color.width())?;
            *look = Some((value, strip));
        }
        let colored = look.as_ref().map(|(value, strip)| {
            let colored = values.colored(rendered, value.channel, &value.colors);
            match strip {
                Some(strip) => with_below(&colored, strip),
                None => colored,
            }
        });
        Ok(FilmFrame { rendered, colored: colored.map(|colored| (colored, values)) })
    }
}

impl Film {
    /// Its store, and the one that it is compared with.
    pub(crate) fn stores(&self) -> Vec<Arc<Playback>> {
        let other = self.compared.as_ref().map(|other| other.playback.clone());
        [Some(self.playback.clone()), other].into_iter().flatten().collect()
    }

    /// As [`Self::paint`], with another store beside this one.
    fn paint_beside(
        &self,
        other: &ComparedSide,
        renderer: &mut Renderer,
        job: &Job,
        mut take: impl FnMut(usize, &FilmFrame<'_>) -> Result<()>,
    ) -> Result<Option<String>> {
        let sources = [&self.playback, &other.playback].map(|playback| FilmSource::Disk(playback.clone()));
        // Each has its own renderer, which keeps what it painted last.
        let mut other_renderer = Renderer::strict(other.settings.backend)?;
        let [source, other_source] = &sources;
        let orthographic = self.orthographic;
        let mut sides = [
            FilmPainter {
                source,
                vantages: &self.stops.vantages,
                orthographic,
                renderer,
                settings: &self.settings,
            },
            FilmPainter {
                source: other_source,
                vantages: &other.vantages,
                orthographic,
                renderer: &mut other_renderer,
                settings: &other.settings,
            },
        ];
        let side = |side: usize, nth| Ok(sides[side].picture(nth, job)?.picture);
        let names = SideNames::new(&other.names, self.size()[0])?;
        let take = |nth: usize, picture: &Picture, shown| {
            take(nth, &FilmFrame { rendered: &names.below(picture, shown), colored: None })
        };
        let (pictures, [width, _]) = (self.stops.vantages.len(), self.size());
        film::paint_compared(other.mode, pictures, other.rate, width, job, side, take)?;
        let notice = sides.iter().find_map(|side| side.renderer.notice());
        Ok(notice.map(str::to_owned))
    }
}

/// Pictures a second of a path that says when the camera is where, as in a video.
const RATE: f64 = 24.0;

#[derive(Debug, Args)]
pub(crate) struct PicturesArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// Folder for the pictures, named by their frame's number, or by their own where a frame has several.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl PicturesArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        self.film.from.check_out(&self.out, None)?;
        let film = self.film.plan(RATE)?;
        let path_of = |number: &i64| PicturePaths::below(&self.out, &format!("{number:04}"));
        let paths = film.stops.numbers.iter().map(path_of).collect::<Result<Vec<_>>>()?;
        output::refuse_true_pictures(&self.film.path, &self.out, &paths)?;
        output::export(&film.stores(), None, |job| {
            let notice = film.paint(job, |nth, frame| frame.write(&paths[nth]))?;
            Ok((output::wrote_pictures(paths.len(), &self.out), notice))
        })
    }
}

#[derive(Debug, Args)]
pub(crate) struct VideoArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// The video file, as in video.mp4: H.264, which every player and browser shows; as in video.gif: an animated GIF, some four times as large.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Frames a second.
    #[arg(long, default_value_t = 24.0, value_parser = frames_per_second)]
    fps: f64,
    /// A line of text below every picture, or as many lines as it takes.
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true)]
    caption: String,
}

/// Frames a second.
pub(super) fn frames_per_second(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (0.1..=1000.0).contains(&number) { Ok(number) } else { Err("must be between 0.1 and 1000".to_owned()) }
}

impl VideoArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        self.film.from.check_out(&self.out, Some("video.mp4"))?;
        self.film.values.values.refuse_transparent("a video")?;
        let film = self.film.plan(self.fps)?;
        self.film.refuse_inputs(&self.out)?;
        let [columns, rows] = film.size();
        let caption = Caption::new(&self.caption, columns)?;
        if caption.rows() > 0 && film.panorama.is_some() {
            let what = "players turn equirectangular pictures into a sphere, which has no place below it";
            return Err(Error::invalid("--caption", what).into());
        }
        let size = [columns, rows + caption.rows()];
        let frames = counted(film.stops.numbers.len(), "frame");
        output::export(&film.stores(), None, |job| {
            // Only now does Ctrl-C clean up.
            let mut encoder = FilmEncoder::start(&self.out, size, self.fps)?;
            if film.panorama.is_some() {
                encoder.mark_equirectangular();
            }
            let notice = film.paint(job, |_, frame| encoder.add(&caption.below(frame.shown())))?;
            encoder.finish(job)?;
            Ok((format!("Wrote {frames} to {}", self.out.display()), notice))
        })
    }
}
