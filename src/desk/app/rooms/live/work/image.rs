//! Paints the picture of the live view.

use std::sync::Arc;
use std::time::Instant;

use egui::{Color32, ColorImage};
use glam::DVec2;
use rayon::prelude::*;

use crate::app::camera_cues;
use crate::app::colormap::{agreeing, dimmed, diverging, mix, opaque};
use crate::app::model::Message;
use crate::app::model::look::Display;
use crate::app::model::picture::{
    CarriedLook, CarryKey, ColorBy, HoleDisplay, LiveKey, LivePicture, PixelSource, RATIO_RANGE,
};
use crate::app::theme::Tokens;
use crate::app::work::develop::{background_at, displayed, histogram_of};
use crate::app::work::shown_samples::CameraFilter;
use overlook_engine::capture::sighting::tolerances::PAINTED_SAMPLE;
use overlook_engine::capture::sighting::{Sighting, compare};
use overlook_engine::error::Result;
use overlook_engine::grid::Grid;
use overlook_engine::job::Job;
use overlook_engine::preprocess::agreement::SampleAgreement;
use overlook_engine::render::gpu::HolePattern;
use overlook_engine::render::{
    BACKGROUND_COLOR, NO_IMAGE, Painter, Picture, PictureCarrier, RenderStats, Renderer, ScreenPicture,
    ValueColors, WindowPicture, background_holes, output,
};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Antialias, RenderSettings};

/// Frames whose samples are sent to a GPU in advance.
const FRAMES_AHEAD: usize = 2;

/// Brightness of a picture in gray, under colors that tell of its samples.
const DIMMED: f32 = 0.9;

/// Opacity of the two stripes over filled holes: what fills them can be made out between the stripes.
const HATCHING: [f32; 2] = [0.35, 0.85];

/// Renders and colors the picture of `key`.
pub(crate) fn paint(
    renderer: &mut Renderer,
    filter: &mut CameraFilter,
    key: &LiveKey,
    job: &Job,
) -> Result<LivePicture> {
    let started = Instant::now();
    let next = key.vantage.frame + 1;
    let samples = match &key.playback {
        None => key.samples.0.clone(),
        Some(playback) => playback.seen_from(&key.vantage.camera, key.vantage.frame, job)?,
    };
    let samples = filter.of(samples, &key.cameras);
    let (shown, _) = rayon::join(
        || shown(renderer, &samples, key, job),
        // Errors of reading ahead are reported when the frame is shown.
        || {
            let ahead = next..next + FRAMES_AHEAD;
            key.playback.as_ref().map(|playback| playback.read_ahead_from(&key.vantage.camera, ahead, job))
        },
    );
    let (mut histogram, mut sky_holes) = (None, 0);
    let (size, pixels, stats) = match shown? {
        (WindowPicture::OnAdapter(texture), stats) => {
            ([texture.width() as usize, texture.height() as usize], PixelSource::OnAdapter(texture), stats)
        }
        (WindowPicture::InMemory(rendered), stats) => {
            let pixels = colored(&rendered, key);
            sky_holes = background_holes(&rendered, &samples, &key.vantage)?;
            let shows_picture = key.color_by == ColorBy::Picture && key.quality.is_none();
            histogram = shows_picture.then(|| histogram_of(&rendered.color, &pixels, |color| *color));
            let size = [pixels.width(), pixels.height()];
            let image = Arc::new(ColorImage::new(size, pixels.into_vec()));
            (size, PixelSource::InMemory { image, rendered }, stats)
        }
    };
    renderer.prefetch(&samples, next..next + FRAMES_AHEAD);
    Ok(LivePicture {
        samples,
        size,
        pixels,
        histogram,
        stats,
        sky_holes,
        took: started.elapsed(),
        painter: renderer.painter().cloned().unwrap_or_else(Painter::cpu),
        notice: renderer.notice().map(str::to_owned),
        damage: key.playback.as_ref().map_or_else(Vec::new, |playback| playback.store().damage()),
    })
}

