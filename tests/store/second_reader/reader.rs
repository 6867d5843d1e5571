//! FORMAT.md, sentence by sentence. It trusts the file: what is checked here is the description, not damage.

use std::collections::BTreeMap;

use super::values::{ValueBlock, ValueTable};

pub(crate) struct Sample {
    pub(crate) x: usize,
    pub(crate) y: usize,
    /// Bits of halves: red, green, blue.
    pub(crate) color: [u16; 3],
    /// Bits.
    pub(crate) inverse_depth: u32,
    pub(crate) normal: Option<[i8; 2]>,
    pub(crate) is_doubtful: bool,
    /// Scalar values, one a channel.
    pub(crate) values: Vec<f32>,
}

pub(crate) struct Image {
    pub(crate) camera: u32,
    pub(crate) span: (u32, u32),
    pub(crate) is_predicted: bool,
    pub(crate) samples: Vec<Sample>,
    /// By place.
    blocks: BTreeMap<usize, Block>,
    value_blocks: BTreeMap<usize, ValueBlock>,
}

pub(crate) struct Store {
    /// Name, columns, rows.
    pub(crate) cameras: Vec<(String, u32, u32)>,
    pub(crate) images: Vec<Image>,
}

/// Values by plane (depth, green, red, blue, normal x, normal y), of pixels that hold a sample.
type Block = BTreeMap<(i64, i64), [i32; 6]>;

pub(crate) struct Bytes<'a>(pub(crate) &'a [u8]);

impl<'a> Bytes<'a> {
    pub(crate) fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    pub(crate) fn number(&mut self, bytes: usize) -> u64 {
        self.take(bytes).iter().fold(0, |number, byte| number << 8 | u64::from(*byte))
    }

    pub(crate) fn varint(&mut self) -> usize {
        let byte = self.number(1) as usize;
        if byte < 128 { byte } else { byte - 128 + 128 * self.varint() }
    }

    pub(crate) fn text(&mut self) -> String {
        let length = self.number(4) as usize;
        String::from_utf8(self.take(length).to_vec()).unwrap()
    }
}

/// Per context, the frequency of each token.
pub(crate) type Model = Vec<Vec<Vec<u32>>>;

const CONTEXTS: [usize; 7] = [1024, 187, 102, 816, 816, 51, 51];

fn model(payload: &[u8]) -> Model {
    let mut bytes = Bytes(payload);
    let planes = CONTEXTS.map(|contexts| tables(&mut bytes, contexts));
    assert!(bytes.0.is_empty());
    planes.into()
}

/// The tables of a plane.
pub(crate) fn tables(bytes: &mut Bytes<'_>, contexts: usize) -> Vec<Vec<u32>> {
    let mut tables = Vec::new();
    for _ in 0..bytes.varint() {
        let (users, listed) = (bytes.varint(), bytes.varint());
        let mut table = Vec::new();
        while table.len() < listed {
            let frequency = bytes.varint() as u32;
            table.push(frequency);
            if frequency == 0 {
                table.resize(table.len() + bytes.varint(), 0);
            }
        }
        assert_eq!(table.iter().sum::<u32>(), 4096);
        tables.extend(std::iter::repeat_n(table, users));
    }
    assert_eq!(tables.len(), contexts);
    tables
}

/// Bits of the halves of a palette.
fn palette(payload: &[u8]) -> Vec<u16> {
    let mut bytes = Bytes(payload);
    let (mut halves, mut place) = (Vec::new(), 0);
    while !bytes.0.is_empty() {
        place += bytes.varint();
        for _ in 0..bytes.varint() {
            halves.push(if place < 0x8000 { 0xFFFF - place as u16 } else { place as u16 - 0x8000 });
            place += 1;
        }
    }
    halves
}

/// By image, where its runs end.
fn runs(payload: &[u8]) -> BTreeMap<usize, Vec<usize>> {
    let mut bytes = Bytes(payload);
    let (mut all, mut image) = (BTreeMap::new(), 0);
    while !bytes.0.is_empty() {
        image += bytes.varint();
        let (count, mut end) = (bytes.varint(), 0);
        let ends = (0..count).map(|_| {
            end += bytes.varint();
            end
        });
        all.insert(image, ends.collect());
        image += 1;
    }
    all
}

