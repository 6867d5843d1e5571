//! MPEG immersive video: sequences as TMIV and RVS read them, a JSON file of cameras beside raw video of texture and depth.
//!
//! Source: TMIV's `SequenceConfig` and `ViewParamsList`, RVS's `Parameters`. World and camera have x forward, y left, z up; poses are
//! camera to world, turned by yaw about z, pitch about y and roll about x: `R = Rz(yaw) · Ry(pitch) · Rx(roll)`. Pixel centers lie at
//! +0.5. Depth is planar (x) for perspective cameras: `1/z = 1/far + level/largest · (1/near − 1/far)`.

mod sequence;
mod write;

pub(crate) use sequence::{SequenceCamera, SequenceFile, pose, projection};
pub use write::write_sequence;
