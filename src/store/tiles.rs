//! A sample image as planes of bytes, and back.
//!
//! ```text
//! occupancy   one bit per tile of the picture, row-major, high bit first: does the tile hold a sample?
//! masks       right halves of all tile rows, then left halves                           16 bytes a tile each
//! color       red high, red low, green high, green low, blue high, blue low             one byte a sample each
//! depth       highest byte … lowest byte of the inverse depth                           one byte a sample each
//! normal      first and second octahedral coordinate, where there are normals           one byte a sample each
//! ```
//!
//! Only occupied tiles have masks, only set pixels have samples. Bytes of equal weight stand together (Masui et al., *A
//! compression scheme for radio data in high performance computing*, 2015, call it shuffling), each number as its
//! difference to the one before (zigzag-coded, so that small differences of either sign have zero high bytes): what
//! run-length encoding can use of smooth pictures is there, in runs of zeros.

use half::f16;

use crate::capture::Camera;
use crate::preprocess::{DepthPlane, OctNormal, SampleImage, SampleTile, Span, TILE};

use super::bytes::ByteReader;
use super::codec::{append_plane, take_plane};

const HAS_NORMALS: u8 = 1;

/// Columns and rows of tiles over the picture of a camera.
fn tile_grid(camera: &Camera) -> (usize, usize) {
    let (width, height) = camera.intrinsics.size();
    (width.div_ceil(TILE), height.div_ceil(TILE))
}

/// Checks the promises of [`SampleImage`], so that what is written can be read and what was read can be trusted.
pub(super) fn check(image: &SampleImage, cameras: &[Camera], frames: usize) -> Result<(), String> {
    let camera = cameras.get(image.camera as usize).ok_or_else(|| format!("no camera {}", image.camera))?;
    if image.span.start >= image.span.end || image.span.end as usize > frames {
        return Err(format!("no frames {} to {}", image.span.start, image.span.end));
    }
    let (width, height) = camera.intrinsics.size();
    let mut first = 0;
    let mut last_place = None;
    for tile in &image.tiles {
        let place = Some((tile.tile_y, tile.tile_x));
        let (left, top) = (tile.tile_x as usize * TILE, tile.tile_y as usize * TILE);
        if place <= last_place || left >= width || top >= height {
            return Err("a tile is out of order or outside the picture".to_owned());
        }
        let beyond_right = |row: &u16| (width - left) < TILE && row >> (width - left) != 0;
        let beyond_bottom = tile.rows.iter().skip(height - top).any(|row| *row != 0);
        if tile.rows.iter().any(beyond_right) || beyond_bottom {
            return Err("a sample lies outside the picture".to_owned());
        }
        if tile.first as usize != first || tile.count() == 0 {
            return Err("a tile is empty or its samples are out of order".to_owned());
        }
        first += tile.count();
        last_place = place;
    }
    let normals = image.normal.as_ref().map_or(first, Vec::len);
    if [image.color.len(), normals] != [first; 2] || !image.depth.fits(&image.tiles) {
        return Err("the planes do not have one value per sample".to_owned());
    }
    if image.inverse_depths().iter().any(|w| !w.is_finite() || *w < 0.0) {
        return Err("an inverse depth is negative or not finite".to_owned());
    }
    if image.color.iter().flatten().any(|value| !value.is_finite()) {
        return Err("a color is not finite".to_owned());
    }
    Ok(())
}

/// The payload of an image's chunk. The image must have passed [`check`].
pub(super) fn encode(image: &SampleImage, camera: &Camera) -> Vec<u8> {
    let mut payload = Vec::with_capacity(image.bytes() / 2);
    for number in
        [image.camera, image.span.start, image.span.end, image.tiles.len() as u32, image.len() as u32]
    {
        payload.extend_from_slice(&number.to_be_bytes());
    }
    payload.push(if image.normal.is_some() { HAS_NORMALS } else { 0 });

    let (tiles_x, tiles_y) = tile_grid(camera);
    let mut occupancy = vec![0_u8; (tiles_x * tiles_y).div_ceil(8)];
    for tile in &image.tiles {
        let place = tile.tile_y as usize * tiles_x + tile.tile_x as usize;
        occupancy[place / 8] |= 0x80 >> (place % 8);
    }
    append_plane(&mut payload, &occupancy);
    let rows: Vec<u16> = image.tiles.iter().flat_map(|tile| tile.rows).collect();
    append_plane(&mut payload, &rows.iter().map(|row| (row >> 8) as u8).collect::<Vec<_>>());
    append_plane(&mut payload, &rows.iter().map(|row| *row as u8).collect::<Vec<_>>());
    for channel in 0..3 {
        let deltas = deltas_16(image.color.iter().map(|color| color[channel].to_bits()));
        append_byte_planes(&mut payload, &deltas);
    }
    append_byte_planes(&mut payload, &deltas_32(image.inverse_depths().iter().map(|w| w.to_bits())));
    if let Some(normals) = &image.normal {
        for axis in 0..2 {
            append_plane(&mut payload, &deltas_8(normals.iter().map(|normal| normal.0[axis] as u8)));
        }
    }
    payload
}