/// Renders into memory if the view is at rest or is colored by samples, else wherever that is fastest.
fn shown(
    renderer: &mut Renderer,
    samples: &Arc<SampleSet>,
    key: &LiveKey,
    job: &Job,
) -> Result<(WindowPicture, RenderStats)> {
    if key.in_motion && key.color_by == ColorBy::Picture {
        let tokens = Tokens::of(key.dark);
        let colors = [tokens.hole, tokens.hole_stripe].map(|color| [color.r(), color.g(), color.b()]);
        // Other displays of color and of filled holes are made here.
        let is_plain = key.display == Display::default() && key.holes == HoleDisplay::Filled;
        let holes = is_plain.then(|| HolePattern { colors, stripe: key.stripe() as u32 });
        return renderer.show(samples, &key.vantage, &key.settings, holes.as_ref(), job);
    }
    let antialias = if key.in_motion { Antialias::Off } else { key.settings.antialias };
    let settings = RenderSettings { antialias, ..key.settings.clone() };
    let (picture, stats) = renderer.render(samples, &key.vantage, &settings, job)?;
    Ok((WindowPicture::InMemory(picture), stats))
}

fn colored(picture: &Picture, key: &LiveKey) -> Grid<Color32> {
    let tokens = Tokens::of(key.dark);
    let stripe = key.stripe();
    let agreements = agreements(key);
    let values = values(key, picture);
    let color = |x: usize, y: usize| {
        let image = picture.image[(x, y)];
        let shows_sky = key.color_by == ColorBy::Picture && picture.inverse_depth[(x, y)] == 0.0;
        let background = background_at(key.display.background, x, y).filter(|_| shows_sky);
        let own = background.unwrap_or_else(|| displayed(&key.display, picture.color[(x, y)]));
        if image == NO_IMAGE {
            let nth = (x + y) / stripe % 2;
            let pattern = [tokens.hole, tokens.hole_stripe][nth];
            let is_filled = picture.shows((x, y));
            return match (key.holes, key.color_by) {
                _ if !is_filled => pattern,
                (HoleDisplay::Hatched, _) => mix(own, pattern, HATCHING[nth]),
                (HoleDisplay::Filled, ColorBy::Picture) => own,
                // These colors describe samples, and this pixel has none: one color, so that figures have one background.
                (_, ColorBy::Value) if values.is_some() => opaque(BACKGROUND_COLOR),
                _ => dimmed(own, DIMMED),
            };
        }
        let source = &key.samples.images[image as usize];
        match key.color_by {
            ColorBy::Picture => own,
            ColorBy::Camera => {
                mix(dimmed(own, DIMMED), camera_cues::color_at(source.camera as usize, x, y), 0.7)
            }
            ColorBy::Agreement => match agreement_at(key, &agreements, picture, x, y) {
                Some(found) => agreeing(own, found, tokens),
                None => dimmed(own, DIMMED),
            },
            ColorBy::Span => {
                let frames = key.samples.frame_numbers.len();
                let share = if source.span.len() >= frames { 0.55 } else { 0.7 };
                mix(dimmed(own, DIMMED), tokens.of_span(source.span.len(), frames), share)
            }
            ColorBy::Value => values.as_ref().map_or(own, |(values, colors)| {
                opaque(colors.color_at(values[(x, y)], picture.inverse_depth[(x, y)]))
            }),
            ColorBy::SamplingRate => {
                let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let inverse_depth = f64::from(picture.inverse_depth[(x, y)]);
                diverging(log2_spacing(key, source.camera as usize, pixel, inverse_depth) / RATIO_RANGE)
            }
        }
    };
    let (width, height) = picture.color.size();
    let mut colors = vec![Color32::default(); width * height];
    let rows = colors.par_chunks_mut(width.max(1)).enumerate();
    rows.for_each(|(y, row)| row.iter_mut().enumerate().for_each(|(x, pixel)| *pixel = color(x, y)));
    Grid::from_vec(width, height, colors)
}

/// The value of each pixel that the picture is colored by, and its colors; `None` where it is colored otherwise, or there are no values.
fn values(key: &LiveKey, picture: &Picture) -> Option<(Grid<f32>, ValueColors)> {
    let look = Some(key.display.values).filter(|_| key.color_by == ColorBy::Value)?;
    let (channel, meaning) = look.channel_of(&key.samples.values)?;
    let colors = look.colors(meaning).ok()?;
    let shown = output::PictureValues::of(&key.samples, &key.vantage, picture);
    let (width, height) = picture.image.size();
    Some((Grid::from_vec(width, height, shown.values.channel(channel).collect()), colors))
}

