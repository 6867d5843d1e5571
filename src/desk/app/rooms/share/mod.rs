//! Everything that leaves the window: pages, splats, points, films and figures.

pub(crate) mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use std::sync::Arc;

use crate::app::model::picture::{ColorBy, HoleDisplay, LiveKey};
use crate::app::model::purpose::FigureOf;
use crate::app::model::same::Same;
use crate::app::model::scene::OpenScene;
use crate::app::model::state::State;
use crate::app::model::text::{bytes, count_of, significant};
use crate::app::model::ways_out::{ShareOptions, ShareWay, SharedPictures};
use crate::app::rooms::compare::state::{CompareKey, CompareVantage};
use crate::app::rooms::share::state::{ShareFacts, SharePreviewKey};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::PreparedScan;
use overlook_engine::render::Vantage;
use overlook_engine::render::film::FilmComparison;
use overlook_engine::samples::are_far_from_origin;
use overlook_engine::settings::Settings;
use overlook_engine::splats::{SplatFormat, SplatSky};

/// Pictures along a camera path as the live view shows them, where that is not the plain picture.
pub(crate) struct FilmLook {
    /// What the live view shows; its samples and its viewpoint are those of each picture in turn.
    pub key: LiveKey,
    /// What is asked how samples agree at each frame, where colors tell of that.
    pub agreement: Option<AgreementSource>,
}

/// What samples are asked of how they agree with other cameras.
pub(crate) struct AgreementSource {
    pub scene: Arc<OpenScene>,
    pub scan: Option<Arc<PreparedScan>>,
    pub settings: Settings,
}

/// A comparison that is filmed.
pub(crate) struct ComparedFilm {
    pub how: FilmComparison,
    /// What is compared; its viewpoint is that of each picture in turn.
    pub key: CompareKey,
    /// Names of its sides.
    pub names: [String; 2],
}

/// How long a film of a single frame from one viewpoint is, seconds.
const STILL_SECONDS: f32 = 4.0;

impl State {
    /// How many pictures a film of what is chosen in the dialog has.
    pub(crate) fn film_pictures(&self) -> usize {
        let along_path = self.doc.path.pictures();
        if along_path > 0 || self.share.options.compares.is_none() || self.doc.scene.is_none() {
            return along_path;
        }
        self.filmed_frames().len()
    }

    /// The frames of a film from one viewpoint: those that are played; a single one for some seconds.
    fn filmed_frames(&self) -> Vec<usize> {
        let [first, last] = self.timeline.played(self.frame_count());
        if first < last {
            return (first..=last).collect();
        }
        vec![first; (STILL_SECONDS * self.timeline.frames_per_second).ceil() as usize]
    }

    /// The place of each picture of a film: along the camera path, or where there is none at every played frame.
    pub(crate) fn film_vantages(&self) -> Vec<Vantage> {
        let (size, frames) = (self.export_size(), self.frame_count());
        match self.live_camera(size) {
            Some(camera) if self.doc.path.pictures() == 0 && self.share.options.compares.is_some() => {
                let there = |frame| Vantage { camera: camera.clone(), frame };
                self.filmed_frames().into_iter().map(there).collect()
            }
            _ => self.doc.path.vantages(size, frames),
        }
    }

