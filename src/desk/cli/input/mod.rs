//! What commands read, and the options that several of them share.

mod budget_args;
mod fingerprint;
mod open;
mod options;
mod truth;
mod value_args;

pub(crate) use crate::pruned_store::{summed_up, sums_of};
pub(crate) use crate::ways_out::length;
pub(crate) use budget_args::BudgetArgs;
pub(crate) use fingerprint::{capture_state, pictures_state};
pub(crate) use open::{EditsArgs, RenderingArgs, StoreArgs, frame_index, open_capture};
pub(crate) use options::{HoldOutArgs, PaintingArgs, SettingsArgs, amount, choice, only_cameras};
pub(crate) use truth::TruthArgs;
pub(crate) use value_args::{BarredValueArgs, ShownValue, ValueArgs};
