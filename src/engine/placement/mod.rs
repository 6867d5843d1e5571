//! Where to put cameras: the poses that together show most of what a cheap first capture saw.
//!
//! Purpose: pictures may take minutes each. A first capture of few pixels tells where surfaces are; the expensive cameras then stand
//! where each surface is seen as finely as it is asked for, and few of them see the same.
//!
//! ```text
//! Capture ─ preprocess ─▶ kept samples ─ surfels ─▶ stands: places ─ depth_map: what is seen from each ─▶ poses ─▶ coverage ─▶ Placement
//! ```
//!
//! Source: C. Connolly, *The Determination of Next Best Views*, 1985: the next view is the one that adds most, told from what is known so
//! far. The views are taken by [`GreedyCover`], whose guarantee holds as what a view adds never grows. What differs: what is known is the
//! whole first capture, so that all views are placed before any is taken; a surface counts by how finely it is seen, in proportion to what
//! is asked for; and each chosen camera is exchanged and turned afterwards, as long as another pose adds more beside the others.
//!
//! A surface counts with the kept samples that show it: as many as the finest picture of it has pixels. With a rate that is asked for in
//! pixels a unit, it counts with its area. Surfaces that the first capture did not see are not known, and count as empty space.

mod coverage;
mod depth_map;
mod stands;
mod surfels;

use glam::DVec3;

use crate::capture::{
    Camera, Capture, GreedyCover, Intrinsics, in_perspective, pivot, with_reindexed_frames,
};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::median::median;
use crate::preprocess::preprocess;
use crate::settings::Settings;
use coverage::Coverage;
use surfels::{Asked, Moment, moments};

pub use coverage::PlacedCamera;
pub use stands::Stand;
pub use surfels::Surfel;

/// About the most surfels that candidates are compared by.
const COUNTED: usize = 8_000;

/// Frames, evenly spread, at which surfaces are looked at.
const FRAMES: usize = 3;

/// Bytes of frames that are kept of the coarse capture.
const CACHE_BYTES: usize = 64 << 20;

/// What is asked of a placement.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceOptions {
    /// How many cameras are placed, at least 1.
    pub cameras: usize,
    /// Where they may stand.
    pub stand: Stand,
    /// Columns and rows of their pictures; those of the coarse capture if there are none. The horizontal angle of view is the coarse
    /// capture's.
    pub size: Option<(u32, u32)>,
    /// Pixels a world unit that each surface should be seen with; without it each surface should be seen as finely as the finest coarse
    /// picture shows it, were that of this size.
    pub rate: Option<f64>,
}

/// What was placed, and what stays unseen.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// By what each adds; fewer than asked for where no other adds anything.
    pub cameras: Vec<PlacedCamera>,
    /// The share that the cameras of the coarse capture see, measured the same way, were their pictures as large.
    pub coarse_cameras_see: f64,
    /// The share of surface that no placed camera sees at all, 0 to 1.
    pub unseen: f64,
    /// The surface that no placed camera sees at all, each point once.
    pub unseen_surfels: Vec<Surfel>,
    /// Up in the world, unit length.
    pub up_in_world: DVec3,
    /// Number of the first frame that was looked at.
    pub frame_number: i64,
}

/// Places cameras by a coarse capture. `settings` are those of its preprocessing. The same every time, whatever the number of threads.
///
/// # Errors
/// Those of preprocessing; `Invalid` where no camera or an impossible size, rate or box is asked for, where the capture shows no surface,
/// and where no place is left to stand at; `Cancelled`.
pub fn place(capture: &Capture, options: &PlaceOptions, settings: &Settings, job: &Job) -> Result<Placement> {
    check(options)?;
    let what = "cameras are placed by coarse captures in perspective alone; render the coarse capture in perspective";
    in_perspective(&capture.cameras, &capture.name, what)?;
    let lens = lens(&capture.cameras, options.size);
    let scale = lens.fx / self::lens(&capture.cameras, None).fx;
    let asked = options.rate.map_or(Asked::AsCoarse(1.0 / scale), |rate| Asked::Width(1.0 / rate));
    let capture = some_frames(capture);
    let mut settings = settings.clone();
    settings.store.normals = true;
    let set = preprocess(&capture, &settings, job)?.samples;
    let moments = moments(&set, &asked);
    if moments.iter().all(|moment| moment.surfels.is_empty()) {
        let what = "shows no surface that cameras could be placed for; give one whose pictures have depth";
        return Err(Error::invalid(&capture.name, what));
    }
    let middle = middle(&capture.cameras, &moments);
    let places = stands::places(&options.stand, &capture.cameras, middle, capture.up_in_world);
    let own = capture.cameras.len();
    let surfels: usize = moments.iter().map(|moment| moment.surfels.len()).sum();
    let mut coverage = Coverage::new(&moments, surfels.div_ceil(COUNTED), lens, capture.up_in_world);
    job.start("Looking from places", own + places.len());
    coverage.look_from(capture.cameras.iter().map(Camera::position_in_world).collect(), job)?;
    coverage.look_from(places, job)?;
    coverage.leave_out_places_too_near(own);
    let may_stay = !matches!(options.stand, Stand::Within(_));
    let candidates = coverage.point_everywhere(&capture.cameras, may_stay, middle);
    if candidates == 0 {
        let what = "has surfaces everywhere where cameras may stand; allow other places";
        return Err(Error::invalid(&capture.name, what));
    }
    job.start("Placing cameras", options.cameras);
    let chosen: Vec<usize> = GreedyCover::new(&mut coverage, 0..candidates)
        .take(options.cameras)
        .take_while(|addition| addition.added > 0)
        .map(|addition| {
            job.advance(1);
            addition.view
        })
        .collect();
    job.check()?;
    let cameras = coverage.improved(&chosen);
    let coarse = capture.cameras.iter().map(|camera| scaled(camera, scale)).collect();
    told(&capture, &moments, lens, [cameras, coarse], job)
}