    /// What the live view shows in place of the plain picture of all samples, in words; `None` where it shows that.
    pub(crate) fn film_look(&self) -> Option<String> {
        let colored = ColorBy::ALL.iter().find(|(color_by, ..)| *color_by == self.live.color_by);
        let colored = colored.filter(|(color_by, ..)| *color_by != ColorBy::Picture);
        let hidden = self.doc.scene.as_ref().map_or(0, |scene| {
            (0..scene.cameras.len()).filter(|camera| !self.live.cameras.shows(*camera)).count()
        });
        let parts = [
            colored.map(|(_, name, _)| format!("colored by {}", name.to_lowercase())),
            match self.live.holes {
                HoleDisplay::Filled => None,
                HoleDisplay::Hatched => Some("with holes hatched".to_owned()),
                HoleDisplay::Dimmed => Some("dimmed far from samples".to_owned()),
            },
            (hidden > 0).then(|| format!("without {}", counted(hidden, "hidden camera"))),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// What the live view shows, as it is painted at rest in so many columns and rows, with holes as on dark or light ground; `None`
    /// while it has no picture.
    pub(crate) fn live_key(&self, size: [u32; 2], dark: bool) -> Option<LiveKey> {
        let key = &self.doc.live_shown.as_ref()?.key;
        Some(LiveKey {
            vantage: Vantage { camera: self.live_camera(size)?, frame: self.timeline.frame },
            settings: self.settings.render.clone(),
            dark,
            in_motion: false,
            quality: None,
            per_coarse_pixel: f64::from(size[0]) / f64::from(self.live.size[0].max(1)),
            ..key.clone()
        })
    }

    /// How pictures along the camera path look, where not plain.
    pub(crate) fn filmed_look(&self) -> Option<FilmLook> {
        self.film_look()?;
        let key = self.live_key(self.export_size(), self.dark)?;
        let scene = self.doc.scene.as_ref()?;
        let is_agreement = self.live.color_by == ColorBy::Agreement && scene.capture().is_some();
        let agreement = is_agreement.then(|| AgreementSource {
            scene: scene.clone(),
            scan: self.doc.scan.clone(),
            settings: self.settings.clone(),
        });
        let (color_by, holes) = (self.live.color_by, self.live.holes);
        let key =
            LiveKey { color_by, holes, cameras: self.live.cameras.clone(), display: self.display, ..key };
        Some(FilmLook { key, agreement })
    }

    /// The comparison that a film of what is chosen in the dialog shows, if it shows one.
    pub(crate) fn compared_film(&self) -> Option<ComparedFilm> {
        let (how, mut key) = (self.share.options.compares?, self.compare_key()?);
        if self.doc.path.pictures() > 0 {
            key.choice.from = CompareVantage::Live;
        }
        let names = key.choice.sides.map(|side| self.side_name(side));
        Some(ComparedFilm { how, key, names })
    }
}

/// Bytes of a page for each byte of its store, measured on built-in and recorded scenes (0.96 to 1.07), and of an empty page.
const PAGE_BY_STORE: f64 = 1.0;
const EMPTY_PAGE: f64 = 90e3;

/// Bytes of a figure without its picture.
const EMPTY_FIGURE: f64 = 15e3;

/// Splats of the dome that the sky becomes.
const DOME: u64 = 10_000;

/// Bytes of a point: place, normal, radius and color; and of one whose place is in double precision.
const POINT: [f64; 2] = [31.0, 43.0];

/// Bytes of a camera in a manifest.
const CAMERA: f64 = 850.0;

/// Bytes of a video for each byte of its pictures as PNG, measured with x264 at a quality like that of ours, on videos from one camera to
/// the next (0.06 to 0.1).
const FILM_BY_PNG: f64 = 0.075;

/// A size, and what it follows from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ShareSize {
    /// As in `about 2.4 MB`; what is missing where there is none.
    pub text: String,
    /// What it is the product of.
    pub reason: String,
}

impl ShareSize {
    fn about(size: f64, reason: String) -> Self {
        Self { text: format!("about {}", bytes(size.round() as u64)), reason }
    }

    /// The size of each picture, for a path that has no length yet.
    fn each(size: f64, unit: &str, [width, height]: [u32; 2]) -> Self {
        let Self { text, .. } = Self::about(size, String::new());
        Self { text: format!("{text} a {unit}"), reason: format!("of {width}×{height}") }
    }

    fn missing(text: &str) -> Self {
        Self { text: text.to_owned(), reason: String::new() }
    }
}

/// Bytes of a splat, measured; SPZ is compressed, and the others hold numbers as they are.
fn bytes_of_splat(format: SplatFormat) -> f64 {
    match format {
        SplatFormat::Ply => 68.0,
        SplatFormat::Spz => 12.0,
        SplatFormat::Glb => 64.0,
        SplatFormat::Usda => 178.0,
    }
}

/// Columns of a preview, pixels.
const PREVIEW_COLUMNS: u32 = 320;

impl State {
    /// The preview that the dialog shows of the chosen way, where a budget makes it coarser.
    pub(crate) fn share_preview_key(&self) -> Option<SharePreviewKey> {
        let (facts, options) = (self.share.facts.as_ref()?, &self.share.options);
        let share = match options.way {
            ShareWay::Page => {
                let most = options.page_at_most()? as f64 - EMPTY_PAGE;
                most / (facts.store_bytes * PAGE_BY_STORE).max(1.0)
            }
            ShareWay::Splats => {
                let most = options.splats_at_most()? as f64;
                let all = if options.format.holds_time() { facts.samples } else { facts.placed_here };
                most / all.max(1) as f64
            }
            _ => return None,
        };
        let [width, height] = self.live.size;
        let rows = (PREVIEW_COLUMNS * height / width.max(1)).max(1);
        let camera = self.live_camera([PREVIEW_COLUMNS, rows])?;
        let ready = self.is_whole_ready() && self.share.is_open && share < 1.0;
        let samples = self.whole_samples().filter(|_| ready)?;
        Some(SharePreviewKey {
            scene: self.doc.scene.clone()?,
            samples: Same(samples.clone()),
            vantage: Vantage { camera, frame: self.timeline.frame },
            settings: self.settings.render.clone(),
            share: share.max(0.0),
        })
    }

