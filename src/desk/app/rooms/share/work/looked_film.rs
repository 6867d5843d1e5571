//! The pictures of a film that shows what the live view shows: colors that tell of samples, hatched holes, without hidden cameras.

use std::sync::Arc;

use crate::app::model::Same;
use crate::app::rooms::live::model::{LiveKey, PixelSource};
use crate::app::rooms::live::work::image as live_image;
use crate::app::rooms::live::work::shown_samples::CameraFilter;
use crate::app::rooms::share::model::FilmLook;
use overlook_engine::color::linear_from_srgb;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::preprocess::inspect::FrameInspection;
use overlook_engine::preprocess::inspect_frame;
use overlook_engine::render::film::FilmSource;
use overlook_engine::render::{NO_IMAGE, Picture, Renderer, Vantage};

/// Paints every vantage in order, and passes the pictures on with their index: as they are displayed, or where `as_rendered` is true in
/// linear color, of the same samples.
///
/// # Errors
/// Those of reading, of rendering, of working out how samples agree, and of `take`; `Cancelled`.
pub(crate) fn paint(
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
    let Some(source) = &look.agreement else { return Ok(None) };
    if known.as_ref().is_some_and(|known| known.frame == frame) {
        return Ok(known);
    }
    // Its progress is none of the film.
    let own = Job::new();
    let capture = source.scene.source()?;
    inspect_frame(capture, source.scan.as_deref(), &source.settings, frame, &own).map(Arc::new).map(Some)
}

/// A picture as the live view displays it, with alpha 0 where a transparent background shows.
fn displayed(key: &LiveKey, image: &egui::ColorImage, rendered: &Picture) -> Picture {
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
