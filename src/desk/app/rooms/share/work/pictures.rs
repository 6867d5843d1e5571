//! Figures for print: of a source picture with its overlay, of the live view, and of a rendered viewpoint.

use std::path::Path;
use std::sync::Arc;

use egui::{Color32, ColorImage};
use image::RgbaImage;

use crate::app::colormap::dimmed;
use crate::app::model::look::Display;
use crate::app::model::picture::{ColorBy, LiveKey, Overlay, PixelSource, SourceKey};
use crate::app::model::{Same, median_depth};
use crate::app::rooms::compare::state::{CompareKey, ComparisonFigure};
use crate::app::rooms::compare::work::{self, Comparer};
use crate::app::rooms::files::work::chart_bytes;
use crate::app::rooms::live::work::image as live_image;
use crate::app::rooms::share::work::figure_meaning::{self, Meaning, of_live, of_source};
use crate::app::rooms::share::{ComparedFilm, FilmLook};
use crate::app::rooms::source::work::source_picture;
use crate::app::theme::Tokens;
use crate::app::work::differing_samples::differing;
use crate::app::work::shown_samples::CameraFilter;
use crate::text::count_of;
use crate::ways_out::figure::{FigureOptions, Unit};
use overlook_engine::capture::{Camera, Capture, Intrinsics};
use overlook_engine::color::{linear_from_srgb, srgb8_from_linear};
use overlook_engine::error::{Error, Result};
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::preprocess::{self, inspect_frame};
use overlook_engine::render::film::{self, FilmSource};
use overlook_engine::render::{NO_IMAGE, Picture, Renderer, ValueColors, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::Settings;
use overlook_engine::whole_file;
use overlook_lab::chart::{ColorBar, Figure, ScaleBar, SideNames};

/// The middle of a picture, which its scale bar is valid for: so many parts of each side lie on either side of it.
const AROUND_MIDDLE: usize = 3;

/// Brightness of the picture below marks, beside its own.
const FAINT: f32 = 0.8;

const OUT_OF_REACH: &str = "the picture is out of reach; try again once the view rests";

/// A figure of what one camera recorded at a frame, with an overlay. Verdicts are those of the whole capture by `settings`.
pub(crate) fn of_camera(
    capture: &Capture,
    [camera, frame]: [usize; 2],
    overlay: Overlay,
    settings: &Settings,
    options: &FigureOptions,
    job: &Job,
) -> Result<Figure> {
    let inspection = if overlay.needs_verdicts() {
        let scan = preprocess::scan(capture, settings, job)?;
        Some(Same(inspect_frame(capture, Some(&scan), settings, frame, job)?.into()))
    } else {
        None
    };
    let key = SourceKey {
        scene: 0,
        camera,
        frame,
        overlay,
        against: None,
        isolated: None,
        display: Display::default(),
        dark: options.is_dark,
        inspection,
    };
    of_source_picture(&capture.cameras, Ok(capture), &key, options)
}

/// A figure of a source picture; the capture is read where nothing was inspected.
pub(crate) fn of_source_picture(
    cameras: &[Camera],
    capture: Result<&Capture>,
    key: &SourceKey,
    options: &FigureOptions,
) -> Result<Figure> {
    let key = SourceKey { dark: options.is_dark, ..key.clone() };
    let frame = match &key.inspection {
        Some(inspection) => inspection.cameras[key.camera].frame.clone(),
        None => capture?.frame(key.camera, key.frame)?,
    };
    let shown = source_picture(&key, &frame);
    let meaning = of_source(key.overlay, &shown.legend, cameras, key.dark, options.unit);
    let lens = cameras[key.camera].intrinsics;
    let scale = scale_bar(&lens, &frame.inverse_depth, options.unit);
    Ok(put_together(opaque(&shown.image), meaning, Some(scale), options))
}

/// A figure of the live view, whose key has the size of the figure; `Unsupported` where the picture stays on the graphics card.
pub(crate) fn of_live_view(key: &LiveKey, options: &FigureOptions, job: &Job) -> Result<Figure> {
    let mut renderer = Renderer::new();
    let painted = live_image::paint(&mut renderer, &mut CameraFilter::default(), key, job)?;
    let PixelSource::InMemory { image, rendered } = &painted.pixels else {
        return Err(Error::unsupported("figure", OUT_OF_REACH));
    };
    let meaning = of_live(key, rendered, painted.sky_holes);
    let scale = scale_bar(&key.vantage.camera.intrinsics, &rendered.inverse_depth, options.unit);
    Ok(put_together(opaque(image), meaning, Some(scale), options))
}

/// A figure of the live view in gray, with the samples of its frame that were kept `before` a change of settings alone, and those that are
/// kept `now` alone.
pub(crate) fn of_change(
    key: &LiveKey,
    [before, now]: [&SampleSet; 2],
    options: &FigureOptions,
    job: &Job,
) -> Result<Figure> {
    let painted = live_image::paint(&mut Renderer::new(), &mut CameraFilter::default(), key, job)?;
    let PixelSource::InMemory { image, rendered } = &painted.pixels else {
        return Err(Error::unsupported("figure", OUT_OF_REACH));
    };
    let camera = &key.vantage.camera;
    let marks = differing([before, now], camera, Some((rendered, camera)), |_| Color32::WHITE);
    let tokens = Tokens::of(options.is_dark);
    let classes = [(tokens.contradicted, "dropped"), (tokens.confirmed, "brought back")];
    let mut shown = ColorImage::new(image.size, image.pixels.iter().map(|own| dimmed(*own, FAINT)).collect());
    let mut legend = Vec::new();
    for ((marks, count), (color, name)) in marks.into_iter().zip(classes) {
        for (pixel, mark) in shown.pixels.iter_mut().zip(marks.pixels) {
            *pixel = if mark == Color32::TRANSPARENT { *pixel } else { color };
        }
        legend.push(figure_meaning::entry(color, format!("{name}, {}", count_of(count, "sample"))));
    }
    let scale = scale_bar(&camera.intrinsics, &rendered.inverse_depth, options.unit);
    let meaning = Meaning { legend, color_bar: None };
    Ok(put_together(opaque(&shown), meaning, Some(scale), options))
}

/// A figure of a comparison as its view shows it.
pub(crate) fn of_comparison(compared: &ComparisonFigure, options: &FigureOptions) -> Figure {
    let picture = opaque(&work::image(compared));
    put_together(picture, figure_meaning::of_comparison(compared), None, options)
}

/// A figure of a rendered picture, through a lens, or orthographic with so many world units from edge to edge, with what its colors mean.
pub(crate) fn of_rendered(
    picture: &Picture,
    camera: &Camera,
    orthographic: Option<f64>,
    values: Option<(ColorBar, ValueColors)>,
    options: &FigureOptions,
) -> Figure {
    let (width, height) = picture.color.size();
    let pixels = RgbaImage::from_fn(width as u32, height as u32, |x, y| {
        let at = (x as usize, y as usize);
        let [red, green, blue] = picture.color[at].map(srgb8_from_linear);
        let alpha = (255.0 * picture.alpha(at)).round() as u8;
        image::Rgba([red, green, blue, alpha])
    });
    let scale = match orthographic {
        Some(width) => {
            ScaleBar { unit_share: 1.0 / width, unit: options.unit.name().to_owned(), distance: None }
        }
        None => scale_bar(&camera.intrinsics, &picture.inverse_depth, options.unit),
    };
    let meaning = values.map(|(bar, colors)| figure_meaning::of_values(bar, &colors));
    put_together(pixels, meaning.unwrap_or_default(), Some(scale), options)
}

/// Writes a figure in the format that the ending of its path names. The file takes its name once it is whole. Gives its bytes.
///
/// # Errors
/// `Invalid` for another ending, and those of drawing and writing.
pub(crate) fn write(path: &Path, figure: &Figure) -> Result<u64> {
    let bytes = chart_bytes(path, &figure.chart()?)?;
    whole_file::write_all(path, &bytes)?;
    Ok(bytes.len() as u64)
}

fn put_together(
    picture: RgbaImage,
    Meaning { legend, color_bar }: Meaning,
    scale: Option<ScaleBar>,
    options: &FigureOptions,
) -> Figure {
    Figure {
        picture,
        legend: if options.has_legend { legend } else { Vec::new() },
        color_bar: color_bar.filter(|_| options.has_legend),
        scale: scale.filter(|_| options.has_scale_bar),
        caption: options.caption.clone(),
        columns: options.columns(),
        dots_per_inch: options.dots_per_inch,
        type_points: options.type_points,
        is_dark: options.is_dark,
    }
}

/// The length of a unit at the distance of what the middle of a picture shows.
fn scale_bar(lens: &Intrinsics, inverse_depth: &Grid<f32>, unit: Unit) -> ScaleBar {
    if lens.is_orthographic() {
        let unit_share = lens.fx / f64::from(lens.width);
        return ScaleBar { unit_share, unit: unit.name().to_owned(), distance: None };
    }
    let (width, height) = inverse_depth.size();
    let middle = |side: usize| side / AROUND_MIDDLE..(side - side / AROUND_MIDDLE).max(1);
    let depths = middle(height).flat_map(|y| middle(width).map(move |x| inverse_depth[(x, y)]));
    let mut depths: Vec<f32> = depths.collect();
    if !depths.iter().any(|depth| *depth > 0.0) {
        depths = inverse_depth.as_slice().to_vec();
    }
    let distance = median_depth(&depths);
    ScaleBar {
        unit_share: lens.fx / distance / f64::from(lens.width),
        unit: unit.name().to_owned(),
        distance: Some(distance),
    }
}

fn opaque(image: &ColorImage) -> RgbaImage {
    let [width, height] = image.size;
    RgbaImage::from_fn(width as u32, height as u32, |x, y| {
        let color: Color32 = image.pixels[y as usize * width + x as usize];
        image::Rgba([color.r(), color.g(), color.b(), u8::MAX])
    })
}

/// Columns and rows of its pictures, names below them included.
///
/// # Errors
/// `Invalid` where there is nothing to be seen from the viewpoint.
pub(crate) fn size(compared: &ComparedFilm, first: &Vantage) -> Result<[usize; 2]> {
    let key = CompareKey { vantage: first.clone(), ..compared.key.clone() };
    let (columns, rows) = Comparer::size(&key)?;
    Ok([columns, rows + SideNames::rows(columns)])
}

/// Paints both sides at every vantage, and passes the pictures on with their index.
///
/// # Errors
/// `Invalid` where a side cannot be shown at a place, or the two differ in size; those of rendering and of `take`; `Cancelled`.
pub(crate) fn paint(
    compared: &ComparedFilm,
    source: &FilmSource,
    vantages: &[Vantage],
    pictures_a_second: f64,
    threads: &Arc<rayon::ThreadPool>,
    job: &Job,
    mut take: impl FnMut(usize, &Picture) -> Result<()>,
) -> Result<()> {
    let mut comparer = Comparer::new(threads.clone());
    let Some(first) = vantages.first() else { return Ok(()) };
    let [width, _] = size(compared, first)?;
    // What stands still is painted once.
    let mut last: [Option<(&Vantage, Arc<Picture>)>; 2] = [None, None];
    let side = |side: usize, nth: usize| {
        let vantage = &vantages[nth];
        if let Some((_, picture)) = last[side].as_ref().filter(|(there, _)| *there == vantage) {
            return Ok(picture.clone());
        }
        let samples = Same(source.samples_for(vantage, false, job)?);
        let key = CompareKey { vantage: vantage.clone(), samples, whole: true, ..compared.key.clone() };
        let picture = Arc::new(comparer.picture(&key, side, job)?);
        last[side] = Some((vantage, picture.clone()));
        Ok(picture)
    };
    let names = SideNames::new(&compared.names, width)?;
    let take = |nth: usize, picture: &Picture, shown| take(nth, &names.below(picture, shown));
    film::paint_compared(compared.how, vantages.len(), pictures_a_second, width, job, side, take)
}

/// Paints every vantage in order, and passes the pictures on with their index: as they are displayed, or where `as_rendered` is true in
/// linear color, of the same samples.
///
/// # Errors
/// Those of reading, of rendering, of working out how samples agree, and of `take`; `Cancelled`.
pub(crate) fn paint_looked(
    look: &FilmLook,
    source: &FilmSource,
    vantages: &[Vantage],
    as_rendered: bool,
    renderer: &mut Renderer,
    job: &Job,
    mut take: impl FnMut(usize, &Picture) -> Result<()>,
) -> Result<()> {
    job.start("Rendering", vantages.len());
    let (mut filter, mut inspection) = (CameraFilter::default(), None);
    for (nth, vantage) in vantages.iter().enumerate() {
        job.check()?;
        inspection = inspection_at(look, vantage.frame, inspection)?;
        let key = LiveKey {
            samples: Same(source.samples_for(vantage, false, job)?),
            playback: None,
            vantage: vantage.clone(),
            inspection: inspection.clone().map(Same),
            ..look.key.clone()
        };
        let painted = live_image::paint(renderer, &mut filter, &key, job)?;
        let PixelSource::InMemory { image, rendered } = &painted.pixels else {
            return Err(Error::unsupported(
                "film",
                "its pictures stay on the GPU; set render.backend to cpu",
            ));
        };
        if as_rendered {
            take(nth, rendered)?;
        } else {
            take(nth, &displayed(&key, image, rendered))?;
        }
        job.advance(1);
    }
    Ok(())
}

/// How the samples of a frame agree with other cameras, where colors tell of that; `known` is that of the picture before.
fn inspection_at(
    look: &FilmLook,
    frame: usize,
    known: Option<Arc<FrameInspection>>,
) -> Result<Option<Arc<FrameInspection>>> {
    let capture = look.scene.capture().filter(|_| look.key.color_by == ColorBy::Agreement);
    let Some(capture) = capture else { return Ok(None) };
    if known.as_ref().is_some_and(|known| known.frame == frame) {
        return Ok(known);
    }
    // Its progress is none of the film.
    let own = Job::new();
    inspect_frame(capture, look.scan.as_deref(), &look.settings, frame, &own).map(Arc::new).map(Some)
}

/// A picture as the live view displays it, with alpha 0 where a transparent background shows.
fn displayed(key: &LiveKey, image: &ColorImage, rendered: &Picture) -> Picture {
    let mut picture = Picture { coverage: Vec::new(), ..rendered.clone() };
    let width = picture.color.width();
    for (index, pixel) in image.pixels.iter().enumerate() {
        let at = (index % width, index / width);
        if key.display.leaves_out(rendered, at) {
            (picture.inverse_depth[at], picture.image[at]) = (-1.0, NO_IMAGE);
            picture.color[at] = [0.0; 3];
            continue;
        }
        // What is not filled shows its hatching.
        picture.inverse_depth[at] = picture.inverse_depth[at].max(0.0);
        picture.color[at] = [pixel.r(), pixel.g(), pixel.b()].map(|c| linear_from_srgb(f32::from(c) / 255.0));
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ways_out::figure::{FIGURE, FigureWidth};
    use overlook_engine::demo::{Demo, DemoSpec};

    #[test]
    fn every_overlay_of_a_camera_becomes_a_figure_in_every_format() {
        let demo = Demo::new(&DemoSpec::new("orrery").size((48, 36)).frames(2)).unwrap();
        let settings = Settings::default();
        let capture = demo.capture(&settings.capture);
        let options = FigureOptions {
            width: FigureWidth::Pixels(480),
            caption: "A caption.".to_owned(),
            ..FigureOptions::default()
        };
        let folder = tempfile::tempdir().unwrap();
        for (overlay, name, _) in Overlay::ALL {
            let figure = of_camera(&capture, [1, 1], overlay, &settings, &options, &Job::new()).unwrap();
            let says_something = !figure.legend.is_empty() || figure.color_bar.is_some();
            assert_eq!(says_something, overlay != Overlay::Color, "{name}");
            for (ending, begins) in FIGURE.endings.iter().zip([&b"%PDF"[..], b"<svg", b"\x89PNG"]) {
                let path = folder.path().join(format!("figure.{ending}"));
                let bytes = write(&path, &figure).unwrap();
                let written = std::fs::read(&path).unwrap();
                assert!(written.starts_with(begins) && written.len() as u64 == bytes, "{name} {ending}");
            }
        }
        let figure = of_camera(&capture, [0, 0], Overlay::Color, &settings, &options, &Job::new()).unwrap();
        assert!(write(&folder.path().join("figure.jpg"), &figure).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "nothing else is left");
    }
}