/// Reads back what [`encode`] wrote, and checks it.
///
/// Every plane is held against its code's length before it is allocated, so that an image never takes more than about
/// a hundred times the bytes of its chunk.
pub(super) fn decode(payload: &[u8], cameras: &[Camera], frames: usize) -> Result<SampleImage, String> {
    let mut reader = ByteReader::new(payload);
    let camera_index = reader.u32()?;
    let span = Span { start: reader.u32()?, end: reader.u32()? };
    let (tile_count, sample_count) = (reader.u32()? as usize, reader.u32()? as usize);
    let flags = reader.u8()?;
    if flags & !HAS_NORMALS != 0 {
        return Err(format!("unknown flags {flags}; a newer Overlook may read it"));
    }
    let camera = cameras.get(camera_index as usize).ok_or_else(|| format!("no camera {camera_index}"))?;
    let tiles = decode_tiles(&mut reader, camera, tile_count)?;
    if tiles.iter().map(SampleTile::count).sum::<usize>() != sample_count {
        return Err("the masks do not hold as many samples as the chunk says".to_owned());
    }
    let mut channels = [Vec::new(), Vec::new(), Vec::new()];
    for channel in &mut channels {
        let [high, low] = take_byte_planes(&mut reader, sample_count)?;
        *channel = values_16(&high, &low);
    }
    let [red, green, blue] = channels;
    let color = red.iter().zip(&green).zip(&blue).map(|((r, g), b)| [*r, *g, *b].map(f16::from_bits));
    let depth_bits = values_32(&take_byte_planes(&mut reader, sample_count)?);
    let inverse_depth: Vec<f32> = depth_bits.into_iter().map(f32::from_bits).collect();
    let normal = if flags & HAS_NORMALS == 0 {
        None
    } else {
        let [first, second] = take_byte_planes(&mut reader, sample_count)?.map(|plane| values_8(&plane));
        Some(first.into_iter().zip(second).map(|(a, b)| OctNormal([a as i8, b as i8])).collect())
    };
    reader.finish()?;
    let depth = DepthPlane::pack(&tiles, &inverse_depth);
    let image = SampleImage { camera: camera_index, span, tiles, color: color.collect(), depth, normal };
    check(&image, cameras, frames)?;
    Ok(image)
}

fn decode_tiles(
    reader: &mut ByteReader,
    camera: &Camera,
    tile_count: usize,
) -> Result<Vec<SampleTile>, String> {
    let (tiles_x, tiles_y) = tile_grid(camera);
    let occupancy = take_plane(&mut reader.rest, (tiles_x * tiles_y).div_ceil(8))?;
    let occupied = occupancy.iter().map(|byte| byte.count_ones() as usize).sum::<usize>();
    if occupied != tile_count {
        return Err("the occupancy does not hold as many tiles as the chunk says".to_owned());
    }
    let [high, low] = take_byte_planes(reader, tile_count * TILE)?;
    let places = (0..occupancy.len() * 8).filter(|place| occupancy[place / 8] & (0x80 >> (place % 8)) != 0);
    let mut tiles = Vec::with_capacity(tile_count);
    let mut first = 0;
    for (place, (high, low)) in places.zip(high.chunks(TILE).zip(low.chunks(TILE))) {
        let rows = std::array::from_fn(|row| u16::from_be_bytes([high[row], low[row]]));
        let tile =
            SampleTile { tile_x: (place % tiles_x) as u16, tile_y: (place / tiles_x) as u16, first, rows };
        // A tile has at most 256 samples and a picture at most 2^26 tiles, so only an absurd picture saturates; its
        // count then contradicts the chunk's.
        first = first.saturating_add(tile.count() as u32);
        tiles.push(tile);
    }
    Ok(tiles)
}

