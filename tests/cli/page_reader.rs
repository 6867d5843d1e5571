//! Reads an exported page as its own script does, by the description at the top of `assets/page/decode.js`.

use std::collections::HashMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

const TILE: usize = 16;
const STREAMS: usize = 16;
const PLACES: usize = 0;
const MASKS: usize = 1;
const DOUBTFUL: usize = 2;
const DEPTH: usize = 3;
const ESCAPES: usize = 5;
const GREEN: usize = 6;
const RED: usize = 10;
const BLUE: usize = 13;

/// A sample: its pixel, inverse depth, color, and whether it is doubtful.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ReadSample {
    pub(crate) pixel: [usize; 2],
    pub(crate) inverse_depth: f32,
    pub(crate) color: [u8; 3],
    pub(crate) is_doubtful: bool,
}

/// An image: its camera, frames, level and samples.
#[derive(Debug)]
pub(crate) struct ReadImage {
    pub(crate) camera: usize,
    pub(crate) span: [u32; 2],
    pub(crate) level: u32,
    pub(crate) samples: Vec<ReadSample>,
}

/// The header of a page.
pub(crate) fn header(page: &str) -> Value {
    serde_json::from_str(between(page, "id=\"scene\">", "</script>")).unwrap()
}

fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let from = text.find(start).unwrap() + start.len();
    &text[from..from + text[from..].find(end).unwrap()]
}

/// All images of a page.
pub(crate) fn images(page: &str) -> Vec<ReadImage> {
    let header = header(page);
    let chunks = header["chunks"].as_array().unwrap();
    let texts: Vec<&str> =
        page.split("class=\"chunk\">").skip(1).map(|text| text.split('<').next().unwrap()).collect();
    assert_eq!(texts.len(), chunks.len());
    let mut all = Vec::new();
    for (images, text) in chunks.iter().zip(texts) {
        let mut streams = Streams::of(&inflated(&STANDARD.decode(text).unwrap()));
        for image in images.as_array().unwrap() {
            let camera = &header["cameras"][image["camera"].as_u64().unwrap() as usize];
            all.push(streams.image(image, camera));
        }
        assert!(streams.0.iter().all(|(bytes, at)| bytes.len() == *at), "bytes are left over");
    }
    all
}

/// The content of gzip, which ends with its length.
fn inflated(bytes: &[u8]) -> Vec<u8> {
    let length = u32::from_le_bytes(*bytes.last_chunk().unwrap()) as usize;
    let mut room = vec![0; length];
    let length = libdeflater::Decompressor::new().gzip_decompress(bytes, &mut room).unwrap();
    room.truncate(length);
    room
}

/// Each stream and the place in it.
struct Streams(Vec<(Vec<u8>, usize)>);

/// The depth and color of a pixel.
type Known = HashMap<[i64; 2], (i64, [i64; 3])>;

impl Streams {
    fn of(chunk: &[u8]) -> Self {
        let mut rest = &chunk[4 * STREAMS..];
        let streams = chunk[..4 * STREAMS].chunks(4).map(|length| {
            let (stream, after) = rest.split_at(u32::from_le_bytes(length.try_into().unwrap()) as usize);
            rest = after;
            (stream.to_vec(), 0)
        });
        let streams = streams.collect();
        assert!(rest.is_empty());
        Self(streams)
    }

    fn byte(&mut self, stream: usize) -> u8 {
        let (bytes, at) = &mut self.0[stream];
        *at += 1;
        bytes[*at - 1]
    }

    fn number(&mut self, stream: usize) -> u64 {
        let (mut number, mut shift) = (0, 0);
        loop {
            let byte = self.byte(stream);
            number |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte < 0x80 {
                return number;
            }
        }
    }

    fn rows(&mut self, stream: usize, usual: u16) -> [u16; TILE] {
        let mut rows = [usual; TILE];
        if self.byte(stream) == 1 {
            let mut above = 0;
            for row in &mut rows {
                above ^= u16::from_le_bytes([self.byte(stream), self.byte(stream)]);
                *row = above;
            }
        }
        rows
    }

