//! The pictures of a film that shows both sides of a comparison.

use std::sync::Arc;

use crate::app::model::Same;
use crate::app::rooms::compare::model::CompareKey;
use crate::app::rooms::compare::work::compare::Comparer;
use crate::app::rooms::share::model::ComparedFilm;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::render::film::{self, FilmSource};
use overlook_engine::render::{Picture, Vantage};
use overlook_lab::chart::SideNames;

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
