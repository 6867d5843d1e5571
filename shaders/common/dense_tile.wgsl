// A tile of samples laid out as 16×16 pixels, one thread each, and the slope of its surface.
// Twin: src/engine/render/input/dense_tile.rs.

const EDGE_FOOTPRINTS: f32 = 8.0;

var<workgroup> tile_words: array<u32, TILE_WORDS>;
var<workgroup> tile_inverse_depth: array<f32, 256>;

// One pixel of a tile.
struct Pixel {
    // Column and row of the tile's corner in its camera's picture.
    corner: vec2<f32>,
    // MISSING where there is no sample.
    inverse_depth: f32,
    // Index of the sample in its piece.
    index: u32,
}

// Lays out tile `number` of a piece; called by all threads of a workgroup of 16×16.
fn lay_out(piece: Piece, number: u32, at: vec2<u32>) -> Pixel {
    let thread = at.y * TILE + at.x;
    if thread < TILE_WORDS {
        tile_words[thread] = word(piece.page, tile_at(piece, number) + thread);
    }
    workgroupBarrier();
    var pixel: Pixel;
    pixel.corner = vec2<f32>(f32(tile_words[0] & 0xffffu), f32(tile_words[0] >> 16u)) * f32(TILE);
    pixel.inverse_depth = MISSING;
    let row = tile_words[TILE_ROWS + at.y / 2u] >> (16u * (at.y & 1u)) & 0xffffu;
    if (row >> at.x & 1u) == 1u {
        let before = tile_words[TILE_BEFORE + at.y / 4u] >> (8u * (at.y & 3u)) & 0xffu;
        let nth = before + countOneBits(row & ((1u << at.x) - 1u));
        let tile = vec4<u32>(tile_words[1], tile_words[2], tile_words[3], tile_words[4]);
        pixel.index = tile.x + nth;
        pixel.inverse_depth = unpack_depth(piece, tile, nth);
    }
    tile_inverse_depth[thread] = pixel.inverse_depth;
    workgroupBarrier();
    return pixel;
}

// The smaller of `w − before` and `after − w` of those that lie on the same surface, 0 where neither does.
fn gentler(w: f32, before: f32, after: f32, limit: f32) -> f32 {
    let back = w - before;
    let on = after - w;
    let has_back = abs(back) <= limit && before >= 0.0;
    let has_on = abs(on) <= limit && after >= 0.0;
    if has_back && (!has_on || abs(back) <= abs(on)) {
        return back;
    }
    return select(0.0, on, has_on);
}

// The inverse depth of the tile at `(column, row)`, MISSING beyond it.
fn neighbor(column: i32, row: i32) -> f32 {
    if column < 0 || row < 0 || column > 15 || row > 15 {
        return MISSING;
    }
    return tile_inverse_depth[row * 16 + column];
}

// Whether there is a neighbor at inverse depth `beside`, and on another surface.
fn is_other(w: f32, beside: f32, limit: f32) -> bool {
    return beside >= 0.0 && abs(w - beside) > limit;
}

// Whether a neighbor in the tile shows another surface.
fn beside_edge(at: vec2<u32>, per_footprint: f32) -> bool {
    let column = i32(at.x);
    let row = i32(at.y);
    let w = neighbor(column, row);
    let limit = EDGE_FOOTPRINTS * per_footprint * w;
    let beside = is_other(w, neighbor(column - 1, row), limit) || is_other(w, neighbor(column + 1, row), limit);
    return beside || is_other(w, neighbor(column, row - 1), limit) || is_other(w, neighbor(column, row + 1), limit);
}

// Growth of the inverse depth from one column to the next and from one row to the next.
fn slopes(at: vec2<u32>, per_footprint: f32) -> vec2<f32> {
    let column = i32(at.x);
    let row = i32(at.y);
    let w = neighbor(column, row);
    let limit = EDGE_FOOTPRINTS * per_footprint * w;
    return vec2<f32>(
        gentler(w, neighbor(column - 1, row), neighbor(column + 1, row), limit),
        gentler(w, neighbor(column, row - 1), neighbor(column, row + 1), limit),
    );
}
