//! What concerns sweeps and stress tests.

use super::axis::ShownAxis;
use super::study::{Study, StudyChoice};
use overlook_lab::chart::Scale;

/// What concerns sweeps and stress tests.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ChartCommand {
    /// Measure what is chosen.
    Study(Study),
    Axes([ShownAxis; 2]),
    Disturbance(String),
    /// Ask what to measure and for how long; close the question by `None`.
    Ask(Option<Study>),
    /// Choose what to measure.
    Choose(Study, Box<StudyChoice>),
    /// Leave a series of a chart out, by its name, or show it again.
    Toggle(Study, String),
    /// Copy a chart as a picture.
    Copy(Study),
    /// How the sizes of disturbances are spread.
    DialScale(Scale),
}
