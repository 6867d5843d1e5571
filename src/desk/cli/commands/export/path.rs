//! A camera path: the views of a file as the places of a film.

use std::path::Path;

use overlook_engine::capture::transforms::{self, Easing, PathFile, PathView};
use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::error::{Error, Result};
use overlook_engine::plural::counted;
use overlook_engine::render::Vantage;
use overlook_engine::render::film::{PathKey, pose_at};
use overlook_engine::store::file::StoreInfo;

/// A film: where from at which frame, and the number of each picture.
#[derive(Clone, Debug)]
pub(crate) struct Stops {
    pub(crate) vantages: Vec<Vantage>,
    pub(crate) numbers: Vec<i64>,
}

/// What is asked of a film beside its path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// The frame that all pictures show, by its number: a frozen moment.
    pub(crate) frame: Option<i64>,
    /// How many pictures are spread evenly over the path.
    pub(crate) pictures: Option<usize>,
    /// How the camera sets off and arrives over the whole path; where evenly, the file may say otherwise.
    pub(crate) easing: Easing,
    /// Pictures a second, for paths that say when the camera is where.
    pub(crate) rate: f64,
}

/// The places of a film.
///
/// A file that has every picture of a film (the window's and nerfstudio's do), several views at one frame, or a store of one frame makes
/// each view a picture. Else the views are keys, and there is one picture for every frame of the store from the first key to the last,
/// interpolated by [`pose_at`]; a single key is a still camera for all frames. Where the file says when the camera is at each view,
/// views are keys at these times. All pictures have the size of the first view. Easing changes where the camera is, not which frame
/// a picture shows.
///
/// # Errors
/// Those of reading the file, and `Invalid` for views at frames that the store has not.
pub(crate) fn along(path: &Path, store: &StoreInfo, pace: Pace) -> Result<Stops> {
    let mut file = transforms::open_path(path, store.provenance.frames_are_ranked)?;
    let Some(first) = file.views.first().cloned() else {
        return Err(Error::invalid(path.display(), "has no view"));
    };
    let held = held_frame(path, &file, store, pace)?;
    let mut numbers: Vec<i64> = file.views.iter().map(|view| view.frame_number).collect();
    numbers.sort_unstable();
    let are_distinct = numbers.windows(2).all(|pair| pair[0] < pair[1]);
    let is_every_view = file.is_film || held.is_some() || !are_distinct;
    let times = if let Some(seconds) = &file.seconds {
        seconds.clone()
    } else if is_every_view {
        (0..file.views.len()).map(|index| index as f64).collect()
    } else {
        let mut order: Vec<usize> = (0..file.views.len()).collect();
        order.sort_by_key(|index| file.views[*index].frame_number);
        file.easings = order.iter().map(|index| file.easings[*index]).collect();
        file.views.sort_by_key(|view| view.frame_number);
        file.views.iter().map(|view| view.frame_number as f64).collect()
    };
    let easing = if pace.easing == Easing::Linear { file.easing } else { pace.easing };
    let keys = times.into_iter().zip(&file.views);
    let keys = keys.map(|(time, view)| PathKey { time, world_from_camera: view.camera.world_from_camera });
    let film =
        Film { path, store, held, keys: keys.collect(), file: &file, lens: first.camera.intrinsics, easing };
    let is_eased = easing != Easing::Linear || file.easings.iter().any(|easing| *easing != Easing::Linear);
    match pace.pictures {
        Some(pictures) => film.spread(pictures),
        None if file.seconds.is_some() => film.spread(film.pictures_at(pace.rate)?),
        None if is_every_view && is_eased => film.spread(file.views.len()),
        None if is_every_view => film.every_view(),
        None => film.every_frame(),
    }
}

/// The most pictures of a film: `--pictures` has the same bound.
const MOST_PICTURES: f64 = 1e6;

/// The index of the frame that all pictures show: the one that was asked for, the only one, or the first where the file names none.
fn held_frame(path: &Path, file: &PathFile, store: &StoreInfo, pace: Pace) -> Result<Option<usize>> {
    if let Some(number) = pace.frame {
        return frame_of(path, store, number).map(Some);
    }
    let is_one = store.frame_numbers.len() == 1;
    Ok((is_one || (!file.names_frames && file.views.len() > 1)).then_some(0))
}

fn frame_of(path: &Path, store: &StoreInfo, number: i64) -> Result<usize> {
    store.frame_numbers.binary_search(&number).map_err(|_| {
        let frames = store.frame_numbers.first().zip(store.frame_numbers.last());
        let there =
            frames.map_or_else(String::new, |(first, last)| format!(", whose frames are {first} to {last}"));
        let what = format!(
            "there is no frame {number} in the store{there}; --frame NUMBER holds the scene at one of them"
        );
        Error::invalid(path.display(), what)
    })
}