    fn image(&mut self, image: &Value, camera: &Value) -> ReadImage {
        let number = |key: &str| image[key].as_u64().unwrap();
        let side = TILE << number("level");
        let columns = (camera["lens"][0].as_f64().unwrap() as usize).div_ceil(side);
        let shift = camera["depth_shift"].as_u64().unwrap();
        let (mut known, mut samples, mut next) = (Known::new(), Vec::new(), 0);
        let (mut depth_before, mut color_before) = (0, [0; 3]);
        for _ in 0..number("tiles") {
            let place = next + self.number(PLACES) as usize;
            next = place + 1;
            let rows = self.rows(MASKS, u16::MAX);
            let is_marked = image["doubtful"].as_bool().unwrap();
            let doubtful = if is_marked { self.rows(DOUBTFUL, 0) } else { [0; TILE] };
            for (row, column) in (0..TILE * TILE).map(|nth| (nth / TILE, nth % TILE)) {
                if rows[row] >> column & 1 == 0 {
                    continue;
                }
                let pixel = [place % columns * TILE + column, place / columns * TILE + row];
                let at = pixel.map(|part| part as i64);
                let depth = self.depth(&known, at, depth_before);
                let color = self.color(&known, at, number("predictor"), color_before);
                known.insert(at, (depth, color));
                (depth_before, color_before) = (depth, color);
                samples.push(ReadSample {
                    pixel,
                    inverse_depth: f32::from_bits((depth << shift) as u32),
                    color: color.map(|channel| channel as u8),
                    is_doubtful: doubtful[row] >> column & 1 == 1,
                });
            }
        }
        assert_eq!(samples.len() as u64, number("samples"));
        ReadImage {
            camera: number("camera") as usize,
            span: [number("start") as u32, number("end") as u32],
            level: number("level") as u32,
            samples,
        }
    }

    fn depth(&mut self, known: &Known, [x, y]: [i64; 2], before: i64) -> i64 {
        let at = |dx: i64, dy: i64| known.get(&[x - dx, y - dy]).map(|(depth, _)| *depth);
        let follow = |near: i64, far: Option<i64>| match far {
            Some(far) if near != 0 && (near - far).abs() <= 256 => (2 * near - far).max(0),
            _ => near,
        };
        let (predicted, smooth) = match (at(1, 0), at(0, 1), at(1, 1)) {
            (None, None, _) => (before, false),
            (None, Some(above), _) => (follow(above, at(0, 2)), false),
            (Some(left), None, _) => (follow(left, at(2, 0)), false),
            (Some(left), Some(_), None) => (left, false),
            (Some(left), Some(above), Some(corner)) if left == 0 || above == 0 => {
                (if corner == 0 { left.max(above) } else { 0 }, left == above)
            }
            (Some(left), Some(above), Some(corner)) => {
                let (down, across) = ((left - corner).abs(), (above - corner).abs());
                if down > 256 && across > 256 {
                    (left, false)
                } else {
                    ((left + above - corner).max(0), down <= 12 && across <= 12)
                }
            }
        };
        let residual = self.byte(if smooth { DEPTH } else { DEPTH + 1 }) as i8;
        if residual == -128 {
            let number = self.number(ESCAPES) as i64;
            return predicted + ((number >> 1) ^ -(number & 1));
        }
        predicted + i64::from(residual)
    }

    fn color(&mut self, known: &Known, [x, y]: [i64; 2], predictor: u64, before: [i64; 3]) -> [i64; 3] {
        let at = |dx: i64, dy: i64| known.get(&[x - dx, y - dy]).map(|(_, color)| *color);
        let mut context = 3;
        let predicted = match (at(1, 0), at(0, 1), at(1, 1)) {
            (None, None, _) => before,
            (Some(only), None, _) | (None, Some(only), _) => only,
            (Some(left), Some(above), None) => [0, 1, 2].map(|c| (left[c] + above[c] + 1) >> 1),
            (Some(left), Some(above), Some(corner)) => {
                let beyond = at(-1, 1).map_or(0, |right| (right[1] - above[1]).abs());
                context = match (left[1] - corner[1]).abs() + (above[1] - corner[1]).abs() + beyond {
                    ..=3 => 0,
                    4..=10 => 1,
                    11..=28 => 2,
                    _ => 3,
                };
                [0, 1, 2].map(|c| {
                    let (low, high) = (left[c].min(above[c]), left[c].max(above[c]));
                    match predictor {
                        0 => (left[c] + above[c] - corner[c]).clamp(low, high),
                        _ => ((3 * (left[c] + above[c]) - 2 * corner[c] + 2) >> 2).clamp(0, 255),
                    }
                })
            }
        };
        let green = i64::from(self.byte(GREEN + context) as i8);
        let by_green = match green.abs() {
            0..=1 => 0,
            2..=6 => 1,
            _ => 2,
        };
        let [red, blue] = [RED, BLUE].map(|stream| green + i64::from(self.byte(stream + by_green)));
        [(predicted[0] + red) & 255, (predicted[1] + green) & 255, (predicted[2] + blue) & 255]
    }
}
