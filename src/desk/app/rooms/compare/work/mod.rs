//! Two pictures of one place, side by side: before and after pruning, two settings, the truth, kernels, painters.
//!
//! With a renderer of its own, so that neither view waits.

mod difference;

use std::sync::Arc;

use egui::{Color32, ColorImage};

use crate::app::model::window::DockView;
use crate::app::model::{Message, State, method_of};
use crate::app::rooms::charts::work::with_nothing_pruned;
use crate::app::rooms::compare::state::{
    CompareKey, CompareMeasure, CompareSide, CompareVantage, ComparisonFigure, PictureDifference, ShownSides,
};
use crate::app::rooms::compare::work::difference::{
    DisplayedSide, Viewpoint, cameras_left, capture_of, corrected_capture, left_out, refused, unknown_truth,
};
use crate::app::work::worker::Wanted;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::preprocess::{self, PreparedScan};
use overlook_engine::render::fill::fill;
use overlook_engine::render::{Picture, Renderer};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{AlignSettings, Backend, Kernel, Settings};
use overlook_lab::rivals::{Rival, RivalModel};
use overlook_lab::{picture_of_frame, truth};

impl Wanted for Box<CompareKey> {
    /// Compares at the vantage, and with the samples, of the last live picture.
    fn wanted(state: &State) -> Option<Self> {
        let mut key = state.compare_key().filter(|_| state.shows(DockView::Compare))?;
        let sides = key.choice.sides;
        // What no side shows asks for nothing.
        for nth in 1..OF_SETTINGS.len() {
            if !sides.contains(&OF_SETTINGS[nth]) {
                key.settings[nth] = key.settings[0].clone();
            }
        }
        if key.choice.from != CompareVantage::Live {
            key.vantage.camera = key.scene.cameras.first()?.clone();
        }
        key.pictures.retain(|folder| sides.contains(&CompareSide::Pictures(folder.id)));
        Some(Box::new(key))
    }
}

/// The sides that the settings of a key are of, in their order.
const OF_SETTINGS: [CompareSide; 4] =
    [CompareSide::Kept, CompareSide::A, CompareSide::B, CompareSide::Before];

/// Samples and models made for comparisons: the last few are kept.
pub(crate) struct Comparer {
    renderer: Renderer,
    made: Vec<(MadeOf, Made)>,
    /// Passes over all frames of a scene, where the window's own does not serve the settings of a side.
    scans: Vec<(u64, Arc<PreparedScan>)>,
    /// What these passes run on, as they take as long as the capture does.
    threads: Arc<rayon::ThreadPool>,
}

/// What a side is made of.
#[derive(Clone)]
enum Made {
    Samples(Arc<SampleSet>),
    Rival(Arc<dyn RivalModel>),
}

/// What it was made from, and how.
#[derive(PartialEq)]
struct MadeOf {
    scene: u64,
    frame: usize,
    /// The settings that it was pruned by, and whether it was known what is the same over all frames: by a scan that serves them.
    pruned_by: Option<(Settings, bool)>,
    rival: Option<Rival>,
    left_out: Option<usize>,
    /// What the capture was corrected by; `None` before that was known.
    align: Option<AlignSettings>,
}

/// What is kept: one for each side, at two frames.
const KEPT: usize = 4;

/// Passes over all frames that are kept: one for each side.
const KEPT_SCANS: usize = 2;

impl Comparer {
    /// One that reads whole captures on `threads`.
    pub(crate) fn new(threads: Arc<rayon::ThreadPool>) -> Self {
        Self { renderer: Renderer::new(), made: Vec::new(), scans: Vec::new(), threads }
    }

    /// Makes the comparison, or gives the reason against it.
    pub(crate) fn answer(&mut self, key: Box<CompareKey>, job: &Job) -> Result<Message> {
        let outcome = match self.compare(&key, job) {
            Ok(comparison) => Ok(comparison),
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(Error::Invalid { what, .. }) => Err(what),
            Err(error) => Err(error.to_string()),
        };
        Ok(Message::Compared { key, outcome })
    }

