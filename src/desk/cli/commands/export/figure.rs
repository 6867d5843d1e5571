//! `overlook export figure`.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::address::{self, ViewAddress};
use crate::app::{self, Overlay};
use crate::cli::input::{self, EditsArgs, RenderingArgs, ValueArgs};
use crate::cli::output::{self, CommandError};
use crate::ways_out::figure::{FIGURE, FigureOptions, one_of};
use overlook_engine::capture::Camera;
use overlook_engine::error::{Error, Result};
use overlook_engine::render::film::{self, FilmPicture, FilmSource};
use overlook_engine::render::output::shown_values;
use overlook_engine::render::{Picture, Renderer, ValueColors, Vantage};
use overlook_engine::store::file::StoreInfo;
use overlook_lab::chart::{ColorBar, Figure};

/// What the picture of a capture's camera shows, by the names of the window.
const OVERLAYS: [(&str, Overlay); 9] = [
    ("picture", Overlay::Color),
    ("kept-by", Overlay::WhoWon),
    ("agreement", Overlay::Agreement),
    ("view-dependence", Overlay::ViewDependence),
    ("sampling", Overlay::SamplingRatio),
    ("motion", Overlay::Split),
    ("tiles", Overlay::Tiles),
    ("depth", Overlay::Depth),
    ("normals", Overlay::Normals),
];

#[derive(Debug, Args)]
pub(crate) struct FigureArgs {
    /// A capture, whose recorded picture is shown, or a store, whose view is: 'scene.ovl#view=…&frame=…', as windows and pages copy it, or
    /// that of a camera.
    scene: PathBuf,
    /// The figure, as in figure.pdf: PDF, SVG or PNG by its ending.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The camera whose picture is shown, or from whose place a store is [default: the first].
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// The frame, by its number [default: that of the address, or the first].
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// What lies over a recorded picture [default: picture]. All but picture, depth and normals are of the whole capture, which is
    /// read for them.
    #[arg(long, value_parser = one_of(OVERLAYS))]
    overlay: Option<Overlay>,
    /// An orthographic view of a store: this many world units from the left edge to the right one. What lies behind the viewpoint is not
    /// shown.
    #[arg(long, value_name = "WIDTH", value_parser = input::length)]
    orthographic: Option<f64>,
    #[command(flatten)]
    figure: FigureOptions,
    #[command(flatten)]
    values: ValueArgs,
    #[command(flatten)]
    edits: EditsArgs,
    #[command(flatten)]
    rendering: RenderingArgs,
}

