//! The chunk `DOUB`: which samples of all images are doubtful. FORMAT.md lists its bytes.

use std::collections::BTreeMap;

use super::header::ImageEntry;
use crate::capture::Camera;
use crate::samples::{TILE, TILE_SAMPLES};
use crate::store::container::{ByteReader, push_varint};
use crate::store::image::DoubtfulRuns;

/// The payload for the runs of images, by their place in the index, ascending.
pub(crate) fn encode_doubtful(images: &[(usize, DoubtfulRuns)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut next = 0;
    for (index, runs) in images {
        push_varint(&mut bytes, (index - next) as u64);
        next = index + 1;
        let lengths = runs.lengths();
        push_varint(&mut bytes, lengths.len() as u64);
        lengths.for_each(|length| push_varint(&mut bytes, u64::from(length)));
    }
    bytes
}

/// The runs of images, by their place in the index.
pub(crate) fn decode_doubtful(
    payload: &[u8],
    images: &[ImageEntry],
    cameras: &[Camera],
) -> Result<BTreeMap<usize, DoubtfulRuns>, String> {
    let mut reader = ByteReader::new(payload);
    let mut all = BTreeMap::new();
    let mut next = 0_usize;
    while !reader.rest.is_empty() {
        let index = next.saturating_add(reader.varint()? as usize);
        let entry = images.get(index).ok_or_else(|| format!("there is no image {index}"))?;
        next = index + 1;
        let (width, height) = cameras[entry.camera as usize].intrinsics.size();
        let pixels = width.div_ceil(TILE) * height.div_ceil(TILE) * TILE_SAMPLES;
        let count = reader.varint()?;
        // A run takes a byte at least.
        if count > reader.rest.len() as u64 {
            return Err("the chunk is too short".to_owned());
        }
        all.insert(index, DoubtfulRuns::from_lengths((0..count).map(|_| reader.varint()), pixels)?);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;
    use crate::samples::Span;
    use glam::DVec3;

    #[test]
    fn runs_come_back_for_the_images_that_have_some_and_what_names_no_image_is_refused() {
        let lens = Intrinsics::from_horizontal_angle(40, 20, 1.0);
        let cameras = [Camera::look_at("c", lens, DVec3::ZERO, DVec3::Y, DVec3::Z)];
        let entry = ImageEntry {
            camera: 0,
            span: Span { start: 0, end: 1 },
            samples: 1,
            tiles: 1,
            reference: None,
            offset: 0,
            length: 0,
            head: 0,
        };
        let images = vec![entry; 5];
        let runs =
            |lengths: &[u64]| DoubtfulRuns::from_lengths(lengths.iter().copied().map(Ok), 1536).unwrap();
        let written = [(1, runs(&[0, 300])), (3, runs(&[7, 1, 1000]))];
        let bytes = encode_doubtful(&written);
        assert_eq!(decode_doubtful(&bytes, &images, &cameras).unwrap(), BTreeMap::from(written));
        assert_eq!(decode_doubtful(&[], &images, &cameras).unwrap(), BTreeMap::new());
        assert!(decode_doubtful(&bytes, &images[..3], &cameras).unwrap_err().contains("no image 3"));
        for cut in 1..bytes.len() {
            let _ = decode_doubtful(&bytes[..cut], &images, &cameras);
        }
        assert!(decode_doubtful(&[0, 0xff, 0xff, 0x7f], &images, &cameras).is_err());
    }
}
