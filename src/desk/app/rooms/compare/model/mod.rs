//! What is known: plain data.

pub(crate) mod comparison;
pub(crate) mod key;
pub(crate) mod vantage;

pub(crate) use comparison::{
    CompareChoice, CompareKey, CompareLook, CompareMeasure, CompareMode, CompareSide, DisplayColors,
    PictureDifference, ShownComparison,
};
pub(crate) use vantage::CompareVantage;
