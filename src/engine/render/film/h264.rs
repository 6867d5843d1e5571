//! A stream of H.264 (ITU-T H.264): its NAL units, and the color space in the sequence parameter set, which the encoder leaves out.

/// Rec. 709 primaries, the sRGB curve, the Rec. 709 matrix: numbers of ITU-T H.273.
pub(super) const COLOR_SPACE: [u8; 3] = [1, 13, 1];

/// Kinds of NAL units.
pub(super) const SLICE: u8 = 1;
pub(super) const KEY_SLICE: u8 = 5;
pub(super) const SEQUENCE_PARAMETERS: u8 = 7;
pub(super) const PICTURE_PARAMETERS: u8 = 8;

/// The kind of a NAL unit; 0 for an empty one.
pub(super) fn kind(unit: &[u8]) -> u8 {
    unit.first().map_or(0, |header| header & 31)
}

/// The NAL units between start codes.
pub(super) fn units(stream: &[u8]) -> impl Iterator<Item = &[u8]> {
    let is_start = |at: &usize| stream[*at..].starts_with(&[0, 0, 1]);
    let starts: Vec<usize> = (0..stream.len().saturating_sub(2)).filter(is_start).collect();
    let ends = starts.clone().into_iter().skip(1).chain([stream.len()]);
    starts.into_iter().zip(ends).map(move |(start, end)| {
        let unit = &stream[start + 3..end];
        // A unit ends with a one; zeros behind it belong to the next start code.
        let zeros = unit.iter().rev().take_while(|byte| **byte == 0).count();
        &unit[..unit.len() - zeros]
    })
}

/// A sequence parameter set with the color space, and with the center of four pixels as the place of their color. `None` where it
/// does not end by the flag that nothing follows.
pub(super) fn with_color_space(sequence_parameters: &[u8]) -> Option<Vec<u8>> {
    let mut bits = Bits::of(&without_escapes(sequence_parameters));
    // The last one only marks the end. Before it is the flag that more follows.
    while bits.0.pop()? == 0 {}
    if bits.0.pop()? != 0 {
        return None;
    }
    bits.put(1, 1);
    // No aspect ratio, no overscan.
    bits.put(0, 2);
    // The signal follows: of no named television standard, of television range, with its colors.
    bits.put(1, 1);
    bits.put(5, 3);
    bits.put(0, 1);
    bits.put(1, 1);
    for number in COLOR_SPACE {
        bits.put(u32::from(number), 8);
    }
    // Where color lies follows: in the center (number 1, coded as 010), in both fields.
    bits.put(1, 1);
    bits.put(0b010, 3);
    bits.put(0b010, 3);
    // No timing, no buffer models, no timing of pictures, no restrictions.
    bits.put(0, 5);
    bits.put(1, 1);
    Some(with_escapes(&bits.bytes()))
}

/// Bits, one a byte.
struct Bits(Vec<u8>);

impl Bits {
    fn of(bytes: &[u8]) -> Self {
        Self(bytes.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1)).collect())
    }

    fn put(&mut self, number: u32, count: u32) {
        self.0.extend((0..count).rev().map(|bit| (number >> bit & 1) as u8));
    }

    fn bytes(&self) -> Vec<u8> {
        let byte = |bits: &[u8]| bits.iter().enumerate().fold(0, |byte, (at, bit)| byte | bit << (7 - at));
        self.0.chunks(8).map(byte).collect()
    }
}

/// Within a unit, 0 0 stands before a number up to 3 only as 0 0 3 and that number: start codes are found by their bytes alone.
fn without_escapes(unit: &[u8]) -> Vec<u8> {
    let is_escape = |at: usize| at >= 2 && unit[at] == 3 && unit[at - 2..at] == [0, 0];
    (0..unit.len()).filter(|at| !is_escape(*at)).map(|at| unit[at]).collect()
}

fn with_escapes(unit: &[u8]) -> Vec<u8> {
    let mut escaped = Vec::with_capacity(unit.len() + 4);
    for byte in unit {
        if *byte <= 3 && escaped.ends_with(&[0, 0]) {
            escaped.push(3);
        }
        escaped.push(*byte);
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_found_between_start_codes_of_three_and_four_bytes() {
        let stream = [0, 0, 0, 1, 0x67, 9, 0, 0, 3, 1, 0, 0, 1, 0x68, 7, 0, 0, 0, 1, 0x65, 8];
        let found: Vec<&[u8]> = units(&stream).collect();
        assert_eq!(found, [&[0x67, 9, 0, 0, 3, 1][..], &[0x68, 7], &[0x65, 8]]);
        assert_eq!(found.into_iter().map(kind).collect::<Vec<_>>(), [7, 8, 5]);
        assert_eq!((units(&[]).count(), units(&[0, 0, 1]).map(kind).collect::<Vec<_>>()), (0, vec![0]));
    }

    #[test]
    fn the_color_space_follows_what_the_sequence_says_of_itself() {
        // Some numbers, the flag that no more follows, the mark of the end.
        let plain = [0x67, 0x64, 0, 0x1e, 0b1010_1101, 0b1011_0010, 0b1000_0000];
        let told = without_escapes(&with_color_space(&plain).unwrap());
        let bits = Bits::of(&told).0;
        let kept = Bits::of(&plain).0;
        let flag =
            bits.len() - bits.iter().rev().position(|bit| *bit == 1).unwrap() - 1 - 5 - 7 - 24 - 6 - 2 - 1;
        assert_eq!(bits[..flag], kept[..flag]);
        let number =
            |from: usize, count: usize| bits[from..from + count].iter().fold(0, |n, bit| n * 2 + *bit);
        let colors = flag + 1 + 2 + 6;
        assert_eq!([0, 8, 16].map(|at| number(colors + at, 8)), COLOR_SPACE);
        assert_eq!(with_color_space(&[0x67, 0b1100_0000]), None, "the flag is set");
        assert_eq!(with_color_space(&[]), None);
    }

    #[test]
    fn bytes_that_look_like_a_start_code_are_escaped_and_come_back() {
        let bytes = [0, 0, 0, 0, 0, 1, 7, 0, 0, 3, 0, 0, 4];
        let escaped = with_escapes(&bytes);
        assert!(!escaped.windows(3).any(|three| three[..2] == [0, 0] && three[2] < 3), "{escaped:?}");
        assert_eq!(without_escapes(&escaped), bytes);
    }
}
