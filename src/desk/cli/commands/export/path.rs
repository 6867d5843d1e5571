//! A camera path: the views of a file as the places of a film.

use std::path::Path;

use overlook_engine::capture::transforms::{self, PathFile, PathView};
use overlook_engine::capture::{Camera, Intrinsics};
use overlook_engine::error::{Error, Result};
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
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pace {
    /// The frame that all pictures show, by its number: a frozen moment.
    pub(crate) frame: Option<i64>,
    /// How many pictures are spread evenly over the path.
    pub(crate) pictures: Option<usize>,
}

/// The places of a film.
///
/// A file that has every picture of a film (the window's and nerfstudio's do), several views at one frame, or a store of one frame makes
/// each view a picture. Else the views are keys, and there is one picture for every frame of the store from the first key to the last,
/// interpolated by [`pose_at`]; a single key is a still camera for all frames. All pictures have the size of the first view.
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
    if !is_every_view {
        file.views.sort_by_key(|view| view.frame_number);
    }
    let film = Film { path, store, held, views: &file.views, lens: first.camera.intrinsics };
    match pace.pictures {
        Some(pictures) => film.spread(pictures, is_every_view),
        None if is_every_view => film.every_view(),
        None => film.every_frame(),
    }
}

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
    views: &'a [PathView],
    /// Of the first view.
    lens: Intrinsics,
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
        let vantages = self.views.iter().map(vantage).collect::<Result<Vec<_>>>()?;
        Ok(Stops { numbers: (1..=vantages.len() as i64).collect(), vantages })
    }

    fn every_frame(&self) -> Result<Stops> {
        let keys = self.keys(|_, view| view.frame_number as f64);
        let [from, to] =
            [self.views.first(), self.views.last()].map(|view| view.map_or(0, |view| view.frame_number));
        let mut stops = Stops { vantages: Vec::new(), numbers: Vec::new() };
        for (frame, &number) in self.store.frame_numbers.iter().enumerate() {
            if self.views.len() > 1 && !(from..=to).contains(&number) {
                continue;
            }
            stops.vantages.push(Vantage { camera: self.between(&keys, number as f64), frame });
            stops.numbers.push(number);
        }
        if stops.numbers.is_empty() {
            return Err(Error::invalid(self.path.display(), "no view is at a frame of the store"));
        }
        Ok(stops)
    }

    /// Pictures at equal steps: from view to view, or from the first frame to the last where views are keys.
    fn spread(&self, pictures: usize, is_every_view: bool) -> Result<Stops> {
        let keys =
            self.keys(|index, view| if is_every_view { index as f64 } else { view.frame_number as f64 });
        let (Some(from), Some(to)) = (keys.first(), keys.last()) else { return self.every_view() };
        let vantage = |picture: usize| {
            let time =
                from.time + (to.time - from.time) * picture as f64 / pictures.saturating_sub(1).max(1) as f64;
            let number = if is_every_view {
                let at = (time as usize).min(self.views.len() - 1);
                let next = (at + 1).min(self.views.len() - 1);
                let [a, b] = [at, next].map(|index| self.views[index].frame_number as f64);
                a + (b - a) * time.fract()
            } else {
                time
            };
            let frame = self.held.unwrap_or_else(|| self.nearest_frame(number));
            Vantage { camera: self.between(&keys, time), frame }
        };
        Ok(Stops { vantages: (0..pictures).map(vantage).collect(), numbers: (1..=pictures as i64).collect() })
    }

    fn keys(&self, time: impl Fn(usize, &PathView) -> f64) -> Vec<PathKey> {
        let key = |(index, view): (usize, &PathView)| PathKey {
            time: time(index, view),
            world_from_camera: view.camera.world_from_camera,
        };
        self.views.iter().enumerate().map(key).collect()
    }

    fn between(&self, keys: &[PathKey], time: f64) -> Camera {
        let first = &self.views[0].camera;
        let world_from_camera = pose_at(keys, time).unwrap_or(first.world_from_camera);
        Camera { intrinsics: self.lens, world_from_camera, ..first.clone() }
    }

    fn nearest_frame(&self, number: f64) -> usize {
        let apart = |other: i64| (other as f64 - number).abs();
        let numbers = self.store.frame_numbers.iter().enumerate();
        numbers.min_by(|(_, a), (_, b)| apart(**a).total_cmp(&apart(**b))).map_or(0, |(frame, _)| frame)
    }
}