/// Appends the bytes of big-endian numbers, those of equal weight together.
fn append_byte_planes<const N: usize>(payload: &mut Vec<u8>, numbers: &[[u8; N]]) {
    for byte in 0..N {
        append_plane(payload, &numbers.iter().map(|number| number[byte]).collect::<Vec<_>>());
    }
}

fn take_byte_planes<const N: usize>(reader: &mut ByteReader, count: usize) -> Result<[Vec<u8>; N], String> {
    let mut planes = [const { Vec::new() }; N];
    for plane in &mut planes {
        *plane = take_plane(&mut reader.rest, count)?;
    }
    Ok(planes)
}

fn deltas_8(values: impl Iterator<Item = u8>) -> Vec<u8> {
    let mut before = 0_u8;
    values.map(|value| value.wrapping_sub(std::mem::replace(&mut before, value))).collect()
}

fn values_8(deltas: &[u8]) -> Vec<u8> {
    let mut value = 0_u8;
    deltas
        .iter()
        .map(|delta| {
            value = value.wrapping_add(*delta);
            value
        })
        .collect()
}

fn deltas_16(values: impl Iterator<Item = u16>) -> Vec<[u8; 2]> {
    let mut before = 0_u16;
    let zigzag = |delta: u16| (delta << 1) ^ ((delta as i16 >> 15) as u16);
    values
        .map(|value| zigzag(value.wrapping_sub(std::mem::replace(&mut before, value))).to_be_bytes())
        .collect()
}

fn values_16(high: &[u8], low: &[u8]) -> Vec<u16> {
    let mut value = 0_u16;
    let undo = |bytes: u16| (bytes >> 1) ^ (bytes & 1).wrapping_neg();
    high.iter()
        .zip(low)
        .map(|(high, low)| {
            value = value.wrapping_add(undo(u16::from_be_bytes([*high, *low])));
            value
        })
        .collect()
}

fn deltas_32(values: impl Iterator<Item = u32>) -> Vec<[u8; 4]> {
    let mut before = 0_u32;
    let zigzag = |delta: u32| (delta << 1) ^ ((delta as i32 >> 31) as u32);
    values
        .map(|value| zigzag(value.wrapping_sub(std::mem::replace(&mut before, value))).to_be_bytes())
        .collect()
}

fn values_32(planes: &[Vec<u8>; 4]) -> Vec<u32> {
    let mut value = 0_u32;
    let undo = |bytes: u32| (bytes >> 1) ^ (bytes & 1).wrapping_neg();
    (0..planes[0].len())
        .map(|index| {
            value =
                value.wrapping_add(undo(u32::from_be_bytes([0, 1, 2, 3].map(|p: usize| planes[p][index]))));
            value
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn differences_add_up_to_the_values(values in prop::collection::vec(any::<u32>(), 0..50)) {
            let deltas = deltas_32(values.iter().copied());
            let planes = std::array::from_fn(|byte| deltas.iter().map(|delta| delta[byte]).collect());
            prop_assert_eq!(values_32(&planes), values.clone());

            let halves: Vec<u16> = values.iter().map(|value| *value as u16).collect();
            let deltas = deltas_16(halves.iter().copied());
            let high: Vec<u8> = deltas.iter().map(|delta| delta[0]).collect();
            let low: Vec<u8> = deltas.iter().map(|delta| delta[1]).collect();
            prop_assert_eq!(values_16(&high, &low), halves);

            let bytes: Vec<u8> = values.iter().map(|value| *value as u8).collect();
            prop_assert_eq!(values_8(&deltas_8(bytes.iter().copied())), bytes);
        }
    }

    #[test]
    fn small_differences_of_either_sign_have_zero_high_bytes() {
        assert_eq!(deltas_16([5, 4, 6].into_iter()), [[0, 10], [0, 1], [0, 4]]);
        assert_eq!(deltas_32([5, 4].into_iter()), [[0, 0, 0, 10], [0, 0, 0, 1]]);
    }
}
