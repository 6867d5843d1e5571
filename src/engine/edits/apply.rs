//! Edits of samples: what pruning kept, or what a store holds.
//!
//! ```text
//! span of an image     |───────────────────|
//! edit of some frames       |─────|            ─▶ cut into segments; a sample stays where no edit deletes it:
//! what stays of it     |────|     |────────|       in one image of its span, or in images of shorter ones
//! ```

use std::ops::Range;
use std::sync::Arc;

use half::f16;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::list::{Action, Edit, EditList, Reach};
use super::marks::SampleMarks;
use super::region::Region;
use super::region_test::{RegionContext, RegionTest};
use super::seen::{Evidence, ImageMarks, PixelRays, Seen};
use super::tile::Tile;
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::{ImageBuffer, Sample, SampleImage, SampleSet, SampleVotes, Span, VoteCounts};

/// What was cut by hand, apart from what rules dropped.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CutByHand {
    /// The edit list, as TOML.
    pub edits: String,
    /// Cameras that were left out of all frames before pruning.
    pub cameras: Vec<String>,
    /// Pixels with depth, over all frames, that counted as pixels without depth before pruning.
    pub pixels: u64,
    /// Samples that were deleted after pruning, or from a store.
    pub samples: u64,
    /// Pixels, over all frames, that these samples stood for.
    pub sample_pixels: u64,
}

impl CutByHand {
    /// What is left to do of a list on a store that was cut before, as its report says: what the list begins with as an earlier list does
    /// is done, and so are edits further on that are among those of an earlier list and depend on other samples. So a list that is
    /// applied again changes nothing: what a picture shows by now was hidden when its edit was made.
    #[must_use]
    pub fn left_to_do(done: &[Self], edits: &EditList) -> EditList {
        let mut left: Vec<Edit> = edits.acting().cloned().collect();
        for cut in done {
            let Ok(list) = EditList::from_toml(&cut.edits, "report") else { continue };
            let known: Vec<&Edit> = list.acting().collect();
            if known.len() <= left.len() && known.iter().zip(&left).all(|(known, edit)| known.does_as(edit)) {
                left.drain(..known.len());
            }
            let is_done = |edit: &Edit| known.iter().any(|known| known.does_as(edit));
            left.retain(|edit| !(edit.region.depends_on_others() && is_done(edit)));
        }
        EditList { edits: left }
    }
}

/// What edits leave of samples.
#[derive(Debug)]
pub struct EditedImages {
    /// Ordered as [`SampleSet::images`].
    pub images: ImageBuffer,
    /// Samples that are gone.
    pub dropped: u64,
    /// Pixels, over all frames, that deleted samples stood for.
    pub dropped_pixels: u64,
    /// How many samples each edit of the list took from what those that act before it left; negative where it brought some back or split
    /// them by time.
    pub taken: Vec<i64>,
    /// Whether anything changed.
    pub is_changed: bool,
}

/// An edit made ready for one camera.
struct SampleEdit {
    /// Its index among the edits that act, in the order in which they do.
    nth: usize,
    action: Action,
    /// Indices of frames; `None` for all.
    frames: Option<Range<usize>>,
    reach: Reach,
    test: RegionTest,
}

impl SampleEdit {
    /// `None` where the edit changes nothing of the camera.
    fn new(nth: usize, edit: &Edit, context: RegionContext<'_>, frame_numbers: &[i64]) -> Option<Self> {
        let test = RegionTest::new(&edit.region, context);
        let is_idle = match (edit.action, &test) {
            (Action::KeepOnly, RegionTest::Constant(inside)) => *inside,
            (_, RegionTest::Constant(inside)) => !inside,
            _ => false,
        };
        let frames = edit.frames.map(|[first, last]| {
            let start = frame_numbers.partition_point(|number| *number < first);
            start..frame_numbers.partition_point(|number| *number <= last).max(start)
        });
        let is_never = frames.as_ref().is_some_and(Range::is_empty);
        (!is_idle && !is_never).then_some(Self { nth, action: edit.action, frames, reach: edit.reach, test })
    }

