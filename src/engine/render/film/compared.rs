//! Films that compare two sides from the same places: a line that moves over the picture once, or one side after the other.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::vantage::Picture;
use crate::settings::choice::choice;

choice! {
    /// How a film shows two sides.
    pub enum FilmComparison {
        /// A line moves from the right edge to the left one over the whole film; the first side is left of it, the second right.
        Wipe = "wipe",
        /// Each side for half a second, the first one first.
        Flip = "flip",
    }
}

/// How often a second the other side is shown.
const FLIPS_A_SECOND: f64 = 2.0;

impl FilmComparison {
    /// The column from which on picture `nth` of a film shows the second side, from 0 to `width`.
    #[must_use]
    pub fn split(self, nth: usize, pictures: usize, pictures_a_second: f64, width: usize) -> usize {
        match self {
            Self::Wipe => {
                let share = nth as f64 / pictures.saturating_sub(1).max(1) as f64;
                (width as f64 * (1.0 - share)).round() as usize
            }
            Self::Flip => {
                let flips = (nth as f64 / pictures_a_second * FLIPS_A_SECOND).floor();
                if flips % 2.0 == 0.0 { width } else { 0 }
            }
        }
    }
}

/// Paints the `pictures` of a film, and passes each on with its index and which sides it shows. `side` paints one of the two sides, 0 or
/// 1, of a picture; only sides that are seen are painted.
///
/// # Errors
/// Those of `side` and `take`; `Invalid` where the sides differ in size, and `Cancelled`.
pub fn paint_compared(
    how: FilmComparison,
    pictures: usize,
    pictures_a_second: f64,
    width: usize,
    job: &Job,
    mut side: impl FnMut(usize, usize) -> Result<Arc<Picture>>,
    mut take: impl FnMut(usize, &Picture, [bool; 2]) -> Result<()>,
) -> Result<()> {
    job.start("Rendering", pictures);
    for nth in 0..pictures {
        job.check()?;
        match how.split(nth, pictures, pictures_a_second, width) {
            0 => take(nth, &*side(1, nth)?, [false, true])?,
            split if split == width => take(nth, &*side(0, nth)?, [true, false])?,
            split => take(nth, &cut(&*side(0, nth)?, &*side(1, nth)?, split)?, [true, true])?,
        }
        job.advance(1);
    }
    Ok(())
}

/// Half the width of the line in pictures this wide, columns.
fn half_line(width: usize) -> usize {
    (width / 640).max(1)
}

/// One picture left of a column and another from there on, with a white line between black ones where they meet.
fn cut(left: &Picture, right: &Picture, split: usize) -> Result<Picture> {
    let [(width, height), (other_width, other_height)] = [left, right].map(|picture| picture.color.size());
    if (width, height) != (other_width, other_height) {
        let what = format!(
            "one side has {width}×{height} pixels and the other {other_width}×{other_height}: they cannot be laid over each other"
        );
        return Err(Error::invalid("comparison", what));
    }
    let mut picture = Picture::empty(width, height);
    let has_shares = !left.coverage.is_empty() || !right.coverage.is_empty();
    let half = half_line(width);
    for y in 0..height {
        for x in 0..width {
            let at = (x, y);
            let shown = if x < split { left } else { right };
            picture.color[at] = shown.color[at];
            picture.inverse_depth[at] = shown.inverse_depth[at];
            picture.image[at] = shown.image[at];
            let from_line = if x < split { split - 1 - x } else { x - split };
            if from_line < 2 * half {
                picture.color[at] = if from_line < half { [1.0; 3] } else { [0.0; 3] };
                // Also where nothing is shown beside it.
                picture.inverse_depth[at] = shown.inverse_depth[at].max(0.0);
            }
            if has_shares {
                picture.coverage.push(if from_line < 2 * half { 1.0 } else { shown.alpha(at) });
            }
        }
    }
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_crosses_the_picture_once_and_flips_take_half_a_second_each() {
        let wiped: Vec<_> = (0..5).map(|nth| FilmComparison::Wipe.split(nth, 5, 24.0, 100)).collect();
        assert_eq!(wiped, [100, 75, 50, 25, 0]);
        assert_eq!(FilmComparison::Wipe.split(0, 1, 24.0, 100), 100);
        let flipped: Vec<_> = (0..10).map(|nth| FilmComparison::Flip.split(nth, 10, 8.0, 100)).collect();
        assert_eq!(flipped, [100, 100, 100, 100, 0, 0, 0, 0, 100, 100]);
    }

    #[test]
    fn each_side_is_on_its_side_of_the_line_and_only_what_is_seen_is_painted() {
        let gray = |level: f32, width: usize| {
            let mut picture = Picture::empty(width, 2);
            picture.color.as_mut_slice().fill([level; 3]);
            Arc::new(picture)
        };
        let (mut painted, mut shown, mut seen) = (Vec::new(), Vec::new(), Vec::new());
        let side = |side, nth| {
            painted.push((side, nth));
            Ok(gray([0.2, 0.6][side], 20))
        };
        let take = |_, picture: &Picture, sides| {
            seen.push(sides);
            shown.push((0..20).map(|x| picture.color[(x, 1)][0]).collect::<Vec<_>>());
            Ok(())
        };
        paint_compared(FilmComparison::Wipe, 3, 24.0, 20, &Job::new(), side, take).unwrap();
        assert_eq!(painted, [(0, 0), (0, 1), (1, 1), (1, 2)]);
        assert_eq!(seen, [[true, false], [true, true], [false, true]]);
        let middle = [vec![0.2; 8], vec![0.0, 1.0, 1.0, 0.0], vec![0.6; 8]].concat();
        assert_eq!(shown, [vec![0.2; 20], middle, vec![0.6; 20]]);
        let unlike = |side, _| Ok(gray(0.5, [20, 24][side]));
        let error = paint_compared(FilmComparison::Wipe, 3, 24.0, 20, &Job::new(), unlike, |_, _, _| Ok(()));
        assert!(error.unwrap_err().to_string().contains("20×2 pixels and the other 24×2"));
    }
}
