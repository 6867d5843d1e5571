//! A whole store: its header, its writer and its reader.

mod chunks;
mod doubtful;
mod header;
mod info;
mod provenance;
mod read_all;
mod reader;
mod report_chunk;
mod value_chunks;
mod writer;

pub use crate::store::container::ReadAt;
pub use crate::store::image::{BlockEntry, ImageHead};
pub use header::ImageEntry;
pub(crate) use header::chain;
pub use info::StoreInfo;
pub use provenance::{InputFiles, PlaneBytes, Provenance};
pub use reader::Store;
pub use value_chunks::StoredValues;
pub use writer::{Extras, write, write_spooled, write_to, write_with};