/// What is told of the placed and of the coarse cameras, by every surfel.
fn told(
    capture: &Capture,
    moments: &[Moment],
    lens: Intrinsics,
    [placed, coarse]: [Vec<Camera>; 2],
    job: &Job,
) -> Result<Placement> {
    let shown_by = |cameras: Vec<Camera>| {
        let mut coverage = Coverage::new(moments, 1, lens, capture.up_in_world);
        coverage.look_from(cameras.iter().map(Camera::position_in_world).collect(), job)?;
        let in_order = coverage.in_order(cameras);
        Ok((coverage, in_order))
    };
    let (_, coarse) = shown_by(coarse)?;
    let (coverage, mut cameras) = shown_by(placed)?;
    for (nth, placed) in cameras.iter_mut().enumerate() {
        placed.camera.name = format!("placed{}", nth + 1);
    }
    Ok(Placement {
        coarse_cameras_see: coarse.last().map_or(0.0, |last| last.seen),
        unseen: coverage.unseen_share(),
        unseen_surfels: coverage.unseen_surfels(),
        cameras,
        up_in_world: capture.up_in_world,
        frame_number: capture.frame_numbers.first().copied().unwrap_or(0),
    })
}

fn check(options: &PlaceOptions) -> Result<()> {
    let refuse = |what: &str| Err(Error::invalid("placement", what));
    if options.cameras == 0 {
        return refuse("no camera is to be placed; ask for one or more");
    }
    if options.rate.is_some_and(|rate| !(rate > 0.0 && rate.is_finite())) {
        return refuse("the rate is no number of pixels a unit; give one above 0");
    }
    if options
        .size
        .is_some_and(|(width, height)| !crate::capture::is_believable_size(width as usize, height as usize))
    {
        return refuse("no picture has this size; give columns and rows, as in 640x480");
    }
    match options.stand {
        Stand::Within([low, high]) if !(low.is_finite() && high.is_finite() && low.cmple(high).all()) => {
            refuse("the box is none; give its lowest and its highest coordinates")
        }
        _ => Ok(()),
    }
}

/// The lens that most cameras have, centered, at another size.
fn lens(cameras: &[Camera], size: Option<(u32, u32)>) -> Intrinsics {
    let count = |lens: &Intrinsics| cameras.iter().filter(|camera| camera.intrinsics == *lens).count();
    let lenses = cameras.iter().map(|camera| camera.intrinsics).rev();
    let Some(most) = lenses.max_by_key(count) else {
        return Intrinsics::from_horizontal_angle(1, 1, 1.0);
    };
    let (width, height) = size.unwrap_or((most.width, most.height));
    let scale = f64::from(width) / f64::from(most.width);
    Intrinsics {
        width,
        height,
        fx: most.fx * scale,
        fy: most.fy * scale,
        cx: f64::from(width) / 2.0,
        cy: f64::from(height) / 2.0,
        projection: most.projection,
    }
}

/// A camera whose pictures are so many times as wide and high.
fn scaled(camera: &Camera, scale: f64) -> Camera {
    let Intrinsics { width, height, fx, fy, cx, cy, projection } = camera.intrinsics;
    let side = |side: u32| (f64::from(side) * scale).round() as u32;
    let intrinsics = Intrinsics {
        width: side(width),
        height: side(height),
        fx: fx * scale,
        fy: fy * scale,
        cx: cx * scale,
        cy: cy * scale,
        projection,
    };
    Camera { intrinsics, ..camera.clone() }
}

/// The capture with a few of its frames.
fn some_frames(capture: &Capture) -> Capture {
    let frames = capture.frame_count();
    if frames <= FRAMES {
        return capture.clone();
    }
    let shown: Vec<usize> = (0..FRAMES).map(|nth| nth * (frames - 1) / (FRAMES - 1)).collect();
    let numbers = shown.iter().map(|frame| capture.frame_numbers[*frame]).collect();
    with_reindexed_frames(capture, CACHE_BYTES, move |_, frame| shown[frame.min(FRAMES - 1)])
        .with_frame_numbers(numbers)
}

/// What the cameras look at.
fn middle(cameras: &[Camera], moments: &[Moment]) -> DVec3 {
    let first = cameras.first().map_or(DVec3::ZERO, Camera::position_in_world);
    let surfels = moments.iter().flat_map(|moment| &moment.surfels);
    let mut depths: Vec<f64> = surfels.map(|surfel| surfel.point_in_world.distance(first)).collect();
    pivot(cameras, median(&mut depths).unwrap_or(1.0))
}

#[cfg(test)]
mod tests;
