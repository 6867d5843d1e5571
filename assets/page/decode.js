// Samples as they are packed, and as the renderer takes them.
//
// A chunk is gzip of: sixteen lengths of streams (u32, little-endian), then the streams. Images follow one another in each.
//
//   for each tile of 16×16 pixels, row-major:
//     PLACES    tiles skipped since the last one, as a variable-length number (seven bits a byte, lowest first)
//     MASKS     0: every pixel holds a sample; 1: sixteen rows of two bytes follow, each XOR the row above; bit x is column x
//     DOUBTFUL  of images with doubtful samples: 0: none; 1: sixteen rows likewise
//   for each sample, row by row:
//     DEPTH     inverse depth less its prediction, one byte; −128: a variable-length number in ESCAPES, its sign the lowest bit
//     GREEN     green less its prediction, one byte
//     RED, BLUE the same, less that of green
//
// Inverse depth is the upper bits of a 32-bit float, whose lower `depth_shift` bits are 0. A sample becomes 16 bytes:
//
//   u16 column, u16 row | f32 inverse depth | i16, i16 its growth by column and by row | u8 red, green, blue (sRGB), u8 flags

const TILE = 16;
const STREAMS = 16;
const [PLACES, MASKS, DOUBTFUL, DEPTH, ESCAPES, GREEN, RED, BLUE] = [0, 1, 2, 3, 5, 6, 10, 13];
const MISSING = -1;
const BORDER = 2;
const DEPTH_EDGE = 256;
const DEPTH_SMOOTH = 12;

/** Bytes of a sample for the renderer. */
export const SAMPLE_BYTES = 16;
/** Neighbors are of one surface if their inverse depths differ by at most this many footprints; slopes are parts of it. */
export const EDGE_FOOTPRINTS = 8;
/** Flags of a sample: no other camera confirms it; there are samples to its left, to its right, above it and below it. */
export const [IS_DOUBTFUL, HAS_LEFT, HAS_RIGHT, HAS_ABOVE, HAS_BELOW] = [1, 2, 4, 8, 16];

/** Bytes of base64 text. */
export function bytesOfBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let at = 0; at < bytes.length; at++) bytes[at] = characters.charCodeAt(at);
  return bytes;
}

/** Decompresses gzip, and checks its sum. */
export async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Reads the streams of a chunk. */
class Streams {
  constructor(bytes) {
    const lengths = new DataView(bytes.buffer, bytes.byteOffset, 4 * STREAMS);
    this.bytes = bytes;
    this.at = new Uint32Array(STREAMS);
    let start = 4 * STREAMS;
    for (let nth = 0; nth < STREAMS; nth++) {
      this.at[nth] = start;
      start += lengths.getUint32(4 * nth, true);
    }
    if (start !== bytes.length) throw new Error("the samples are damaged");
  }

  number(stream) {
    let number = 0;
    let shift = 0;
    let byte;
    do {
      byte = this.bytes[this.at[stream]++];
      number |= (byte & 0x7f) << shift;
      shift += 7;
    } while (byte & 0x80);
    return number >>> 0;
  }

  masks(stream, usual, rows) {
    if (this.bytes[this.at[stream]++] === 0) {
      rows.fill(usual);
      return;
    }
    let above = 0;
    for (let row = 0; row < TILE; row++) {
      above ^= this.bytes[this.at[stream]] | this.bytes[this.at[stream] + 1] << 8;
      rows[row] = above;
      this.at[stream] += 2;
    }
  }
}

/** What follows `near` and, before it, `far`. */
function continued(near, far) {
  return near === 0 || far === MISSING || Math.abs(near - far) > DEPTH_EDGE ? near : Math.max(2 * near - far, 0);
}

/** The planes of the image that is being decoded, between missing pixels; kept from image to image. */
const planes = { stride: 0, depths: new Int32Array(0), colors: new Uint8Array(0), inverse: new Float32Array(0) };

function clearPlanes(columns, rows) {
  planes.stride = columns * TILE + 2 * BORDER;
  const pixels = planes.stride * (rows * TILE + 2 * BORDER);
  if (planes.depths.length < pixels) {
    planes.depths = new Int32Array(pixels);
    planes.colors = new Uint8Array(3 * pixels);
    planes.inverse = new Float32Array(pixels);
  }
  planes.depths.fill(MISSING, 0, pixels);
}

/** The tiles of an image: their places, masks, and masks of doubtful samples. */
function readTiles(streams, image, columns) {
  const tiles = [];
  let next = 0;
  for (let nth = 0; nth < image.tiles; nth++) {
    const number = next + streams.number(PLACES);
    next = number + 1;
    const tile = { x: number % columns * TILE, y: Math.floor(number / columns) * TILE, rows: new Uint16Array(TILE), doubtful: null };
    streams.masks(MASKS, 0xffff, tile.rows);
    if (image.doubtful) {
      tile.doubtful = new Uint16Array(TILE);
      streams.masks(DOUBTFUL, 0, tile.doubtful);
    }
    tiles.push(tile);
  }
  return tiles;
}