/// The chunks that a file has once, by their ids, without their checksums.
fn chunks_of(file: &[u8]) -> BTreeMap<&[u8], &[u8]> {
    let mut chunks = BTreeMap::new();
    let mut rest = Bytes(&file[12..]);
    while !rest.0.is_empty() {
        let id = rest.take(4);
        let length = rest.number(4) as usize;
        let payload = rest.take(length);
        rest.take(length % 2);
        if id != b"IMAG" && id != b"VALI" {
            let (payload, checksum) = payload.split_at(length - 4);
            assert_eq!(Bytes(checksum).number(4) as u32, crc32fast::hash(&[id, payload].concat()));
            chunks.insert(id, payload);
        }
    }
    chunks
}

impl Store {
    pub(crate) fn read(file: &[u8]) -> Self {
        assert_eq!((&file[..4], &file[8..12]), (&b"FORM"[..], &b"OVLK"[..]));
        assert_eq!(Bytes(&file[4..]).number(4) as usize, file.len() - 8);
        let chunks = chunks_of(file);
        let mut head = Bytes(chunks[&b"HEAD"[..]]);
        let doubtful = chunks.get(&b"DOUB"[..]).map_or(BTreeMap::new(), |payload| runs(payload));
        let has_values = chunks.contains_key(&b"VALU"[..]);
        let minor = if has_values { 2 } else { u64::from(!doubtful.is_empty()) };
        assert_eq!((head.number(2), head.number(2)), (3, minor));
        head.text();
        head.take(24);
        let cameras: Vec<_> = (0..head.number(4))
            .map(|_| {
                let camera = (head.text(), head.number(4) as u32, head.number(4) as u32);
                head.take(16 * 8);
                camera
            })
            .collect();
        let (model, palette) = (model(chunks[&b"MODL"[..]]), palette(chunks[&b"PALT"[..]]));
        let mut index = Bytes(chunks[&b"INDX"[..]]);
        assert_eq!(index.number(8) as usize, file.len());
        let entries: Vec<_> = (0..index.number(4))
            .map(|_| {
                let numbers: Vec<u32> = (0..6).map(|_| index.number(4) as u32).collect();
                (numbers, index.number(8) as usize, index.number(4) as usize, index.number(4) as usize)
            })
            .collect();
        let values = chunks.get(&b"VALU"[..]).map(|payload| ValueTable::read(payload, entries.len()));
        let mut images: Vec<Option<Image>> = (0..entries.len()).map(|_| None).collect();
        while images.iter().any(Option::is_none) {
            for (nth, (numbers, offset, length, head)) in entries.iter().enumerate() {
                let reference = (numbers[5] != u32::MAX).then_some(numbers[5] as usize);
                if images[nth].is_some() || reference.is_some_and(|reference| images[reference].is_none()) {
                    continue;
                }
                let (name, width, height) = &cameras[numbers[0] as usize];
                assert!(!name.is_empty());
                let mut decoder = ImageDecoder {
                    model: &model,
                    palette: &palette,
                    size: (*width as usize, *height as usize),
                    reference: reference.and_then(|reference| images[reference].as_ref()),
                    normals: false,
                    shift: 0,
                };
                let (samples, blocks) = decoder.image(&file[offset + 8..offset + 8 + length], *head);
                let mut samples = samples;
                for sample in &mut samples {
                    // Tiles row by row, and their pixels row by row.
                    let tile = sample.y / 16 * (*width as usize).div_ceil(16) + sample.x / 16;
                    let place = tile * 256 + sample.y % 16 * 16 + sample.x % 16;
                    let ends = doubtful.get(&nth).map_or(&[][..], Vec::as_slice);
                    sample.is_doubtful = ends.iter().filter(|end| **end <= place).count() % 2 == 1;
                }
                let before = reference.and_then(|reference| images[reference].as_ref());
                let value_blocks = values.as_ref().map_or_else(BTreeMap::new, |values| {
                    let depths = decoder.inverse_depths(&blocks);
                    let before = before.map(|before| &before.value_blocks);
                    let found = values.image(file, nth, &depths, before);
                    for sample in &mut samples {
                        let place = sample.y / 64 * (*width as usize).div_ceil(64) + sample.x / 64;
                        let pixel = ((sample.x % 64) as i64, (sample.y % 64) as i64);
                        sample.values = values.values(&found[&place][&pixel]);
                    }
                    found
                });
                assert_eq!(samples.len(), numbers[3] as usize);
                images[nth] = Some(Image {
                    camera: numbers[0],
                    span: (numbers[1], numbers[2]),
                    is_predicted: reference.is_some(),
                    samples,
                    blocks,
                    value_blocks,
                });
            }
        }
        Self { cameras, images: images.into_iter().flatten().collect() }
    }
}

