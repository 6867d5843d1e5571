//! Run-length encoding of bytes: the paper's "simple run-length encoding" (§3.2), in the form its file format, IFF,
//! already has.
//!
//! Source: Morrison, *"ILBM" IFF Interleaved Bitmap*, Electronic Arts 1986, appendix C (`ByteRun1`, also `PackBits`).
//! A control byte `n`, read as signed, stands before every packet:
//!
//! ```text
//!    0 ..  127   copy the n + 1 bytes that follow
//!   -1 .. -127   repeat the one byte that follows 1 - n times
//!         -128   nothing
//! ```
//!
//! What differs: packets may cross row ends (a plane is one row), and runs of two are left to the literal packet around
//! them, which is never longer.

/// Most bytes that one coded byte can stand for: a run of 128 takes two.
pub const MAX_EXPANSION: usize = 64;

const MAX_PACKET: usize = 128;
const MIN_RUN: usize = 3;

/// Encodes `bytes`. The result is never longer than `bytes.len() + bytes.len() / 128 + 1`.
#[must_use]
pub fn encode(bytes: &[u8]) -> Vec<u8> {
    let mut coded = Vec::with_capacity(bytes.len() / 2 + 16);
    let mut literals_start = 0;
    let mut position = 0;
    while position < bytes.len() {
        let run = run_length(&bytes[position..]);
        if run < MIN_RUN {
            position += run;
            continue;
        }
        push_literals(&mut coded, &bytes[literals_start..position]);
        coded.push((1 - run as i32) as i8 as u8);
        coded.push(bytes[position]);
        position += run;
        literals_start = position;
    }
    push_literals(&mut coded, &bytes[literals_start..]);
    coded
}

/// Decodes exactly `expected_len` bytes from all of `coded`.
///
/// # Errors
/// Says what is wrong where the packets end early, go on too long, or give another number of bytes. Nothing is
/// allocated where `expected_len` is more than [`MAX_EXPANSION`] times `coded`.
pub fn decode(coded: &[u8], expected_len: usize) -> Result<Vec<u8>, String> {
    if expected_len > coded.len().saturating_mul(MAX_EXPANSION) {
        return Err(format!("{} coded bytes cannot hold {expected_len}", coded.len()));
    }
    let mut bytes = Vec::with_capacity(expected_len);
    let mut rest = coded;
    while let Some((&control, after)) = rest.split_first() {
        rest = match control as i8 {
            -128 => after,
            control @ 0.. => {
                let count = control as usize + 1;
                let literals = after.get(..count).ok_or("the last packet is cut short")?;
                bytes.extend_from_slice(literals);
                &after[count..]
            }
            control => {
                let (&byte, after) = after.split_first().ok_or("the last packet is cut short")?;
                bytes.resize(bytes.len() + 1 + usize::from(control.unsigned_abs()), byte);
                after
            }
        };
        if bytes.len() > expected_len {
            return Err(format!("the packets hold more than {expected_len} bytes"));
        }
    }
    if bytes.len() < expected_len {
        return Err(format!("the packets hold {} bytes instead of {expected_len}", bytes.len()));
    }
    Ok(bytes)
}

/// Equal bytes at the start of `bytes`, at most a packet's worth.
fn run_length(bytes: &[u8]) -> usize {
    let first = bytes[0];
    bytes.iter().take(MAX_PACKET).take_while(|byte| **byte == first).count()
}

fn push_literals(coded: &mut Vec<u8>, literals: &[u8]) {
    for packet in literals.chunks(MAX_PACKET) {
        coded.push((packet.len() - 1) as u8);
        coded.extend_from_slice(packet);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn runs() -> impl Strategy<Value = Vec<u8>> {
        prop::collection::vec((any::<u8>(), 1..300_usize), 0..20)
            .prop_map(|runs| runs.into_iter().flat_map(|(byte, count)| vec![byte; count]).collect())
    }

    proptest! {
        #[test]
        fn decoding_undoes_encoding(bytes in prop_oneof![runs(), prop::collection::vec(0..3_u8, 0..2000)]) {
            let coded = encode(&bytes);
            prop_assert!(coded.len() <= bytes.len() + bytes.len() / 128 + 1);
            prop_assert_eq!(decode(&coded, bytes.len()).unwrap(), bytes);
        }

        #[test]
        fn any_bytes_decode_or_are_refused(coded in prop::collection::vec(any::<u8>(), 0..200), len in 0..400_usize) {
            if let Ok(bytes) = decode(&coded, len) {
                prop_assert_eq!(bytes.len(), len);
            }
        }
    }

    #[test]
    fn the_published_example_is_read() {
        // Apple Technical Note TN1023, "Understanding `PackBits`", which describes the same packets.
        let coded =
            [0xFE, 0xAA, 0x02, 0x80, 0x00, 0x2A, 0xFD, 0xAA, 0x03, 0x80, 0x00, 0x2A, 0x22, 0xF7, 0xAA];
        let bytes = [
            0xAA, 0xAA, 0xAA, 0x80, 0x00, 0x2A, 0xAA, 0xAA, 0xAA, 0xAA, 0x80, 0x00, 0x2A, 0x22, 0xAA, 0xAA,
            0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA, 0xAA,
        ];
        assert_eq!(decode(&coded, bytes.len()).unwrap(), bytes);
        assert_eq!(encode(&bytes), coded);
    }

    #[test]
    fn noise_grows_by_no_more_than_the_stated_bound() {
        let noise: Vec<u8> = (0..4096_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        assert!(encode(&noise).len() <= 4096 + 4096 / 128 + 1);
        assert_eq!(encode(&[]), Vec::<u8>::new());
        assert_eq!(encode(&[7; 128]).len(), 2);
    }

    #[test]
    fn a_bomb_is_refused_before_anything_is_allocated() {
        assert!(decode(&[0x81, 0], usize::MAX).is_err());
        assert!(decode(&[0x81, 0], 129).is_err());
        assert!(decode(&[], 1).is_err());
        assert!(decode(&[0x80; 64], 1).is_err());
    }

    #[test]
    fn packets_that_are_cut_short_or_too_long_are_refused() {
        assert!(decode(&[3, 1, 2], 4).is_err());
        assert!(decode(&[0xFE], 3).is_err());
        assert!(decode(&[0xFE, 1], 2).is_err());
        assert!(decode(&[0xFE, 1], 4).is_err());
    }
}