/** Decodes all samples into the planes. */
function readSamples(streams, tiles, image, shift) {
  const { depths, colors, inverse, stride } = planes;
  const { bytes, at } = streams;
  const floats = new Float32Array(1);
  const bits = new Uint32Array(floats.buffer);
  let [depthBefore, red, green, blue] = [0, 0, 0, 0];
  const average = image.predictor === 1;
  for (const tile of tiles) {
    for (let row = 0; row < TILE; row++) {
      const mask = tile.rows[row];
      let p = (tile.y + row + BORDER) * stride + tile.x + BORDER;
      for (let column = 0; column < TILE; column++, p++) {
        if (!(mask >> column & 1)) continue;
        const left = depths[p - 1];
        const above = depths[p - stride];
        const corner = depths[p - stride - 1];
        // Inverse depth.
        let predicted = 0;
        let smooth = 1;
        if (left === MISSING) {
          predicted = above === MISSING ? depthBefore : continued(above, depths[p - 2 * stride]);
        } else if (above === MISSING) {
          predicted = continued(left, depths[p - 2]);
        } else if (corner === MISSING) {
          predicted = left;
        } else if (left === 0 || above === 0) {
          predicted = corner === 0 ? Math.max(left, above) : 0;
          if (left === above) smooth = 0;
        } else {
          const down = Math.abs(left - corner);
          const across = Math.abs(above - corner);
          if (down > DEPTH_EDGE && across > DEPTH_EDGE) {
            predicted = left;
          } else {
            predicted = Math.max(left + above - corner, 0);
            if (down <= DEPTH_SMOOTH && across <= DEPTH_SMOOTH) smooth = 0;
          }
        }
        let residual = bytes[at[DEPTH + smooth]++] << 24 >> 24;
        if (residual === -128) {
          const number = streams.number(ESCAPES);
          residual = number >>> 1 ^ -(number & 1);
        }
        depthBefore = predicted + residual;
        depths[p] = depthBefore;
        bits[0] = depthBefore << shift;
        inverse[p] = floats[0];
        // Color.
        let context = 3;
        const l = 3 * (p - 1);
        const a = 3 * (p - stride);
        if (left !== MISSING && above !== MISSING) {
          if (corner === MISSING) {
            red = colors[l] + colors[a] + 1 >> 1;
            green = colors[l + 1] + colors[a + 1] + 1 >> 1;
            blue = colors[l + 2] + colors[a + 2] + 1 >> 1;
          } else {
            const c = a - 3;
            const aboveGreen = colors[a + 1];
            let differences = Math.abs(colors[l + 1] - colors[c + 1]) + Math.abs(aboveGreen - colors[c + 1]);
            if (depths[p - stride + 1] !== MISSING) differences += Math.abs(colors[a + 4] - aboveGreen);
            context = differences <= 3 ? 0 : differences <= 10 ? 1 : differences <= 28 ? 2 : 3;
            red = predictChannel(average, colors[l], colors[a], colors[c]);
            green = predictChannel(average, colors[l + 1], aboveGreen, colors[c + 1]);
            blue = predictChannel(average, colors[l + 2], colors[a + 2], colors[c + 2]);
          }
        } else if (left !== MISSING) {
          red = colors[l];
          green = colors[l + 1];
          blue = colors[l + 2];
        } else if (above !== MISSING) {
          red = colors[a];
          green = colors[a + 1];
          blue = colors[a + 2];
        }
        const byGreen = bytes[at[GREEN + context]++] << 24 >> 24;
        const size = Math.abs(byGreen);
        const other = size <= 1 ? 0 : size <= 6 ? 1 : 2;
        red = red + byGreen + bytes[at[RED + other]++] & 0xff;
        green = green + byGreen & 0xff;
        blue = blue + byGreen + bytes[at[BLUE + other]++] & 0xff;
        const q = 3 * p;
        colors[q] = red;
        colors[q + 1] = green;
        colors[q + 2] = blue;
      }
    }
  }
}

function predictChannel(average, left, above, corner) {
  const plane = left + above - corner;
  if (average) {
    const mean = 3 * (left + above) - 2 * corner + 2 >> 2;
    return mean < 0 ? 0 : mean > 255 ? 255 : mean;
  }
  const [low, high] = left < above ? [left, above] : [above, left];
  return plane < low ? low : plane > high ? high : plane;
}