struct ImageDecoder<'a> {
    model: &'a Model,
    palette: &'a [u16],
    size: (usize, usize),
    reference: Option<&'a Image>,
    normals: bool,
    shift: u32,
}

/// The pixels of a block that hold a sample, as its mask says.
fn held_pixels(
    numbers: &mut Numbers<'_>,
    pixels: &[(i64, i64)],
    reference: Option<&Block>,
) -> Vec<(i64, i64)> {
    let mut held = Vec::new();
    for &(x, y) in pixels {
        let set = |dx: i64, dy: i64| usize::from(held.contains(&(x + dx, y + dy)));
        let near = [(-1, 0), (0, -1), (-1, -1), (1, -1), (-2, 0), (0, -2)];
        let mut context: usize = near.iter().enumerate().map(|(n, (dx, dy))| set(*dx, *dy) << n).sum();
        if let Some(reference) = reference {
            let set = |dx, dy| usize::from(reference.contains_key(&(x + dx, y + dy)));
            context += 64 * set(0, 0) + 128 * set(1, 0) + 256 * set(0, 1) + 512;
        }
        if numbers.take(x as usize % 4, 0, context) != 0 {
            held.push((x, y));
        }
    }
    held
}

impl ImageDecoder<'_> {
    fn image(&mut self, payload: &[u8], head_length: usize) -> (Vec<Sample>, BTreeMap<usize, Block>) {
        let mut head = Bytes(&payload[..head_length]);
        let mut codes = Bytes(&payload[head_length..]);
        let checksum = crc32fast::hash(&[b"IMAG", &payload[..head_length - 4]].concat());
        let (flags, shift) = (head.number(1), head.number(1) as u32);
        (self.normals, self.shift) = (flags & 1 == 1, shift);
        let (across, down) = (self.size.0.div_ceil(64), self.size.1.div_ceil(64));
        let bits = head.take((across * down).div_ceil(8));
        let (mut samples, mut blocks) = (Vec::new(), BTreeMap::new());
        for place in (0..across * down).filter(|place| bits[place / 8] << (place % 8) & 0x80 != 0) {
            let (tiles, count) = (head.number(2), head.number(2) as usize + 1);
            let bounds = [head.number(2) as u32, head.number(2) as u32].map(|half| half << 16);
            let (length, checksum) = (head.number(4) as usize, head.number(4) as u32);
            let code = codes.take(length);
            assert_eq!(crc32fast::hash(code), checksum);
            let corner = (place % across * 64, place / across * 64);
            let pixels: Vec<(i64, i64)> = (0..64.min(self.size.1 - corner.1))
                .flat_map(|y| (0..64.min(self.size.0 - corner.0)).map(move |x| (x, y)))
                .filter(|(x, y)| tiles >> (y / 16 * 4 + x / 16) & 1 == 1)
                .map(|(x, y)| (x as i64, y as i64))
                .collect();
            let reference = self.reference.and_then(|image| image.blocks.get(&place));
            let block = if flags & 2 == 0 {
                self.block(code, &pixels, reference)
            } else {
                self.plain_block(code, &pixels)
            };
            assert_eq!(block.len(), count);
            for (&(x, y), values) in &block {
                let inverse_depth = (values[0] as u32) << shift;
                assert!((bounds[0]..=bounds[1]).contains(&inverse_depth));
                samples.push(Sample {
                    x: corner.0 + x as usize,
                    y: corner.1 + y as usize,
                    color: [values[2], values[1], values[3]].map(|rank| self.palette[rank as usize]),
                    inverse_depth,
                    normal: self.normals.then_some([values[4] as i8, values[5] as i8]),
                    is_doubtful: false,
                    values: Vec::new(),
                });
            }
            blocks.insert(place, block);
        }
        assert_eq!(head.number(4) as u32, checksum);
        assert!(codes.0.is_empty());
        (samples, blocks)
    }

    fn inverse_depths(&self, blocks: &BTreeMap<usize, Block>) -> BTreeMap<usize, BTreeMap<(i64, i64), f32>> {
        let of = |values: &[i32; 6]| f32::from_bits((values[0] as u32) << self.shift);
        let block = |block: &Block| block.iter().map(|(pixel, values)| (*pixel, of(values))).collect();
        blocks.iter().map(|(place, pixels)| (*place, block(pixels))).collect()
    }

    fn plain_block(&self, code: &[u8], pixels: &[(i64, i64)]) -> Block {
        let mut bits = Bits { bytes: code, position: 0 };
        let held: Vec<_> = pixels.iter().filter(|_| bits.take(1) == 1).copied().collect();
        let block = held.into_iter().map(|pixel| {
            let mut values = [32, 16, 16, 16].map(|count| bits.take(count) as i32).to_vec();
            values.resize_with(6, || if self.normals { i32::from(bits.take(8) as u8 as i8) } else { 0 });
            (pixel, values.try_into().unwrap())
        });
        block.collect()
    }

    fn block(&self, code: &[u8], pixels: &[(i64, i64)], reference: Option<&Block>) -> Block {
        let mut bytes = Bytes(code);
        let count = bytes.number(2) as usize;
        let mut words = Bytes(bytes.take(2 * count));
        let states = [0; 4].map(|_| words.number(4) as u32);
        let bits = Bits { bytes: bytes.0, position: 0 };
        let mut numbers = Numbers { model: self.model, states, words, bits };

        let held = held_pixels(&mut numbers, pixels, reference);
        let mut block = Block::new();
        // The numbers that residuals were coded by, by plane.
        let mut coded = BTreeMap::<(i64, i64), [u32; 6]>::new();
        for (x, y) in held {
            let before = reference.and_then(|reference| reference.get(&(x, y))).copied();
            let mut values = [0_i32; 6];
            let mut residuals = [0_u32; 6];
            for plane in 0..if self.normals { 6 } else { 4 } {
                let at = |dx: i64, dy: i64| block.get(&(x + dx, y + dy)).map(|values| values[plane]);
                let first = at(-1, 0).or(at(0, -1)).or(at(-1, -1)).or(at(1, -1));
                let (mut sum, mut weights) = (0, 0);
                for (dx, dy, weight) in [(-1, 0, 2), (0, -1, 2), (-1, -1, 1), (1, -1, 1)] {
                    if let Some(residuals) = coded.get(&(x + dx, y + dy)) {
                        sum += weight * u64::from(residuals[plane]);
                        weights += weight;
                    }
                }
                let activity =
                    (4 * sum).checked_div(weights).map_or(16, |a| 15.min(64 - a.leading_zeros() as usize));
                let (prediction, kind) = match plane {
                    0 => {
                        let same = |dx, dy| {
                            let here = block.get(&(x + dx, y + dy)).map(|values| values[0]);
                            let there =
                                reference.and_then(|r| r.get(&(x + dx, y + dy))).map(|values| values[0]);
                            usize::from(here.is_some() && here == there)
                        };
                        let resting = same(-1, 0) + same(0, -1);
                        let alone = at(-1, 0).is_none() && at(0, -1).is_none();
                        match (self.plane(at, first), before) {
                            (_, Some(before)) if alone || resting > 0 => (before[0], 4 + resting),
                            ((prediction, kind), Some(_)) => (prediction, kind + 7),
                            (spatial, None) => spatial,
                        }
                    }
                    1..=3 => {
                        let half = self.palette.len() as i32 / 2;
                        let (prediction, kind) = match (at(-1, 0), at(0, -1), at(-1, -1)) {
                            (Some(w), Some(n), Some(nw)) if nw >= w.max(n) => (w.min(n), 0),
                            (Some(w), Some(n), Some(nw)) if nw <= w.min(n) => (w.max(n), 0),
                            (Some(w), Some(n), Some(nw)) => (w + n - nw, 0),
                            (Some(w), Some(n), None) => (i32::midpoint(w, n), 0),
                            _ => first.map_or((half, 2), |first| (first, 1)),
                        };
                        before.map_or((prediction, kind), |before| (before[plane], kind + 3))
                    }
                    _ => match (before, first) {
                        (Some(before), _) => (before[plane], 2),
                        (None, Some(first)) => (first, 1),
                        (None, None) => (0, 0),
                    },
                };
                let mut context = 17 * kind + activity;
                let mut prediction = prediction;
                if plane == 2 || plane == 3 {
                    let bits = 32 - residuals[1].leading_zeros() as usize;
                    context = 8 * context + bits.min(14) / 2;
                    prediction = prediction.wrapping_add(signed(residuals[1]));
                }
                let state = if plane < 4 { plane } else { 0 };
                residuals[plane] = numbers.take(state, plane + 1, context);
                values[plane] = prediction.wrapping_add(signed(residuals[plane]));
            }
            block.insert((x, y), values);
            coded.insert((x, y), residuals);
        }
        assert!(numbers.words.0.is_empty() && numbers.states == [1 << 16; 4]);
        assert_eq!(numbers.bits.position.div_ceil(8), numbers.bits.bytes.len());
        block
    }

    fn plane(&self, at: impl Fn(i64, i64) -> Option<i32>, first: Option<i32>) -> (i32, usize) {
        let depth = |dx, dy| at(dx, dy).map(|d| f64::from(f32::from_bits((d as u32) << self.shift)));
        let (w, n, nw, ne) = (depth(-1, 0), depth(0, -1), depth(-1, -1), depth(1, -1));
        let (ww, nn) = (depth(-2, 0), depth(0, -2));
        let sum = |a: Option<f64>, b: Option<f64>, c: Option<f64>| Some(a? + b? - c?);
        let double = |a: Option<f64>, b: Option<f64>| Some(2.0 * a? - b?);
        // W + NE − N is a plane through all three.
        let planes = [sum(w, n, nw), double(w, ww), double(n, nn), sum(w, ne, n)];
        let mut planes: Vec<f64> = planes.into_iter().flatten().collect();
        planes.sort_by(f64::total_cmp);
        match planes.len() {
            0 => first.map_or((0x3E00_0000 >> self.shift, 1), |first| (first, 2)),
            count => {
                let median = f64::midpoint(planes[(count - 1) / 2], planes[count / 2]);
                let half = if self.shift > 0 { 1 << (self.shift - 1) } else { 0 };
                ((((median as f32).max(0.0).to_bits() + half) >> self.shift) as i32, 3)
            }
        }
    }
}