/// A film that is being laid out.
struct Film<'a> {
    path: &'a Path,
    store: &'a StoreInfo,
    /// The frame of all pictures, if they show one.
    held: Option<usize>,
    file: &'a PathFile,
    /// When the camera is at each view: in seconds, frames, or views.
    keys: Vec<PathKey>,
    /// The first view's.
    lens: Intrinsics,
    /// Over the whole path.
    easing: Easing,
}

impl Film<'_> {
    /// The camera of a view, of the size of the first.
    fn camera(&self, view: &PathView) -> Camera {
        let own = view.camera.intrinsics;
        let intrinsics = if own.size() == self.lens.size() { own } else { self.lens };
        Camera { intrinsics, ..view.camera.clone() }
    }

    fn frame_of_view(&self, view: &PathView) -> Result<usize> {
        self.held.map_or_else(|| frame_of(self.path, self.store, view.frame_number), Ok)
    }

    fn every_view(&self) -> Result<Stops> {
        let vantage =
            |view: &PathView| Ok(Vantage { camera: self.camera(view), frame: self.frame_of_view(view)? });
        let vantages = self.file.views.iter().map(vantage).collect::<Result<Vec<_>>>()?;
        Ok(Stops { numbers: (1..=vantages.len() as i64).collect(), vantages })
    }

    fn every_frame(&self) -> Result<Stops> {
        let views = &self.file.views;
        let [from, to] = [views.first(), views.last()].map(|view| view.map_or(0, |view| view.frame_number));
        let mut stops = Stops { vantages: Vec::new(), numbers: Vec::new() };
        for (frame, &number) in self.store.frame_numbers.iter().enumerate() {
            if views.len() > 1 && !(from..=to).contains(&number) {
                continue;
            }
            stops.vantages.push(Vantage { camera: self.between(number as f64), frame });
            stops.numbers.push(number);
        }
        if stops.numbers.is_empty() {
            return Err(Error::invalid(self.path.display(), "no view is at a frame of the store"));
        }
        Ok(stops)
    }

    /// How many pictures a path of seconds has at a rate, both ends included.
    fn pictures_at(&self, rate: f64) -> Result<usize> {
        let seconds = self.ends().map_or(0.0, |[from, to]| to - from);
        let pictures = (seconds * rate).round() + 1.0;
        if pictures < MOST_PICTURES {
            return Ok(pictures as usize);
        }
        let length = counted(seconds, "second");
        let what = format!("a film of {length} has too many pictures; path_time is in seconds");
        Err(Error::invalid(self.path.display(), what))
    }

    fn ends(&self) -> Option<[f64; 2]> {
        self.keys.first().zip(self.keys.last()).map(|(from, to)| [from.time, to.time])
    }

    /// Pictures at equal steps of time, from the first view to the last.
    fn spread(&self, pictures: usize) -> Result<Stops> {
        let Some([from, to]) = self.ends() else { return self.every_view() };
        let vantage = |picture: usize| {
            let time = from + (to - from) * picture as f64 / pictures.saturating_sub(1).max(1) as f64;
            let frame = self.held.unwrap_or_else(|| self.nearest_frame(self.number_at(time)));
            Vantage { camera: self.between(time), frame }
        };
        Ok(Stops { vantages: (0..pictures).map(vantage).collect(), numbers: (1..=pictures as i64).collect() })
    }

    /// The views before and after a time, and its share of the way from one to the other.
    fn leg(&self, time: f64) -> ([usize; 2], f64) {
        let before = self.keys.partition_point(|key| key.time <= time).saturating_sub(1);
        let after = (before + 1).min(self.keys.len() - 1);
        let length = self.keys[after].time - self.keys[before].time;
        let share = if length > 0.0 { (time - self.keys[before].time) / length } else { 0.0 };
        ([before, after], share.clamp(0.0, 1.0))
    }

    /// The number of the frame at a time, with fractions.
    fn number_at(&self, time: f64) -> f64 {
        let (leg, share) = self.leg(time);
        let [from, to] = leg.map(|view| self.file.views[view].frame_number as f64);
        from + (to - from) * share
    }

    /// The camera at a time.
    fn between(&self, time: f64) -> Camera {
        let first = &self.file.views[0].camera;
        let [from, to] = self.ends().unwrap_or([time; 2]);
        let time =
            if to > from { from + (to - from) * self.easing.way((time - from) / (to - from)) } else { time };
        let (leg, share) = self.leg(time);
        let [from, to] = leg.map(|view| self.keys[view].time);
        let eased = from + (to - from) * self.file.easings[leg[0]].way(share);
        let world_from_camera = pose_at(&self.keys, eased).unwrap_or(first.world_from_camera);
        Camera { intrinsics: self.lens, world_from_camera, ..first.clone() }
    }

    fn nearest_frame(&self, number: f64) -> usize {
        let apart = |other: i64| (other as f64 - number).abs();
        let numbers = self.store.frame_numbers.iter().enumerate();
        numbers.min_by(|(_, a), (_, b)| apart(**a).total_cmp(&apart(**b))).map_or(0, |(frame, _)| frame)
    }
}
