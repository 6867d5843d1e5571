//! One camera that moves through a static scene: stamps that are paired, and poses between the recorded ones.

mod pairing;
mod trajectory;
mod view_choice;

pub(crate) use pairing::nearest;
pub(crate) use trajectory::Trajectory;
pub use view_choice::ViewChoice;
