//! Lossless coding of the samples in a block of pixels: prediction from neighbors, then entropy coding of what is left.
//!
//! ```text
//! block ─ traversal: prediction, context ─▶ residual ─ integers ─▶ token + plain bits ─ rans, by the model of the context ─▶ bytes
//! ```

mod block_traversal;
mod coders;
mod integers;
mod model;
mod neighborhood;
mod plane_model;
mod rans;
mod table_fit;
mod value_traversal;
mod verdict_traversal;

pub(crate) use block_traversal::{BlockShape, BlockTraversal, Coder};
pub(crate) use coders::{
    ModelReader, ModelWriter, PlainReader, PlainWriter, TokenCounter, ValueCounter, ValueCounts, ValueReader,
    ValueWriter,
};
pub(crate) use model::{Counts, FrequencyTables};
pub(crate) use neighborhood::{BLOCK, BlockPixels, cell};
pub(crate) use plane_model::PlaneModel;
pub(crate) use value_traversal::{
    ChannelCoding, VALUE_CONTEXTS, VALUE_TOKENS, ValuePixels, ValuePredictor, ValueScale, traverse_values,
};
pub(crate) use verdict_traversal::{BlockVerdicts, VERDICT_CHANNELS, traverse_verdicts};
