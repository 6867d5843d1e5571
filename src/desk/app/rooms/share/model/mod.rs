//! What is known: plain data.

pub(crate) mod figure;
pub(crate) mod film;
pub(crate) mod share;
pub(crate) mod size;

pub(crate) use figure::{DOTS_PER_INCH, FigureOf, FigureOptions, FigureWidth};
pub(crate) use film::{ComparedFilm, FilmLook};
pub(crate) use share::{
    PictureFacts, ShareCommand, ShareFacts, ShareKey, ShareOptions, ShareOutcome, SharePreview,
    SharePreviewKey, ShareWay, SharedPictures, ShownPreview,
};
