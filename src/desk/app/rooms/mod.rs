//! What the window does, one folder a feature: what is known of it (`state`) and asked (`mod.rs`), what is computed for it (`work`), how
//! commands and answers change it (`control`), and how it is drawn (`ui`).

pub(crate) mod cameras;
pub(crate) mod change;
pub(crate) mod charts;
pub(crate) mod colors;
pub(crate) mod compare;
pub(crate) mod edits;
pub(crate) mod files;
pub(crate) mod frame;
pub(crate) mod help;
pub(crate) mod live;
pub(crate) mod path;
pub(crate) mod pixel;
pub(crate) mod readings;
pub(crate) mod report;
pub(crate) mod settings;
pub(crate) mod share;
pub(crate) mod source;
pub(crate) mod timeline;