pub(crate) fn signed(v: u32) -> i32 {
    if v.is_multiple_of(2) { (v / 2) as i32 } else { -((v / 2) as i32) - 1 }
}

pub(crate) struct Bits<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) position: usize,
}

impl Bits<'_> {
    fn take(&mut self, count: u32) -> u32 {
        (0..count).fold(0, |value, n| {
            let bit = self.bytes[self.position / 8] >> (self.position % 8) & 1;
            self.position += 1;
            value | u32::from(bit) << n
        })
    }
}

pub(crate) struct Numbers<'a> {
    pub(crate) model: &'a Model,
    pub(crate) states: [u32; 4],
    pub(crate) words: Bytes<'a>,
    pub(crate) bits: Bits<'a>,
}

impl Numbers<'_> {
    pub(crate) fn take(&mut self, state: usize, plane: usize, context: usize) -> u32 {
        let x = &mut self.states[state];
        let slot = *x % 4096;
        let (mut token, mut start) = (0, 0);
        let table = &self.model[plane][context];
        while slot >= start + table[token] {
            start += table[token];
            token += 1;
        }
        *x = table[token] * (*x / 4096) + slot - start;
        if *x < 1 << 16 {
            *x = *x << 16 | self.words.number(2) as u32;
        }
        if token < 16 {
            return token as u32;
        }
        let t = token as u32 - 16;
        let k = t / 4 + 2;
        (4 + t % 4) << k | self.bits.take(k)
    }
}