    /// Columns and rows of the pictures of a comparison.
    pub(crate) fn size(key: &CompareKey) -> Result<(usize, usize)> {
        let viewpoint = Viewpoint::of(key, key.choice.from, key.vantage.frame)?;
        Ok(viewpoint.vantage.camera.intrinsics.size())
    }

    /// What a side of a comparison shows.
    pub(crate) fn picture(&mut self, key: &CompareKey, side: usize, job: &Job) -> Result<Picture> {
        let viewpoint = Viewpoint::of(key, key.choice.from, key.vantage.frame)?;
        Ok(difference::as_picture(&self.side(key, key.choice.sides[side], &viewpoint, job)?))
    }

    /// Makes the comparison; `Invalid` where a side cannot be shown there.
    fn compare(&mut self, key: &CompareKey, job: &Job) -> Result<PictureDifference> {
        let viewpoint = Viewpoint::of(key, key.choice.from, key.vantage.frame)?;
        let sides = self.sides(key, &viewpoint, job)?;
        if key.choice.measure == CompareMeasure::Flicker {
            let before = self.sides(key, &viewpoint.before(key)?, job)?;
            return difference::flicker([before, sides], key.choice.range, key.dark);
        }
        let compared = difference::between(sides, key.choice.measure, key.choice.range, key.dark)?;
        if key.choice.measure != CompareMeasure::Class {
            return Ok(compared);
        }
        let Viewpoint { vantage, truth, .. } = viewpoint;
        let truth = truth.ok_or_else(unknown_truth)?;
        let seen = truth::seen_at(&cameras_left(key)?, vantage.frame)?;
        let classes = truth::class_map(&vantage.camera, &truth, &seen).ok_or_else(|| {
            refused("The true picture has no depth, so that differences cannot be sorted into unseen, edge and inner.")
        })?;
        difference::by_class(compared, &classes, key.dark)
    }

    fn sides(&mut self, key: &CompareKey, viewpoint: &Viewpoint, job: &Job) -> Result<[DisplayedSide; 2]> {
        let left = self.side(key, key.choice.sides[0], viewpoint, job)?;
        job.check()?;
        Ok([left, self.side(key, key.choice.sides[1], viewpoint, job)?])
    }

    fn side(
        &mut self,
        key: &CompareKey,
        side: CompareSide,
        viewpoint: &Viewpoint,
        job: &Job,
    ) -> Result<DisplayedSide> {
        let claimed = (side == CompareSide::AsClaimed).then(|| viewpoint.as_claimed(key)).flatten();
        let viewpoint = claimed.as_ref().unwrap_or(viewpoint);
        let vantage = &viewpoint.vantage;
        if side == CompareSide::Truth {
            return Ok(difference::of_frame(viewpoint.truth.as_deref().ok_or_else(unknown_truth)?));
        }
        if let CompareSide::Pictures(id) = side {
            return picture_of_folder(key, id, viewpoint);
        }
        let of_settings = OF_SETTINGS.iter().position(|of| *of == side).unwrap_or(0);
        let mut settings = key.settings[of_settings].clone();
        let mut render = settings.render.clone();
        match side {
            CompareSide::Point => render.kernel = Kernel::Point,
            CompareSide::Block => render.kernel = Kernel::Block,
            CompareSide::Surfel => render.kernel = Kernel::Surfel,
            CompareSide::Gather => render.kernel = Kernel::Gather,
            CompareSide::Cpu => render.backend = Backend::Cpu,
            CompareSide::Gpu => render.backend = Backend::Gpu,
            CompareSide::Everything => settings = with_nothing_pruned(&settings),
            CompareSide::AsClaimed => settings.align = AlignSettings::OFF,
            _ => {}
        }
        let made = self.made(key, side, &settings, vantage.frame, job)?;
        let mut picture = match made {
            Made::Samples(samples) => {
                self.renderer.forget_background();
                self.renderer.render(&samples, vantage, &render, job)?.0
            }
            Made::Rival(model) => {
                let mut picture = model.render(&vantage.camera);
                fill(&mut picture, &vantage.camera, &render);
                Arc::new(picture)
            }
        };
        if side == CompareSide::Gpu
            && let Some(notice) = self.renderer.notice()
        {
            return Err(refused(notice));
        }
        viewpoint.expose(Arc::make_mut(&mut picture));
        Ok(difference::of_picture(&picture))
    }

