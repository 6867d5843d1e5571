//! One camera that moves through a static scene: stamps that are paired, and poses between the recorded ones.

mod pairing;
mod trajectory;

pub(crate) use pairing::nearest;
pub(crate) use trajectory::Trajectory;