impl FigureArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        self.check_out()?;
        let (place, address) = address::of_path(&self.scene);
        let options =
            FigureOptions { type_points: self.figure.type_points.min(200.0), ..self.figure.clone() };
        let figure = if place.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ovl")) {
            self.of_store(&place, &address.unwrap_or_default(), &options)?
        } else {
            self.of_capture(&place, &options)?
        };
        let bytes = app::write_figure(&self.out, &figure)?;
        output::print(&format!(
            "Wrote a figure of {:.1} mm at {} dpi ({}) to {}",
            options.width_mm(),
            options.dots_per_inch,
            output::bytes(bytes),
            self.out.display()
        ))
    }

    /// Before anything is read.
    fn check_out(&self) -> Result<()> {
        output::check_file(&self.out, "figure.pdf")?;
        let is = |known: &&str| self.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(known));
        if !FIGURE.endings.iter().any(is) {
            let what = "a figure is PDF, SVG or PNG; name it .pdf, .svg or .png";
            return Err(Error::invalid(self.out.display(), what));
        }
        output::refuse_input(&address::of_path(&self.scene).0, &self.out)?;
        self.edits.refuse_inputs(&self.out)?;
        self.rendering.settings.refuse_inputs(&self.out)
    }

    fn of_capture(&self, place: &Path, options: &FigureOptions) -> Result<Figure, CommandError> {
        if self.orthographic.is_some() {
            let what = "an orthographic view is one of a store; a recorded picture is as its camera saw it";
            return Err(Error::invalid("--orthographic", what).into());
        }
        if self.values != ValueArgs::default() {
            let what =
                "a recorded picture is shown in its own colors; preprocess the capture, and give the store";
            return Err(Error::invalid("--color-by", what).into());
        }
        let settings = self.rendering.settings.over(overlook_engine::settings::Settings::default())?;
        let capture = self.edits.open_capture(place, &settings.capture)?;
        let camera = camera_named(&capture.cameras, self.camera.as_deref(), place)?;
        let frame = match self.frame {
            None => 0,
            Some(number) => capture
                .frame_numbers
                .binary_search(&number)
                .map_err(|_| Error::invalid(place.display(), format!("there is no frame {number} in it")))?,
        };
        let overlay = self.overlay.unwrap_or_default();
        let figure = output::watched(|job| {
            app::figure_of_camera(&capture, [camera, frame], overlay, &settings, options, job)
        })?;
        Ok(figure)
    }

    fn of_store(
        &self,
        place: &Path,
        address: &ViewAddress,
        options: &FigureOptions,
    ) -> Result<Figure, CommandError> {
        if self.overlay.is_some_and(|overlay| overlay != Overlay::Color) {
            let what = "a store holds no recorded pictures; give the capture that it was made of";
            return Err(Error::invalid("--overlay", what).into());
        }
        self.rendering.settings.only("render")?;
        let playback = std::sync::Arc::new(self.edits.open_store(place)?);
        let info = playback.store().info();
        let settings = self.rendering.of_store(info)?;
        let number = self.frame.or(address.frame_number);
        let frame = number.map_or(Ok(0), |number| input::frame_index(&playback, number, place))?;
        let camera = self.viewpoint(info, address, place)?;
        let camera = of_columns(&camera, options.columns());
        let vantage = [Vantage { camera: camera.clone(), frame }];
        let mut renderer = Renderer::strict(settings.backend)?;
        let source = FilmSource::Disk(playback.clone());
        let name = place.display().to_string();
        let colored = self.values.channel(&playback.outline().values, &name)?;
        let (picture, values) = output::watched(|job| {
            let mut painted: Option<(Picture, Option<(ColorBar, ValueColors)>)> = None;
            let take = |_: usize, shown: &FilmPicture| {
                let picture: &Picture = &shown.picture;
                painted = Some(match colored {
                    None => (picture.clone(), None),
                    Some(channel) => {
                        let values = shown.values();
                        let in_view = shown_values(picture, &values, channel);
                        let value = self.values.shown(&values.channels, channel, &in_view, &name)?;
                        (values.colored(picture, channel, &value.colors), Some((value.bar, value.colors)))
                    }
                });
                Ok(())
            };
            let width = self.orthographic;
            film::paint(&source, &vantage, width, &mut renderer, &settings, job, take)?;
            painted.ok_or_else(|| Error::invalid("figure", "has no picture"))
        })?;
        output::warn(renderer.notice().map(str::to_owned).as_slice());
        output::warn(&playback.store().damage());
        Ok(app::figure_of_rendered(&picture, &camera, self.orthographic, values, options))
    }

    /// From where a store is shown.
    fn viewpoint(&self, info: &StoreInfo, address: &ViewAddress, place: &Path) -> Result<Camera> {
        let name = self.camera.as_deref().or(address.camera.as_deref());
        let mut camera = info.cameras[camera_named(&info.cameras, name, place)?].clone();
        if let Some((pose, _)) = address.pose().filter(|_| self.camera.is_none()) {
            camera.world_from_camera = pose;
            camera.intrinsics = address.lens.unwrap_or(camera.intrinsics);
        }
        Ok(camera)
    }
}

/// The camera of a name, or the first.
fn camera_named(cameras: &[Camera], name: Option<&str>, place: &Path) -> Result<usize> {
    let none = |what: String| Error::invalid(place.display(), what);
    let Some(name) = name else {
        return if cameras.is_empty() { Err(none("has no camera".to_owned())) } else { Ok(0) };
    };
    let found = cameras.iter().position(|camera| camera.name == name);
    found.ok_or_else(|| none(format!("has no camera '{name}' (overlook info lists them)")))
}

/// The same view in so many columns.
fn of_columns(camera: &Camera, columns: u32) -> Camera {
    let lens = camera.intrinsics;
    let factor = f64::from(columns) / f64::from(lens.width);
    let rows = (f64::from(lens.height) * factor).round().max(1.0) as u32;
    Camera { intrinsics: lens.resized(columns, rows), ..camera.clone() }
}