    /// The frames of a span that it acts at.
    fn frames_within(&self, span: Span) -> Range<usize> {
        let all = span.start as usize..span.end as usize;
        let Some(frames) = &self.frames else { return all };
        let some = frames.start.max(all.start)..frames.end.min(all.end);
        match (some.is_empty(), self.reach) {
            (true, _) => 0..0,
            (false, Reach::Span) => all,
            (false, Reach::Frames) => some,
        }
    }
}

/// What stays of an image.
enum Left {
    All,
    /// Parts of shorter spans, and that of its own span, none of them empty.
    Parts(Vec<SampleImage>),
}

/// The edits of one camera, with what its samples may be asked.
struct CameraEdits<'a> {
    rays: PixelRays,
    edits: Vec<SampleEdit>,
    camera: &'a Camera,
}

impl CameraEdits<'_> {
    /// The edits that act on samples of a span, each with its frames there.
    fn acting(&self, span: Span) -> Vec<(&SampleEdit, Range<usize>)> {
        let of_span = self.edits.iter().map(|edit| (edit, edit.frames_within(span)));
        of_span.filter(|(_, frames)| !frames.is_empty()).collect()
    }

    /// What stays of an image; `own` has the colors that edits ask for, and `taken` counts what each edit takes.
    fn left_of(
        &self,
        image: &SampleImage,
        own: &SampleImage,
        votes: &[VoteCounts],
        marks: &[ImageMarks],
        taken: &mut [i64],
    ) -> Result<Left> {
        let acting = self.acting(image.span);
        if acting.is_empty() {
            return Ok(Left::All);
        }
        let segments = segments_of(image.span, &acting);
        // For each run of segments that samples stay in: the span, and which samples.
        let mut runs: Vec<(Span, Vec<bool>)> = Vec::new();
        let mut is_changed = false;
        let asks_for_normals = acting.iter().any(|(edit, _)| edit.test.asks_for_normals());
        let evidence = Evidence::new(own, votes, marks, asks_for_normals, self.camera)?;
        let mut inside = vec![false; acting.len()];
        let mut stays = vec![true; segments.len()];
        let mut keep = |sample: &Sample, inside: &[bool]| {
            stays.fill(true);
            let mut parts = 1;
            for ((edit, frames), inside) in acting.iter().zip(inside) {
                for (stays, segment) in stays.iter_mut().zip(&segments) {
                    if frames.start <= segment.start && segment.end <= frames.end {
                        *stays = edit.action.leaves(*stays, *inside);
                    }
                }
                let left = spans_of(&segments, &stays).count() as i64;
                taken[edit.nth] += parts - left;
                parts = left;
            }
            is_changed |= stays.contains(&false);
            for span in spans_of(&segments, &stays) {
                let at = runs.iter().position(|(known, _)| *known == span).unwrap_or_else(|| {
                    runs.push((span, vec![false; image.len()]));
                    runs.len() - 1
                });
                runs[at].1[sample.index] = true;
            }
        };
        for tile in Tile::all(image, self.camera) {
            let known: Vec<Option<bool>> =
                acting.iter().map(|(edit, _)| edit.test.of_tile(&tile, marks)).collect();
            for (sample, inverse_depth) in tile.samples() {
                let mut seen: Seen<'_> = self.rays.seen(sample.x, sample.y, inverse_depth);
                evidence.add_to(&mut seen, &sample);
                for ((inside, known), (edit, _)) in inside.iter_mut().zip(&known).zip(&acting) {
                    *inside = known.unwrap_or_else(|| edit.test.contains(&seen));
                }
                keep(&sample, &inside);
            }
        }
        if !is_changed {
            return Ok(Left::All);
        }
        let parts = runs.iter().map(|(span, keep)| image.part(*span, |sample, _| keep[sample.index]));
        Ok(Left::Parts(parts.collect()))
    }
}

/// A span, cut where an edit begins or ends to act.
fn segments_of(span: Span, acting: &[(&SampleEdit, Range<usize>)]) -> Vec<Range<usize>> {
    let mut bounds = vec![span.start as usize, span.end as usize];
    bounds.extend(acting.iter().flat_map(|(_, frames)| [frames.start, frames.end]));
    bounds.sort_unstable();
    bounds.dedup();
    bounds.windows(2).map(|pair| pair[0]..pair[1]).collect()
}

