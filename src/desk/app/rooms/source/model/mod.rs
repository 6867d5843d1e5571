//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod look;
pub(crate) mod picture;
pub(crate) mod picture_zoom;

pub(crate) use command::SourceCommand;
pub(crate) use look::SourceLook;
pub(crate) use picture::{
    Legend, Overlay, RATIO_RANGE, SourceKey, SourcePicture, VIEW_DEPENDENCE_RANGE, ranked,
};
pub(crate) use picture_zoom::PictureZoom;
