//! What renderers write into the headers of OpenEXR files beside the picture.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};

use super::decoder_guard::guarded;
use crate::error::Result;
use crate::whole_file;

/// Attributes of a file, those of all its parts together; of several of one name the first.
#[derive(Clone, Debug, Default)]
pub(crate) struct HeaderAttributes {
    /// Columns and rows of the display window.
    pub size: (usize, usize),
    /// Channels of all parts, with `part.` before the name if there are several parts.
    pub channels: Vec<String>,
    texts: BTreeMap<String, String>,
    matrices: BTreeMap<String, [f64; 16]>,
}

impl HeaderAttributes {
    /// Reads the header of a file, and nothing behind it.
    ///
    /// # Errors
    /// `Io`, and `Invalid` for another file than OpenEXR and for a damaged header.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let place = path.display().to_string();
        let file = BufReader::new(whole_file::open(path)?);
        let meta = guarded(&place, || MetaData::read_from_buffered(file, false))?;
        let mut found = Self::default();
        let has_parts = meta.headers.len() > 1;
        for header in &meta.headers {
            let window = header.shared_attributes.display_window.size;
            found.size = (window.0, window.1);
            let part = header.own_attributes.layer_name.as_ref().filter(|_| has_parts);
            let prefix = part.map_or_else(String::new, |part| format!("{part}."));
            found.channels.extend(header.channels.list.iter().map(|it| format!("{prefix}{}", it.name)));
            let own = &header.own_attributes;
            let known =
                [("worldToCamera", own.world_to_camera), ("worldToNDC", own.world_to_normalized_device)];
            for (name, matrix) in known {
                if let Some(matrix) = matrix {
                    found.matrices.entry(name.to_owned()).or_insert(matrix.map(f64::from));
                }
            }
            let others = header.shared_attributes.other.iter().chain(&own.other);
            others.for_each(|(name, value)| found.take(name, value));
        }
        Ok(found)
    }

    fn take(&mut self, name: &Text, value: &AttributeValue) {
        let name = name.to_string();
        let text = match value {
            AttributeValue::Text(text) => text.to_string(),
            AttributeValue::F64(number) => number.to_string(),
            AttributeValue::F32(number) => number.to_string(),
            AttributeValue::I32(number) => number.to_string(),
            AttributeValue::Matrix4x4(matrix) => {
                self.matrices.entry(name).or_insert(matrix.map(f64::from));
                return;
            }
            _ => return,
        };
        self.texts.entry(name).or_insert(text);
    }

    /// A number that is stored as text or as a number.
    pub(crate) fn number(&self, name: &str) -> Option<f64> {
        self.texts.get(name)?.trim().parse().ok()
    }

    /// A 4×4 matrix row by row, as stored: points are rows before it.
    pub(crate) fn matrix(&self, name: &str) -> Option<[f64; 16]> {
        self.matrices.get(name).copied()
    }

    /// Whether an attribute's name starts so.
    pub(crate) fn has(&self, start: &str) -> bool {
        self.texts.keys().chain(self.matrices.keys()).any(|name| name.starts_with(start))
    }
}