/// The spans of the runs of segments that a sample stays in.
fn spans_of(segments: &[Range<usize>], stays: &[bool]) -> impl Iterator<Item = Span> {
    let runs = stays.chunk_by(|one, next| one == next).scan(segments, |rest, run| {
        let (of_run, later) = rest.split_at(run.len());
        *rest = later;
        Some((of_run, run[0]))
    });
    runs.filter(|(_, stays)| *stays)
        .map(|(of_run, _)| Span { start: of_run[0].start as u32, end: of_run[of_run.len() - 1].end as u32 })
}

/// Images that are edited at a time: enough for every thread, few enough to be held in memory.
const BATCH: usize = 64;

/// What a list leaves of the images of a set, which may be in a file; `outline` is all but the images. `votes` are those on the images
/// as they are given; `place` is named in errors. Where the colors of `images` were changed, edits ask for those of `own`.
///
/// The same input gives the same images, whatever the number of threads. An image that nothing is deleted from is shared.
///
/// # Errors
/// `Invalid` where the list asks for votes or normals that are not there; `Io` as [`ImageBuffer::get`]; `Cancelled`.
pub fn cut(
    images: &ImageBuffer,
    own: Option<&ImageBuffer>,
    outline: &SampleSet,
    edits: &EditList,
    votes: Option<&SampleVotes>,
    place: &str,
    job: &Job,
) -> Result<EditedImages> {
    if edits.asks_for_votes() && votes.is_none() {
        return Err(Error::invalid(
            place,
            "an edit asks which cameras confirm a sample, which a store does not hold; use overlook edit with --capture FOLDER, the capture that it was made from",
        ));
    }
    let in_order = edits.in_order();
    let marks = SampleMarks::of(
        own.unwrap_or(images),
        outline,
        in_order.iter().map(|edit| &edit.region),
        votes,
        place,
        job,
    )?;
    let of_camera = |camera| {
        let context = RegionContext { camera, channels: &outline.values, marked: marks.regions() };
        let numbered = in_order.iter().enumerate();
        let ready =
            numbered.filter_map(|(nth, edit)| SampleEdit::new(nth, edit, context, &outline.frame_numbers));
        CameraEdits { rays: PixelRays::of(camera), edits: ready.collect(), camera }
    };
    let cameras: Vec<CameraEdits<'_>> = outline.cameras.iter().map(of_camera).collect();
    let mut left = images.empty_like();
    let (mut shorter, mut is_changed, mut taken) = (Vec::new(), false, vec![0; in_order.len()]);
    for first in (0..images.len()).step_by(BATCH) {
        let batch = (first..images.len().min(first + BATCH)).into_par_iter();
        let edited: Vec<(Arc<SampleImage>, Left, Vec<i64>)> = batch
            .map(|index| {
                job.check()?;
                let image = images.get(index)?;
                let votes = votes.map_or(&[][..], |votes| votes.of_image(index));
                let own = own.map_or_else(|| Ok(image.clone()), |own| own.get(index))?;
                let edits = &cameras[image.camera as usize];
                let mut taken = vec![0; in_order.len()];
                let left = edits.left_of(&image, &own, votes, marks.of_image(index), &mut taken)?;
                Ok((image, left, taken))
            })
            .collect::<Result<_>>()?;
        for (image, of_image, of_edits) in edited {
            taken.iter_mut().zip(of_edits).for_each(|(taken, more)| *taken += more);
            match of_image {
                Left::All => left.push(image)?,
                Left::Parts(parts) => {
                    is_changed = true;
                    let (own, others): (Vec<_>, Vec<_>) =
                        parts.into_iter().partition(|part| part.span == image.span);
                    own.into_iter().try_for_each(|part| left.push(part))?;
                    shorter.extend(others);
                }
            }
        }
    }
    shorter.into_iter().try_for_each(|part| left.join(part))?;
    left.sort();
    let place_of = |edit: &Edit| in_order.iter().position(|acting| std::ptr::eq(*acting, edit));
    let samples = |images: &ImageBuffer| images.facts().map(|image| image.samples as u64).sum::<u64>();
    let pixels = |images: &ImageBuffer| {
        images.facts().map(|image| image.samples as u64 * image.span.len() as u64).sum::<u64>()
    };
    Ok(EditedImages {
        dropped: samples(images).saturating_sub(samples(&left)),
        dropped_pixels: pixels(images).saturating_sub(pixels(&left)),
        taken: edits.edits.iter().map(place_of).map(|nth| nth.map_or(0, |nth| taken[nth])).collect(),
        images: left,
        is_changed,
    })
}