    /// What is the same over all frames by these settings; `None` while the window looks for the first time.
    fn scan(
        &mut self,
        key: &CompareKey,
        settings: &Settings,
        job: &Job,
    ) -> Result<Option<Arc<PreparedScan>>> {
        let Some(scan) = key.scan.as_deref() else { return Ok(None) };
        self.scans.retain(|(scene, _)| *scene == key.scene.id);
        let own = self.scans.iter().map(|(_, scan)| scan);
        if let Some(scan) = own.chain([scan]).find(|scan| scan.serves(settings)) {
            return Ok(Some(scan.clone()));
        }
        let capture = capture_of(&key.scene)?;
        let scan = self.threads.install(|| preprocess::scan(capture, settings, job))?;
        keep(&mut self.scans, KEPT_SCANS, (key.scene.id, scan.clone()));
        Ok(Some(scan))
    }

    /// What a side is made of at a frame.
    fn made(
        &mut self,
        key: &CompareKey,
        side: CompareSide,
        settings: &Settings,
        frame: usize,
        job: &Job,
    ) -> Result<Made> {
        let (left_out, rival) = (left_out(key), side.rival());
        let as_shown = rival.is_none() && method_of(settings) == method_of(&key.settings[0]);
        if as_shown && left_out.is_none() && (key.whole || frame == key.vantage.frame) {
            return Ok(Made::Samples(key.samples.0.clone()));
        }
        // The scan is of all cameras, so that it does not fit a left-out one; without pruning no span is used.
        let frame_alone = left_out.is_some() || rival.is_some() || side == CompareSide::Everything;
        let scan = if frame_alone { None } else { self.scan(key, settings, job)? };
        let pruned_by = rival.is_none().then(|| (method_of(settings), scan.is_some()));
        let align = key.scan.as_ref().map(|scan| scan.align_settings().clone());
        let of = MadeOf { scene: key.scene.id, frame, pruned_by, rival, left_out, align };
        if let Some((_, made)) = self.made.iter().find(|(known, _)| *known == of) {
            return Ok(made.clone());
        }
        let others = left_out.map(|_| cameras_left(key)).transpose()?;
        let capture = others.as_ref().map_or_else(|| corrected_capture(key), Ok)?;
        let made = if let Some(rival) = rival {
            Made::Rival(rival.build(&truth::seen_at(capture, frame)?)?.into())
        } else {
            let inspection = preprocess::inspect_frame(capture, scan.as_deref(), settings, frame, job)?;
            Made::Samples(inspection.samples)
        };
        keep(&mut self.made, KEPT, (of, made.clone()));
        Ok(made)
    }
}

/// Adds the latest, and drops the first if there are more than `most`.
fn keep<T>(kept: &mut Vec<T>, most: usize, latest: T) {
    if kept.len() == most {
        kept.remove(0);
    }
    kept.push(latest);
}

fn picture_of_folder(key: &CompareKey, id: u64, viewpoint: &Viewpoint) -> Result<DisplayedSide> {
    let folder = key.pictures.iter().find(|folder| folder.id == id);
    let folder = folder.ok_or_else(|| refused("These pictures are closed."))?;
    let frame = folder.picture(viewpoint.from, viewpoint.vantage.frame).map_err(refused)?()?;
    Ok(difference::of_picture(&picture_of_frame(&frame)))
}

/// Columns of the line between two pictures.
const LINE: usize = 2;

