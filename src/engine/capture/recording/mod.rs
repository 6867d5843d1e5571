//! One camera that moves through a static scene: stamps that are paired, and poses between the recorded ones.

mod greedy_cover;
mod pairing;
mod trajectory;
mod view_choice;

pub use greedy_cover::{Addition, CoveredSet, GreedyCover};
pub(crate) use pairing::nearest;
pub(crate) use trajectory::Trajectory;
pub use view_choice::ViewChoice;