/// What a list leaves of samples in memory, and how many each of its edits took ([`EditedImages::taken`]). Votes are those of the set's
/// images.
///
/// # Errors
/// As [`cut`].
pub fn edit_samples(
    set: &SampleSet,
    edits: &EditList,
    votes: Option<&SampleVotes>,
    place: &str,
    job: &Job,
) -> Result<(SampleSet, Vec<i64>)> {
    let EditedImages { images, taken, .. } =
        cut(&ImageBuffer::of(&set.images), None, set, edits, votes, place, job)?;
    Ok((SampleSet { images: images.into_images()?, ..set.clone() }, taken))
}

/// What a list leaves of a set that [`selected`] made of `own`: edits ask for the colors of `own`.
///
/// # Errors
/// As [`cut`].
pub fn edit_tinted(
    tinted: &SampleSet,
    own: &SampleSet,
    edits: &EditList,
    votes: Option<&SampleVotes>,
    place: &str,
    job: &Job,
) -> Result<SampleSet> {
    let [shown, own] = [tinted, own].map(|set| ImageBuffer::of(&set.images));
    let EditedImages { images, .. } = cut(&shown, Some(&own), tinted, edits, votes, place, job)?;
    Ok(SampleSet { images: images.into_images()?, ..tinted.clone() })
}

/// How much of its own color a selected sample keeps where selections are shown.
const OWN_COLOR: f32 = 0.35;

/// A set whose samples in a region have another color (linear Rec.709) mixed into their own, and how many these are: how a selection is
/// shown. An image without any is shared.
///
/// # Errors
/// As [`edit_samples`].
pub fn selected(
    set: &SampleSet,
    region: &Region,
    color: [f32; 3],
    votes: Option<&SampleVotes>,
    place: &str,
    job: &Job,
) -> Result<(SampleSet, u64)> {
    if region.asks_for_votes() && votes.is_none() {
        return Err(Error::invalid(place, "which cameras confirm samples is not known of a store"));
    }
    let marks = SampleMarks::of(&ImageBuffer::of(&set.images), set, [region].into_iter(), votes, place, job)?;
    let tinted: Vec<(Arc<SampleImage>, u64)> = set
        .images
        .par_iter()
        .enumerate()
        .map(|(index, image)| {
            job.check()?;
            let camera = &set.cameras[image.camera as usize];
            let context = RegionContext { camera, channels: &set.values, marked: marks.regions() };
            let test = RegionTest::new(region, context);
            if matches!(test, RegionTest::Constant(false)) {
                return Ok((image.clone(), 0));
            }
            let votes = votes.map_or(&[][..], |votes| votes.of_image(index));
            let marks = marks.of_image(index);
            let evidence = Evidence::new(image, votes, marks, test.asks_for_normals(), camera)?;
            let (mut colors, mut count) = (Vec::new(), 0);
            test.for_each_inside(image, camera, &evidence, |sample| {
                if count == 0 {
                    colors.clone_from(&image.color);
                }
                count += 1;
                let own = &mut colors[sample.index];
                *own = std::array::from_fn(|channel| {
                    let mixed = OWN_COLOR * own[channel].to_f32() + (1.0 - OWN_COLOR) * color[channel];
                    f16::from_f32(mixed)
                });
            });
            let tinted =
                (count > 0).then(|| Arc::new(SampleImage { color: colors, ..SampleImage::clone(image) }));
            Ok((tinted.unwrap_or_else(|| image.clone()), count))
        })
        .collect::<Result<_>>()?;
    let count = tinted.iter().map(|(_, count)| count).sum();
    Ok((SampleSet { images: tinted.into_iter().map(|(image, _)| image).collect(), ..set.clone() }, count))
}
