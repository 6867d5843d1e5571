//! What is known: plain data.

pub(crate) mod command;
pub(crate) mod comparison;
pub(crate) mod difference_text;
pub(crate) mod figure;
pub(crate) mod key;
pub(crate) mod sides;
pub(crate) mod vantage;

pub(crate) use command::CompareCommand;
pub(crate) use comparison::{
    CLASSES, CompareChoice, CompareInView, CompareKey, CompareLook, CompareMeasure, CompareMode, CompareSide,
    DisplayColors, PictureDifference, ShownComparison,
};
pub(crate) use difference_text::{about_pixel, figures};
pub(crate) use figure::{ComparisonFigure, ShownSides};
pub(crate) use vantage::CompareVantage;