    /// The size of a way out, with the options of the dialog.
    pub(crate) fn share_size(&self, way: ShareWay) -> ShareSize {
        if self.doc.scene.is_none() {
            return ShareSize::missing("nothing open");
        }
        let needs_picture = matches!(way, ShareWay::Film | ShareWay::Pictures | ShareWay::Figure);
        if !self.is_whole_ready() && !needs_picture && way != ShareWay::Cameras {
            return ShareSize::missing("once it is pruned");
        }
        let Some(facts) = &self.share.facts else { return ShareSize::missing("measuring…") };
        let options = &self.share.options;
        match way {
            ShareWay::Page => page(facts, options),
            ShareWay::Splats => splats(facts, options),
            ShareWay::Film => self.film(facts),
            ShareWay::Pictures => self.pictures(facts, options),
            ShareWay::Figure => self.figure(facts, options),
            ShareWay::Points => self.points(facts, options),
            ShareWay::Cameras => {
                let cameras = self.doc.scene.as_ref().map_or(0, |scene| scene.cameras.len());
                ShareSize::about(cameras as f64 * CAMERA, counted(cameras, "camera"))
            }
            ShareWay::Store => {
                let each = facts.store_bytes / facts.samples.max(1) as f64;
                ShareSize::about(facts.store_bytes, samples_at(facts.samples, each))
            }
        }
    }

    fn film(&self, facts: &ShareFacts) -> ShareSize {
        let Some(picture) = facts.picture else { return ShareSize::missing("once the view rests") };
        let [width, height] = self.export_size();
        let size = |pictures: f64| {
            let pixels = f64::from(width) * f64::from(height) * pictures;
            pixels * picture.png_bytes / picture.pixels.max(1.0) * FILM_BY_PNG
        };
        let rate = f64::from(self.timeline.frames_per_second);
        match self.film_pictures() {
            0 => ShareSize::each(size(rate), "second", [width, height]),
            pictures => {
                let seconds = significant(pictures as f64 / rate);
                let reason = format!("{} of {width}×{height}, {seconds} s", counted(pictures, "picture"));
                ShareSize::about(size(pictures as f64), reason)
            }
        }
    }

    fn pictures(&self, facts: &ShareFacts, options: &ShareOptions) -> ShareSize {
        let Some(picture) = facts.picture else { return ShareSize::missing("once the view rests") };
        let is_path = options.pictures == SharedPictures::CameraPath;
        let is_compared = is_path && options.compares.is_some();
        let whole = if options.linear && !is_compared { picture.exr_bytes } else { picture.png_bytes };
        if let Some([width, height]) =
            options.picture_size.filter(|_| options.pictures == SharedPictures::View)
        {
            let size = whole / picture.pixels.max(1.0) * f64::from(width) * f64::from(height);
            return ShareSize::about(size, format!("a picture of {width}×{height}"));
        }
        if !is_path {
            return ShareSize::about(whole, "as the live view shows it".to_owned());
        }
        let [width, height] = self.export_size();
        let each = whole / picture.pixels.max(1.0) * f64::from(width) * f64::from(height);
        match self.film_pictures() {
            0 => ShareSize::each(each, "picture", [width, height]),
            pictures => {
                let reason = format!("{} of {width}×{height}", counted(pictures, "picture"));
                ShareSize::about(each * pictures as f64, reason)
            }
        }
    }