/// What the view shows, a pixel for each pixel of the pictures.
pub(crate) fn image(figure: &ComparisonFigure) -> ColorImage {
    let [left, top, columns, rows] = figure.part();
    let width = figure.images[0].size[0];
    let pixel = |side: usize, x: usize, y: usize| figure.images[side].pixels[(top + y) * width + left + x];
    let drawn = |columns: usize, color: &dyn Fn(usize, usize) -> Color32| {
        let pixels = (0..rows).flat_map(|y| (0..columns).map(move |x| color(x, y)));
        ColorImage::new([columns, rows], pixels.collect())
    };
    match figure.shown() {
        ShownSides::One(side) => drawn(columns, &|x, y| pixel(side, x, y)),
        ShownSides::Wiped(line) => drawn(columns, &|x, y| {
            let is_line = (line.saturating_sub(LINE / 2)..line + LINE / 2).contains(&x);
            if is_line { Color32::WHITE } else { pixel(usize::from(x >= line), x, y) }
        }),
        ShownSides::Beside => drawn(2 * columns + LINE, &|x, y| match x.checked_sub(columns) {
            None => pixel(0, x, y),
            Some(beyond) => beyond.checked_sub(LINE).map_or(Color32::WHITE, |x| pixel(1, x, y)),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::model::{OpenScene, Same, SceneSource};
    use crate::app::rooms::compare::state::{CompareChoice, CompareInView, CompareLook, CompareMode};
    use crate::app::work::workers::pool;
    use egui::{Rect, pos2};
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_engine::render::Vantage;
    use overlook_engine::settings::{MixedPixels, SpanLevels};

    /// A comparison of settings A, the defaults, with settings B, by a scan that serves A.
    fn key(b: Settings) -> CompareKey {
        let spec = DemoSpec::new("orrery").cameras(2).frames(8).size((48, 36));
        let demo = Demo::new(&spec).unwrap();
        let a = Settings::default();
        let capture = demo.capture(&a.capture);
        let scan = preprocess::scan(&capture, &a, &Job::new()).unwrap();
        let samples = preprocess::prune(&capture, &scan, &a, &Job::new()).unwrap().samples;
        CompareKey {
            scene: Arc::new(OpenScene::of_capture(
                SceneSource::Demo("orrery".into()),
                capture,
                demo.truth_views(),
                1.0,
            )),
            choice: CompareChoice {
                sides: [CompareSide::A, CompareSide::B],
                ..CompareLook::default().choice
            },
            vantage: Vantage { camera: demo.home(), frame: 3 },
            samples: Same(samples),
            whole: true,
            scan: Some(Same(scan)),
            settings: [a.clone(), a, b.clone(), b],
            pictures: Vec::new(),
            dark: true,
        }
    }

    fn comparer() -> Comparer {
        Comparer::new(pool("test", 2, 0).unwrap())
    }

    /// Lengths of the spans of what was made last.
    fn lengths(comparer: &Comparer) -> Vec<usize> {
        let (_, Made::Samples(samples)) = comparer.made.last().unwrap() else { panic!("no samples") };
        let mut lengths: Vec<usize> = samples.images.iter().map(|image| image.span.len()).collect();
        lengths.sort_unstable();
        lengths.dedup();
        lengths
    }

    #[test]
    fn each_side_is_made_with_the_spans_of_its_own_settings() {
        let mut paper = Settings::default();
        paper.spans.levels = SpanLevels::Paper;
        let (mut comparer, key) = (comparer(), key(paper));
        comparer.compare(&key, &Job::new()).unwrap();
        assert_eq!(lengths(&comparer), [1, 8], "of the frames around it, the paper knows all or one");
        let scanned = comparer.scans.len();
        comparer.compare(&CompareKey { dark: false, ..key }, &Job::new()).unwrap();
        assert_eq!((scanned, comparer.scans.len()), (1, 1), "the frames are read again once");
    }

    #[test]
    fn at_a_truth_vantage_the_samples_of_its_frame_are_compared_and_not_those_of_the_frame_shown() {
        let key = CompareKey {
            choice: CompareChoice {
                sides: [CompareSide::Kept, CompareSide::Truth],
                from: CompareVantage::Truth(0),
                ..CompareLook::default().choice
            },
            ..key(Settings::default())
        };
        let vantage = Viewpoint::of(&key, key.choice.from, key.vantage.frame).unwrap().vantage;
        assert_ne!(vantage.frame, key.vantage.frame);
        let expected = comparer().compare(&key, &Job::new()).unwrap();
        let capture = capture_of(&key.scene).unwrap();
        let scan = key.scan.as_deref().map(|scan| &**scan);
        let shown =
            preprocess::inspect_frame(capture, scan, &key.settings[0], key.vantage.frame, &Job::new())
                .unwrap();
        let key = CompareKey { samples: Same(shown.samples), whole: false, ..key };
        let compared = comparer().compare(&key, &Job::new()).unwrap();
        assert!((compared.psnr_db - expected.psnr_db).abs() < 1e-9, "{} dB", compared.psnr_db);
        assert_eq!(compared.one_sided, expected.one_sided);
    }

    #[test]
    fn all_samples_are_every_pixel_of_the_frame() {
        let (mut comparer, mut key) = (comparer(), key(Settings::default()));
        key.settings[0].pruning.mixed_pixels = MixedPixels::Drop;
        key.choice.sides = [CompareSide::Everything, CompareSide::Kept];
        comparer.compare(&key, &Job::new()).unwrap();
        assert_eq!(lengths(&comparer), [1]);
        let (_, Made::Samples(samples)) = comparer.made.last().unwrap() else { panic!("no samples") };
        assert_eq!(samples.sample_count(), 2 * 48 * 36);
    }

    /// Pictures of eight by four pixels: column and row in red and green, the side in blue.
    fn figure(mode: CompareMode, in_view: CompareInView) -> ComparisonFigure {
        let image = |side: u8| {
            let pixels = (0..32).map(|at| Color32::from_rgb(at % 8, at / 8, side)).collect();
            Arc::new(ColorImage::new([8, 4], pixels))
        };
        ComparisonFigure {
            images: [image(0), image(1), image(2)],
            names: ["a".to_owned(), "b".to_owned()],
            mode,
            in_view,
            measure: CompareMeasure::Steps,
            range: 9.0,
            dark: true,
        }
    }

    #[test]
    fn each_way_of_comparing_draws_what_its_view_shows() {
        let view = CompareInView::default();
        let drawn = |mode, in_view| image(&figure(mode, in_view));
        let side = |image: &ColorImage, x: usize| image.pixels[x].b();
        assert_eq!(side(&drawn(CompareMode::Difference, view), 3), 2);
        assert_eq!(side(&drawn(CompareMode::Flip, view), 3), 0);
        let flipped = CompareInView { flipped: true, ..view };
        assert_eq!(side(&drawn(CompareMode::Flip, flipped), 3), 1);
        assert_eq!(side(&drawn(CompareMode::Wipe, flipped), 0), 1);
        let wiped = drawn(CompareMode::Wipe, view);
        assert_eq!([0, 2, 3, 4, 5].map(|x| side(&wiped, x)), [0, 0, 255, 255, 1]);
        let beside = drawn(CompareMode::Beside, view);
        assert_eq!(beside.size, [18, 4]);
        assert_eq!([7, 8, 9, 10].map(|x| side(&beside, x)), [0, 255, 255, 1]);
        // Only the part in view is drawn, and a line beside it is not.
        let part = Rect::from_min_max(pos2(0.5, 0.25), pos2(1.0, 0.75));
        let wiped = |line| drawn(CompareMode::Wipe, CompareInView { part, line, ..view });
        let right = wiped(0.25);
        assert_eq!(right.size, [4, 2]);
        assert_eq!(right.pixels[0], Color32::from_rgb(4, 1, 1), "the line is left of what is seen");
        assert!(wiped(1.2).pixels.iter().all(|pixel| pixel.b() == 0));
    }
}
