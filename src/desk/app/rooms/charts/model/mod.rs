//! What is known: plain data.

pub(crate) mod axis;
pub(crate) mod charts;
pub(crate) mod command;

pub(crate) use axis::Quantity;
pub(crate) use charts::{Study, method_name, point_name, series_name, settings_alone};
pub(crate) use command::ChartCommand;
