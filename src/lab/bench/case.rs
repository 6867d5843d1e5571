//! A measurement of stages, and its inputs.

use super::measure::RepeatLimits;
use super::report::MeasuredStage;
use super::scene::BenchScene;
use overlook_engine::error::Result;
use overlook_engine::job::Job;

/// What every measurement needs.
#[derive(Clone, Copy)]
pub(super) struct Bench<'a> {
    pub(super) scene: &'a BenchScene,
    pub(super) budget: RepeatLimits,
    pub(super) job: &'a Job,
}

/// Does a piece of work over and over, with the threads of the current pool.
pub(super) type Measure<T> = Box<dyn Fn(&Bench<'_>) -> Result<T> + Send + Sync>;

/// Something to measure, with the threads of the current pool; its stages are measured together.
pub(super) struct Case {
    pub(super) names: Vec<String>,
    pub(super) measure: Measure<Vec<MeasuredStage>>,
}
