//! One file per subcommand.

pub(super) mod align;
pub(super) mod demo;
pub(super) mod edit;
pub(super) mod evaluate;
pub(super) mod export;
pub(super) mod info;
pub(super) mod place;
pub(super) mod preprocess;
pub(super) mod render;
pub(super) mod report;
pub(super) mod settings;
pub(super) mod stress;
pub(super) mod sweep;
pub(super) mod tune;
pub(super) mod verify;
