//! A whole store: its header, its writer and its reader.

mod chunks;
mod header;
mod provenance;
mod read_all;
mod reader;
mod writer;

pub(crate) use header::chain;
pub use header::{ImageEntry, MAX_REFERENCES, VERSION};
pub use provenance::{InputFiles, PlaneBytes, Provenance};
pub use reader::{Store, StoreInfo};
pub use writer::{Extras, write, write_spooled, write_to, write_with};