/** The gentler growth from one neighbor to the next among those of the same surface; 0 if there is none. */
function gentler(back, on, limit) {
  const isBack = Math.abs(back) <= limit;
  const isOn = Math.abs(on) <= limit;
  if (isBack && isOn) return Math.abs(back) <= Math.abs(on) ? back : on;
  return isBack ? back : isOn ? on : 0;
}

/**
 * Lays decoded samples out for the renderer, from sample `at` of `out` on: first those of every fourth column and row, then the others of
 * every second, then all others. Gives how many there are of the first, of the first two and of all: coarse pictures are drawn from fewer.
 */
function layOut(tiles, perFootprint, out, at) {
  const counts = [];
  let end = at;
  for (let pass = 0; pass < 3; pass++) {
    end = layOutSome(tiles, perFootprint, out, end, pass);
    counts.push(end - at);
  }
  return counts;
}

/** The columns that each pass takes of a row, by the row. */
function columnsOf(pass, row) {
  const [fourth, second] = [row & 3 ? 0 : 0x1111, row & 1 ? 0 : 0x5555];
  return pass === 0 ? fourth : pass === 1 ? second & ~fourth : ~second;
}

/** Lays out what a pass takes; gives the sample after the last. */
function layOutSome(tiles, perFootprint, out, at, pass) {
  const { depths, colors, inverse, stride } = planes;
  for (const tile of tiles) {
    for (let row = 0; row < TILE; row++) {
      const mask = tile.rows[row] & columnsOf(pass, row);
      if (mask === 0) continue;
      const doubtful = tile.doubtful === null ? 0 : tile.doubtful[row];
      let p = (tile.y + row + BORDER) * stride + tile.x + BORDER;
      for (let column = 0; column < TILE; column++, p++) {
        if (!(mask >> column & 1)) continue;
        const w = inverse[p];
        const limit = EDGE_FOOTPRINTS * perFootprint * w;
        // Growth from and to each neighbor; of one that is missing it is NaN, which is neither within the limit nor beyond it.
        const left = depths[p - 1] === MISSING ? NaN : w - inverse[p - 1];
        const right = depths[p + 1] === MISSING ? NaN : inverse[p + 1] - w;
        const above = depths[p - stride] === MISSING ? NaN : w - inverse[p - stride];
        const below = depths[p + stride] === MISSING ? NaN : inverse[p + stride] - w;
        const toShare = limit > 0 ? 32767 / limit : 0;
        const flag = (growth, bit) => Number.isNaN(growth) ? 0 : bit;
        const neighbors = flag(left, HAS_LEFT) | flag(right, HAS_RIGHT) | flag(above, HAS_ABOVE) | flag(below, HAS_BELOW);
        out.words[8 * at] = tile.x + column;
        out.words[8 * at + 1] = tile.y + row;
        out.floats[4 * at + 1] = w;
        out.words[8 * at + 4] = Math.round(gentler(left, right, limit) * toShare);
        out.words[8 * at + 5] = Math.round(gentler(above, below, limit) * toShare);
        out.bytes[16 * at + 12] = colors[3 * p];
        out.bytes[16 * at + 13] = colors[3 * p + 1];
        out.bytes[16 * at + 14] = colors[3 * p + 2];
        out.bytes[16 * at + 15] = (doubtful >> column & 1 ? IS_DOUBTFUL : 0) | neighbors;
        at++;
      }
    }
  }
  return at;
}

/**
 * The samples of the images of a chunk, one after another, `SAMPLE_BYTES` each, and for each image the counts of `layOut`;
 * `bytes` is the decompressed chunk.
 */
export function decodeChunk(bytes, images, cameras) {
  const streams = new Streams(bytes);
  const count = images.reduce((sum, image) => sum + image.samples, 0);
  const samples = new Uint8Array(count * SAMPLE_BYTES);
  // Browsers run on little-endian machines alone; typed arrays take their order.
  const out = { bytes: samples, words: new Uint16Array(samples.buffer), floats: new Float32Array(samples.buffer) };
  const counts = [];
  let at = 0;
  for (const image of images) {
    const { lens, depth_shift: shift } = cameras[image.camera];
    const pixels = TILE << image.level;
    const [columns, rows] = [Math.ceil(lens[0] / pixels), Math.ceil(lens[1] / pixels)];
    clearPlanes(columns, rows);
    const tiles = readTiles(streams, image, columns);
    readSamples(streams, tiles, image, shift);
    counts.push(layOut(tiles, (1 << image.level) / Math.sqrt(lens[2] * lens[3]), out, at));
    at += image.samples;
  }
  return { samples, counts };
}

/** Undoes the differences that the colors of the sky are stored as. */
export function skyColors(residuals) {
  for (let at = 3; at < residuals.length; at++) residuals[at] += residuals[at - 3];
  return residuals;
}
