//! What concerns sweeps and stress tests.

use super::axis::Quantity;
use super::charts::Study;

/// What concerns sweeps and stress tests.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ChartCommand {
    Study(Study),
    Axes([Quantity; 2]),
    Disturbance(String),
}