/// How the samples of a camera agree with other cameras; `None` for one without a sample in the picture.
type CameraAgreement = Option<Arc<Grid<Option<SampleAgreement>>>>;

fn agreements(key: &LiveKey) -> Vec<CameraAgreement> {
    let inspection = key.inspection.as_ref().filter(|_| key.color_by == ColorBy::Agreement);
    inspection.map_or_else(Vec::new, |inspection| {
        let shown = |camera| key.samples.images.iter().any(|image| image.camera as usize == camera);
        let of_camera = |camera| shown(camera).then(|| inspection.agreement(camera));
        (0..inspection.cameras.len()).map(of_camera).collect()
    })
}

/// How the sample that a pixel shows agrees with other cameras; `None` if that is not known.
fn agreement_at(
    key: &LiveKey,
    agreements: &[CameraAgreement],
    picture: &Picture,
    x: usize,
    y: usize,
) -> Option<SampleAgreement> {
    let inspection = key.inspection.as_ref()?;
    let camera = key.samples.images[picture.image[(x, y)] as usize].camera as usize;
    let agreement = agreements.get(camera)?.as_ref()?;
    let there = recorded_at(key, picture, x, y).filter(|([x, y], depth)| {
        let recorded = inspection.cameras[camera].frame.inverse_depth.get(*x, *y);
        recorded.is_some_and(|recorded| compare(*recorded, *depth, PAINTED_SAMPLE) == Sighting::Same)
    });
    let [x, y] = match there {
        Some((place, _)) => place,
        None => output::pick(&key.samples, &key.vantage, picture, x, y).map(|picked| [picked.x, picked.y])?,
    };
    *agreement.get(x, y)?
}

/// Column, row and planar depth of a pixel's point in the camera that recorded its sample; `None` at infinity and outside that
/// camera's picture.
fn recorded_at(key: &LiveKey, picture: &Picture, x: usize, y: usize) -> Option<([usize; 2], f64)> {
    let inverse_depth = f64::from(picture.inverse_depth[(x, y)]);
    let image = &key.samples.images[picture.image[(x, y)] as usize];
    let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
    let point = (inverse_depth > 0.0).then(|| key.vantage.camera.unproject(pixel, 1.0 / inverse_depth))?;
    let (at, depth) = key.samples.cameras[image.camera as usize].project(point)?;
    (at.x >= 0.0 && at.y >= 0.0).then_some(([at.x as usize, at.y as usize], depth))
}

/// log₂ of the distance between samples over the distance between the view's pixels, both across the line of sight.
fn log2_spacing(key: &LiveKey, camera: usize, pixel: DVec2, inverse_depth: f64) -> f32 {
    let vantage = &key.vantage.camera;
    let source = &key.samples.cameras[camera];
    let focal = source.intrinsics.fx / vantage.intrinsics.fx;
    if inverse_depth <= 0.0 {
        return -(focal.log2() as f32);
    }
    let point = vantage.unproject(pixel, 1.0 / inverse_depth);
    if source.intrinsics.is_orthographic() {
        return (inverse_depth / focal).log2() as f32;
    }
    let source_depth = (point - source.position_in_world()).dot(source.forward_in_world()).max(1e-9);
    (source_depth * inverse_depth / focal).log2() as f32
}

