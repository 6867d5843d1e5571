// The samples of one frame in the GPU's memory. Twins: src/engine/render/input/frame_tiles.rs, src/engine/samples/.
//
// Images lie in up to four pages, whole or cut between tiles into pieces. All positions are in words (u32) of the piece's page:
//
//   tiles   TILE_WORDS per tile: column | row << 16, first sample, bits of the farthest and of the nearest inverse
//           depth, first high byte, sixteen bytes that count the samples above each row, sixteen half words of row masks
//   low     u16 per sample      high   one or two bytes per sample      color   three f16 per sample
//   doubtful   MASK_WORDS per tile: sixteen half words of row masks; left out where no sample of the image is doubtful
//
// Samples and high bytes count from the first of the piece.

struct Piece {
    // Number of its first tile at this frame.
    first_tile: u32,
    camera: u32,
    // Index of the image in the sample set.
    image: u32,
    page: u32,
    tiles_at: u32,
    low_at: u32,
    high_at: u32,
    color_at: u32,
    // 0 where no sample is doubtful.
    doubtful_at: u32,
}

@group(0) @binding(2) var<storage, read> pieces: array<Piece>;
@group(0) @binding(3) var<storage, read> page_0: array<u32>;
@group(0) @binding(4) var<storage, read> page_1: array<u32>;
@group(0) @binding(5) var<storage, read> page_2: array<u32>;
@group(0) @binding(6) var<storage, read> page_3: array<u32>;

// Marks a pixel without a sample.
const MISSING: f32 = -1.0;
const TILE: u32 = 16u;
const TILE_WORDS: u32 = 17u;
// Where counts and masks of the rows begin in a tile's words.
const TILE_BEFORE: u32 = 5u;
const TILE_ROWS: u32 = 9u;
const MASK_WORDS: u32 = 8u;
// Tiles whose depths span more keep a fourth byte.
const WIDE: u32 = 0x1000000u;

fn word(page: u32, at: u32) -> u32 {
    switch page {
        case 0u: { return page_0[at]; }
        case 1u: { return page_1[at]; }
        case 2u: { return page_2[at]; }
        default: { return page_3[at]; }
    }
}

fn half_word(page: u32, at: u32, nth: u32) -> u32 {
    return word(page, at + nth / 2u) >> (16u * (nth & 1u)) & 0xffffu;
}

fn byte(page: u32, at: u32, nth: u32) -> u32 {
    return word(page, at + nth / 4u) >> (8u * (nth & 3u)) & 0xffu;
}

// The piece that holds tile `number`: the last one that does not begin after it.
fn piece_of(number: u32) -> u32 {
    var low = 0u;
    var high = stage.piece_count;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if pieces[middle].first_tile <= number {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// Where the words of tile `number` begin.
fn tile_at(piece: Piece, number: u32) -> u32 {
    return piece.tiles_at + TILE_WORDS * (number - piece.first_tile);
}

// Whether the sample at `at` in tile `number` of a piece is doubtful.
fn is_doubtful(piece: Piece, number: u32, at: vec2<u32>) -> bool {
    if piece.doubtful_at == 0u {
        return false;
    }
    let columns = half_word(piece.page, piece.doubtful_at + MASK_WORDS * (number - piece.first_tile), at.y);
    return (columns >> at.x & 1u) == 1u;
}

// The inverse depth of sample `nth` of a tile, given the tile's second to fifth word.
fn unpack_depth(piece: Piece, tile: vec4<u32>, nth: u32) -> f32 {
    let low = half_word(piece.page, piece.low_at, tile.x + nth);
    var high: u32;
    if tile.z - tile.y >= WIDE {
        let at = tile.w + 2u * nth;
        high = byte(piece.page, piece.high_at, at) | byte(piece.page, piece.high_at, at + 1u) << 8u;
    } else {
        high = byte(piece.page, piece.high_at, tile.w + nth);
    }
    return bitcast<f32>(tile.y + (low | high << 16u));
}

// The color of sample `index` of a piece.
fn unpack_color(piece: Piece, index: u32) -> vec3<f32> {
    let first = 3u * index;
    let at = piece.color_at + first / 2u;
    let a = unpack2x16float(word(piece.page, at));
    let b = unpack2x16float(word(piece.page, at + 1u));
    return select(vec3<f32>(a.y, b.x, b.y), vec3<f32>(a.x, a.y, b.x), (first & 1u) == 0u);
}

// How many samples of the tile at `at` come before pixel `(column, row)`, in storage order.
fn rank(page: u32, at: u32, column: u32, row: u32) -> u32 {
    let left_of = half_word(page, at + TILE_ROWS, row) & ((1u << column) - 1u);
    return byte(page, at + TILE_BEFORE, row) + countOneBits(left_of);
}

// The color of the sample at a slot.
fn color_of(slot: u32) -> vec3<f32> {
    let number = slot >> 8u;
    let piece = pieces[piece_of(number)];
    let at = tile_at(piece, number);
    let nth = rank(piece.page, at, slot & 15u, slot >> 4u & 15u);
    return unpack_color(piece, word(piece.page, at + 1u) + nth);
}
