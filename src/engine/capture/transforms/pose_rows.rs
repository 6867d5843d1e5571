//! The rows of `transform_matrix`, which some programs write as one list.

use serde::{Deserialize, Deserializer};
use serde_json::Value;

/// Rows as they are; of a list of 12 or 16 numbers the rows one after the other, four numbers each.
pub(super) fn rows<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Vec<f64>>, D::Error> {
    let value = Value::deserialize(deserializer)?;
    let is_flat = value.as_array().is_some_and(|list| list.first().is_some_and(Value::is_number));
    let named = |error: serde_json::Error| serde::de::Error::custom(format!("\"transform_matrix\": {error}"));
    if !is_flat {
        return Vec::<Vec<f64>>::deserialize(value).map_err(named);
    }
    let numbers = Vec::<f64>::deserialize(value).map_err(named)?;
    if !matches!(numbers.len(), 12 | 16) {
        let what =
            "\"transform_matrix\": it must have 4 rows of 4 numbers, or all 16 in one list, row by row";
        return Err(serde::de::Error::custom(what));
    }
    Ok(numbers.chunks(4).map(<[f64]>::to_vec).collect())
}
