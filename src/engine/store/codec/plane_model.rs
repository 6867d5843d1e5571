//! The frequency tables of one plane of numbers: which of them each context uses.

use super::integers::join;
use super::rans::{FrequencyTable, SCALE, TOKENS};
use super::table_fit::{TokenCounts, frequencies, share_tables};
use crate::plural::counted;
use crate::store::container::{ByteReader, push_varint};

/// The tables of one plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct PlaneModel {
    /// Which table each context uses.
    table_of: Vec<u16>,
    tables: Vec<FrequencyTable>,
}

impl PlaneModel {
    /// The table of a context.
    #[inline(always)]
    pub(crate) fn table(&self, context: usize) -> &FrequencyTable {
        &self.tables[self.table_of[context] as usize]
    }

    /// How many tables there are.
    #[cfg(test)]
    pub(super) fn table_count(&self) -> usize {
        self.tables.len()
    }

    /// Tables with which what was counted in each context is coded shortly.
    ///
    /// # Errors
    /// Where a table cannot be made.
    pub(crate) fn fit(contexts: &[TokenCounts]) -> Result<Self, String> {
        let mut model = Self { table_of: Vec::new(), tables: Vec::new() };
        for (length, histogram) in share_tables(contexts) {
            model.table_of.resize(model.table_of.len() + length, model.tables.len() as u16);
            model.tables.push(FrequencyTable::new(&frequencies(&histogram))?);
        }
        Ok(model)
    }

    /// Bits that what was counted in each context takes by these tables.
    pub(crate) fn bits(&self, contexts: &[TokenCounts]) -> f64 {
        let tokens = contexts.iter().enumerate().flat_map(|(context, histogram)| {
            let table = self.table(context);
            let seen = histogram.iter().enumerate().filter(|(_, count)| **count > 0);
            seen.map(move |(token, count)| {
                let entropy = f64::from(SCALE).log2() - f64::from(table.frequency(token).max(1)).log2();
                f64::from(*count) * (entropy + f64::from(join(token).1))
            })
        });
        tokens.sum()
    }

    /// Appends the tables as FORMAT.md describes those of a plane in `MODL`.
    pub(crate) fn encode(&self, bytes: &mut Vec<u8>) {
        push_varint(bytes, self.tables.len() as u64);
        for (index, table) in self.tables.iter().enumerate() {
            push_varint(bytes, self.table_of.iter().filter(|of| **of == index as u16).count() as u64);
            let listed = (0..TOKENS).rev().find(|token| table.frequency(*token) > 0).map_or(0, |t| t + 1);
            push_varint(bytes, listed as u64);
            let mut token = 0;
            while token < listed {
                let frequency = table.frequency(token);
                push_varint(bytes, u64::from(frequency));
                token += 1;
                if frequency == 0 {
                    let more = (token..listed).take_while(|token| table.frequency(*token) == 0).count();
                    push_varint(bytes, more as u64);
                    token += more;
                }
            }
        }
    }

    /// Reads what [`PlaneModel::encode`] wrote, of a plane with so many contexts and tokens.
    ///
    /// # Errors
    /// Where the tables are not those of such a plane.
    pub(crate) fn decode(reader: &mut ByteReader, contexts: usize, tokens: usize) -> Result<Self, String> {
        let tables = reader.varint()? as usize;
        if tables == 0 || tables > contexts {
            return Err(format!("{} for {}", counted(tables, "table"), counted(contexts, "context")));
        }
        let mut model = Self { table_of: Vec::new(), tables: Vec::new() };
        for index in 0..tables {
            let length = reader.varint()?;
            if length > (contexts - model.table_of.len()) as u64 {
                return Err("tables for more contexts than there are".to_owned());
            }
            model.table_of.resize(model.table_of.len() + length as usize, index as u16);
            model.tables.push(decode_table(reader, tokens)?);
        }
        if model.table_of.len() < contexts {
            return Err("a context without a table".to_owned());
        }
        Ok(model)
    }
}

fn decode_table(reader: &mut ByteReader, tokens: usize) -> Result<FrequencyTable, String> {
    let listed = reader.varint()?;
    if listed > tokens as u64 {
        return Err(format!("a table of {listed} tokens"));
    }
    let mut frequencies = Vec::with_capacity(TOKENS);
    while frequencies.len() < listed as usize {
        let frequency = reader.varint()?;
        if frequency > u64::from(SCALE) {
            return Err(format!("a frequency of {frequency}"));
        }
        frequencies.push(frequency as u16);
        if frequency == 0 {
            let more = reader.varint()?;
            if more > listed - frequencies.len() as u64 {
                return Err("more tokens in a table than it lists".to_owned());
            }
            frequencies.resize(frequencies.len() + more as usize, 0);
        }
    }
    FrequencyTable::new(&frequencies)
}