    /// Its picture as PNG takes nearly all of it.
    fn figure(&self, facts: &ShareFacts, options: &ShareOptions) -> ShareSize {
        let Some(picture) = facts.picture else { return ShareSize::missing("once the view rests") };
        let [width, height] = match options.figure_of {
            FigureOf::Live => self.figure_size(),
            FigureOf::Source => self
                .doc
                .source_shown
                .as_ref()
                .map_or([0; 2], |shown| shown.picture.size.map(|side| side as u32)),
            FigureOf::Compared => self.compared_figure().map_or([0; 2], |compared| {
                let [_, _, columns, rows] = compared.part();
                [columns, rows].map(|side| side as u32)
            }),
        };
        let size = picture.png_bytes / picture.pixels.max(1.0) * f64::from(width) * f64::from(height);
        let millimeters = significant(options.figure.width_mm());
        ShareSize::about(size + EMPTY_FIGURE, format!("{millimeters} mm, {} px wide", options.figure.columns))
    }

    fn points(&self, facts: &ShareFacts, options: &ShareOptions) -> ShareSize {
        let is_far = self.doc.scene.as_ref().is_some_and(|scene| are_far_from_origin(&scene.cameras));
        let each = POINT[usize::from(is_far)];
        let files = if options.points_of_all_frames { self.frame_count() } else { 1 };
        let points = facts.placed_here * files as u64;
        let mut reason = format!("{} of {each:.0} B", count_of(points, "point"));
        if files > 1 {
            reason = format!("{reason} in {}", counted(files, "file"));
        }
        ShareSize::about(points as f64 * each, reason)
    }
}

fn samples_at(samples: u64, each: f64) -> String {
    format!("{} of {} B", count_of(samples, "sample"), significant(each))
}

fn page(facts: &ShareFacts, options: &ShareOptions) -> ShareSize {
    let size = EMPTY_PAGE + facts.store_bytes * PAGE_BY_STORE;
    match options.page_at_most().map(|most| most as f64) {
        Some(most) if most < size => {
            let reason = format!("made coarser from {}", bytes(size.round() as u64));
            ShareSize::about(most, reason)
        }
        _ => ShareSize::about(size, samples_at(facts.samples, size / facts.samples.max(1) as f64)),
    }
}

fn splats(facts: &ShareFacts, options: &ShareOptions) -> ShareSize {
    let here = facts.placed_here + facts.at_infinity_here;
    let placed = if options.format.holds_time() {
        // As large a share of all samples as of those at this frame.
        (facts.samples as f64 * facts.placed_here as f64 / here.max(1) as f64) as u64
    } else {
        facts.placed_here
    };
    let dome = if options.sky == SplatSky::Dome && facts.at_infinity_here > 0 { DOME } else { 0 };
    let all = placed + dome;
    let splats = options.splats_at_most().map_or(all, |most| all.min(most));
    let each = bytes_of_splat(options.format);
    let merged =
        if splats < all { format!(" merged from {}", count_of(all, "sample")) } else { String::new() };
    let reason = format!("{} of {each:.0} B{merged}", count_of(splats, "splat"));
    ShareSize::about(splats as f64 * each, reason)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts() -> ShareFacts {
        ShareFacts {
            samples: 1_000_000,
            placed_here: 300_000,
            at_infinity_here: 100_000,
            store_bytes: 2e6,
            picture: None,
        }
    }

    #[test]
    fn a_bound_is_what_a_larger_page_takes_and_nothing_to_a_smaller_one() {
        let unbounded = page(&facts(), &ShareOptions::default()).text;
        assert!(unbounded.starts_with("about 2.") && unbounded.ends_with(" MB"), "{unbounded}");
        let bounded = |page_megabytes| {
            let options = ShareOptions { page_is_bounded: true, page_megabytes, ..ShareOptions::default() };
            page(&facts(), &options).text
        };
        assert_eq!((bounded(1.0), bounded(50.0)), ("about 1.00 MB".to_owned(), unbounded));
    }

    #[test]
    fn splats_are_those_with_a_place_of_this_frame_or_of_all_time() {
        let size = |format| splats(&facts(), &ShareOptions { format, ..ShareOptions::default() });
        let of_frame = size(SplatFormat::Ply);
        assert_eq!(
            (of_frame.text.as_str(), of_frame.reason.as_str()),
            ("about 20.4 MB", "300 k splats of 68 B")
        );
        assert_eq!(size(SplatFormat::Glb).text, "about 48.0 MB");
        let options = ShareOptions { splats_are_bounded: true, kilosplats: 100, ..ShareOptions::default() };
        assert_eq!(splats(&facts(), &options).text, "about 6.80 MB");
    }
}
