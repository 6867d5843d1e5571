//! What is known: plain data.

pub(crate) mod axis;
pub(crate) mod charts;
pub(crate) mod command;
pub(crate) mod names;
pub(crate) mod sheet;
pub(crate) mod study;

pub(crate) use axis::{Quantity, ShownAxis, TICKS, coordinate, place};
pub(crate) use charts::{Charts, StudyQuestion};
pub(crate) use command::ChartCommand;
pub(crate) use names::{FRONT, START, kernel_name, method_name, point_name, series_name, settings_alone};
pub(crate) use sheet::sheet;
pub(crate) use study::{Study, StudyChoice, to_measure};
