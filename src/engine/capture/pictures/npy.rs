//! Depth in arrays of `NumPy`.
//!
//! Source: the NPY format (`NumPy` Enhancement Proposal 1): `\x93NUMPY`, version, length of the header, a Python dictionary with
//! `descr`, `fortran_order` and `shape`, then the values.

use half::f16;

use crate::capture::camera::is_believable_size;
use crate::error::{Error, Result, one_line};
use crate::plural::counted;

/// An array of two dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct NpyArray {
    /// Columns and rows.
    pub size: (usize, usize),
    /// Row by row.
    pub values: Vec<f32>,
    /// Whether they are whole numbers.
    pub is_whole: bool,
    /// Whether they are half floats.
    pub is_half: bool,
    /// Whether single precision holds every whole number of them; other numbers are rounded to it.
    pub is_exact: bool,
}

/// Reads an array of `height × width`, with or without further dimensions of 1.
///
/// # Errors
/// `Invalid` for a broken header and missing values, `Unsupported` for other types and shapes.
pub fn parse(bytes: &[u8], place: &str) -> Result<NpyArray> {
    let broken = |what: &str| {
        Error::invalid(place, format!("damaged, or not an array of NumPy ({what}); save it again"))
    };
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(broken("it does not start with \\x93NUMPY"));
    }
    let at = |index: usize| bytes.get(index).map(|byte| usize::from(*byte)).unwrap_or_default();
    let (start, length): (usize, usize) = match at(6) {
        1 => (10, at(8) | at(9) << 8),
        2 | 3 => (12, at(8) | at(9) << 8 | at(10) << 16 | at(11) << 24),
        version => return Err(broken(&format!("version {version}"))),
    };
    let header =
        bytes.get(start..start.saturating_add(length)).ok_or_else(|| broken("its header is cut short"))?;
    let header = String::from_utf8_lossy(header);
    let shape = shape_in(&header).ok_or_else(|| broken("its header has no shape"))?;
    let wide: Vec<usize> = shape.iter().copied().filter(|side| *side != 1).collect();
    let (height, width) = match (shape.as_slice(), wide.as_slice()) {
        ([height, width], _) | (_, [height, width]) => (*height, *width),
        _ => {
            let what = format!("the array has the shape {shape:?}; there must be rows and columns alone");
            return Err(Error::unsupported(place, what));
        }
    };
    if !is_believable_size(width, height) {
        return Err(broken(&format!("its header claims {width}×{height} pixels")));
    }
    let descr = quoted_after(&header, "descr").ok_or_else(|| broken("its header has no descr"))?;
    let (size, read, is_whole) = reader(descr).ok_or_else(|| {
        let descr = one_line(descr);
        Error::unsupported(place, format!("arrays of type '{descr}' are not read; save them as float32"))
    })?;
    let data = &bytes[start + length..];
    let needed = width * height * size;
    if data.len() < needed {
        return Err(broken(&format!("{} of values where {needed} are needed", counted(data.len(), "byte"))));
    }
    let mut values: Vec<f32> = data[..needed].chunks_exact(size).map(read).collect();
    if header.replace(' ', "").contains("'fortran_order':True") {
        values = (0..width * height).map(|index| values[index % width * height + index / width]).collect();
    }
    let is_exact = !is_whole || values.iter().all(|value| value.abs() < LARGEST_WHOLE);
    Ok(NpyArray { size: (width, height), values, is_whole, is_half: descr.ends_with("f2"), is_exact })
}

/// Whole numbers below this one are exact in single precision.
const LARGEST_WHOLE: f32 = 16_777_216.0;

type ReadValue = fn(&[u8]) -> f32;

/// Bytes of a value, how it is read, and whether it is whole.
fn reader(descr: &str) -> Option<(usize, ReadValue, bool)> {
    Some(match descr {
        "<f4" => (4, |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]), false),
        ">f4" => (4, |b| f32::from_be_bytes([b[0], b[1], b[2], b[3]]), false),
        "<f8" => (8, |b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]) as f32, false),
        "<f2" => (2, |b| f16::from_le_bytes([b[0], b[1]]).to_f32(), false),
        "<u2" => (2, |b| f32::from(u16::from_le_bytes([b[0], b[1]])), true),
        ">u2" => (2, |b| f32::from(u16::from_be_bytes([b[0], b[1]])), true),
        "<i2" => (2, |b| f32::from(i16::from_le_bytes([b[0], b[1]])), true),
        "<u4" => (4, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, true),
        "<i4" => (4, |b| i32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32, true),
        "<u8" => (8, |b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]) as f32, true),
        "<i8" => (8, |b| i64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]) as f32, true),
        "|u1" | "|b1" => (1, |b| f32::from(b[0]), true),
        "|i1" => (1, |b| f32::from(b[0].cast_signed()), true),
        _ => return None,
    })
}

/// The text in quotes behind a key.
fn quoted_after<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let rest = header.split_once(&format!("'{key}'"))?.1.split_once('\'')?.1;
    Some(rest.split_once('\'')?.0)
}

fn shape_in(header: &str) -> Option<Vec<usize>> {
    let rest = header.split_once("'shape'")?.1.split_once('(')?.1;
    let sides = rest.split_once(')')?.0.split(',').map(str::trim).filter(|side| !side.is_empty());
    sides.map(|side| side.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(header: &str, values: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(values);
        bytes
    }

    #[test]
    fn arrays_are_read_row_by_row_whatever_their_order() {
        let values: Vec<u8> =
            [1.0_f32, 2.0, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        let rows = array("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }", &values);
        assert_eq!(parse(&rows, "").unwrap().values, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let columns = array("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 3, 1), }", &values);
        let read = parse(&columns, "").unwrap();
        assert_eq!((read.size, read.values), ((3, 2), vec![1.0, 3.0, 5.0, 2.0, 4.0, 6.0]));
    }
}
