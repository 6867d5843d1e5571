//! A whole store: its header, its writer and its reader.

mod chunks;
mod header;
mod info;
mod reader;
mod value_chunks;
mod verdict_chunk;
mod writer;

pub use super::container::ReadAt;
pub use super::image::{BlockEntry, ImageHead};
pub(crate) use header::chain;
pub use header::{ImageEntry, InputFiles, PlaneBytes, Provenance};
pub use info::StoreInfo;
pub use reader::Store;
pub use value_chunks::StoredValues;
pub use writer::{Extras, write, write_spooled, write_to, write_with};
