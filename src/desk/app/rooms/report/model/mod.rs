//! What is known: plain data.

pub(crate) mod held_memory;
pub(crate) mod table;
pub(crate) mod table_text;

pub(crate) use table::{Table, TableForm};
pub(crate) use table_text::table_text;
