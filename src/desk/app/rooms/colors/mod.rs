//! How colors and values are shown in both views.

pub(crate) mod model;
pub(crate) mod ui;
pub(crate) mod work;