/// Answers a request; without a picture where nothing of it is in view, or its pixels cannot be read.
pub(crate) fn carry(carrier: &mut PictureCarrier, key: CarryKey) -> Message {
    let carried = match &key.picture.pixels {
        PixelSource::OnAdapter(_) => None,
        PixelSource::InMemory { image, rendered } => {
            let picture = ScreenPicture {
                colors: bytemuck::cast_slice(&image.pixels),
                inverse_depth: &rendered.inverse_depth,
                camera: &key.from,
            };
            carrier.carry(&picture, &key.to)
        }
    };
    let carried = carried.map(|carried| {
        let (width, height) = carried.inverse_depth.size();
        let pixels =
            carried.colors.iter().map(|[r, g, b, a]| Color32::from_rgba_premultiplied(*r, *g, *b, *a));
        let image = ColorImage::new([width, height], pixels.collect());
        CarriedLook { image: Arc::new(image), inverse_depth: carried.inverse_depth }
    });
    Message::LiveCarried { key, carried }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::model::Same;
    use crate::app::model::look::ShownCameras;
    use glam::DVec3;
    use overlook_engine::capture::{Camera, Intrinsics};
    use overlook_engine::render::Vantage;
    use overlook_engine::samples::{DepthPlane, SampleImage};
    use overlook_engine::settings::Settings;

    /// A camera four units from the origin, and a vantage at `distance`.
    fn key(distance: f64) -> LiveKey {
        let intrinsics = Intrinsics::from_horizontal_angle(64, 48, 1.0);
        let camera = |distance: f64| {
            Camera::look_at("c", intrinsics, DVec3::new(0.0, -distance, 0.0), DVec3::ZERO, DVec3::Z)
        };
        let samples = SampleSet {
            name: "test".into(),
            cameras: vec![camera(4.0)],
            frame_numbers: vec![0],
            up_in_world: DVec3::Z,
            settings: Settings::default(),
            images: Vec::new(),
            values: Vec::new(),
        };
        LiveKey {
            scene: 1,
            samples: Same(Arc::new(samples)),
            playback: None,
            vantage: Vantage { camera: camera(distance), frame: 0 },
            settings: RenderSettings::default(),
            color_by: ColorBy::Picture,
            inspection: None,
            holes: HoleDisplay::Filled,
            cameras: ShownCameras::default(),
            display: Display::default(),
            dark: true,
            in_motion: false,
            quality: None,
            per_coarse_pixel: 1.0,
        }
    }

    #[test]
    fn filled_holes_are_shown_and_gray_among_colors_of_samples_and_hatched_on_demand() {
        let mut key = key(1.0);
        let mut picture = Picture {
            color: Grid::filled(1, 1, [1.0, 0.0, 0.0]),
            inverse_depth: Grid::filled(1, 1, 0.5),
            image: Grid::filled(1, 1, NO_IMAGE),
            fronts: Vec::new(),
            coverage: Vec::new(),
        };
        let (red, hatched) = (Color32::from_rgb(255, 0, 0), Tokens::of(true).hole);
        assert_eq!(colored(&picture, &key)[(0, 0)], red);
        key.color_by = ColorBy::Camera;
        assert_eq!(colored(&picture, &key)[(0, 0)], dimmed(red, DIMMED));
        for (color_by, ..) in ColorBy::ALL {
            key = LiveKey { color_by, holes: HoleDisplay::Hatched, ..key };
            assert_eq!(colored(&picture, &key)[(0, 0)], mix(red, hatched, HATCHING[0]));
        }
        picture.inverse_depth[(0, 0)] = -1.0;
        for (holes, ..) in HoleDisplay::ALL {
            key.holes = holes;
            assert_eq!(colored(&picture, &key)[(0, 0)], hatched, "there is nothing else to be shown");
        }
    }

    #[test]
    fn images_of_a_camera_that_is_off_are_others_in_their_place_and_stay_the_same_as_long_as_nothing_changes()
    {
        let image = |camera: u32| {
            Arc::new(SampleImage {
                camera,
                span: overlook_engine::samples::Span { start: 0, end: 1 },
                color: Vec::new(),
                depth: DepthPlane::default(),
                normal: None,
                doubtful: Vec::new(),
                tiles: Vec::new(),
                values: overlook_engine::capture::Values::default(),
            })
        };
        let samples =
            Arc::new(SampleSet { images: vec![image(0), image(1)], ..(**key(1.0).samples).clone() });
        let mut filter = CameraFilter::default();
        let all = filter.of(samples.clone(), &ShownCameras::default());
        assert!(Arc::ptr_eq(&all, &samples));
        let cameras = ShownCameras { solo: Some(1), ..ShownCameras::default() };
        let one = filter.of(samples.clone(), &cameras);
        let is_kept = |camera: usize| Arc::ptr_eq(&one.images[camera], &samples.images[camera]);
        assert!(one.images.len() == 2 && !is_kept(0) && is_kept(1));
        assert!(Arc::ptr_eq(&one, &filter.of(samples, &cameras)));
    }

    #[test]
    fn standing_twice_as_close_as_the_camera_halves_the_density_of_samples() {
        let key = LiveKey { color_by: ColorBy::SamplingRate, ..key(2.0) };
        let intrinsics = key.vantage.camera.intrinsics;
        let value = log2_spacing(&key, 0, DVec2::new(intrinsics.cx, intrinsics.cy), 0.5);
        assert!((value - 1.0).abs() < 1e-6, "{value}");
    }
}
