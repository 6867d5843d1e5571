//! What commands read.

mod fingerprint;
mod hold_out;
mod truth;

pub(crate) use fingerprint::input_files;
pub(crate) use hold_out::HoldOutArgs;
pub(crate) use truth::TruthArgs;
