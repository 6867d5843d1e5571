//! What accuracy costs: sweeps and stress tests as charts.

pub(crate) mod control;
pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
