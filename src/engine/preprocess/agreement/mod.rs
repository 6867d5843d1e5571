//! Agreement between cameras: how noisy they are beside each other, which samples the others contradict, and the mean position and
//! color that confirming cameras give a surface.
//!
//! ```text
//! layers ─▶ measure: noise between cameras ─▶ votes on each sample: confirms, looks past, cannot tell ─▶ consensus
//! ```

mod consensus;
mod measure;
mod sample_agreement;
mod smooth_depth;
mod votes;

pub(crate) use consensus::{AgreedSample, Consensus};
pub(crate) use measure::{NoiseLattice, measure_noise_between, where_most_are_noisy};
pub use sample_agreement::SampleAgreement;
pub(crate) use smooth_depth::SmoothDepths;
pub(crate) use votes::{VoteTest, VotedRun};
