// Looks samples up by camera and pixel. Twins: src/engine/render/input/tile_grid.rs, src/engine/render/input/tile_cache.rs.
//
//   lookup   cells of all cameras, one per tile: number of the first tile with samples there
//            entries, two words per tile of the frame: its piece, and the next tile of the same cell
//
// Lists ascend, so that tiles of the background come first.

struct View {
    source_from_target: Projector,
    // From the camera's center to the vantage's, in world space.
    offset_in_world: vec3<f32>,
    // Inverse depths that differ by no more than this share belong to one surface.
    tolerance: f32,
    width: i32,
    height: i32,
    cells_across: u32,
    first_cell: u32,
    // What growth of the inverse depth tells of `offset_in_world`.
    growth_along_offset: vec3<f32>,
    padding_0: u32,
}

@group(1) @binding(3) var<storage, read> views: array<View>;
@group(1) @binding(4) var<storage, read> lookup: array<u32>;

// The samples of 2×2 pixels: left above, right above, left below, right below.
struct Quad {
    // Inverse depths in the camera; MISSING where there is no sample.
    depth: array<f32, 4>,
    piece: array<u32, 4>,
    index: array<u32, 4>,
}

// Tiles from this number on are left out.
var<private> visible_tiles: u32;

fn cell_of(camera: u32, x: i32, y: i32) -> u32 {
    return views[camera].first_cell + u32(y >> 4u) * views[camera].cells_across + u32(x >> 4u);
}

fn set_corner(quad: ptr<function, Quad>, corner: u32, piece_index: u32, piece: Piece, at: u32, nth: u32) {
    let tile = vec4<u32>(
        word(piece.page, at + 1u),
        word(piece.page, at + 2u),
        word(piece.page, at + 3u),
        word(piece.page, at + 4u),
    );
    (*quad).depth[corner] = unpack_depth(piece, tile, nth);
    (*quad).piece[corner] = piece_index;
    (*quad).index[corner] = tile.x + nth;
}

// One corner of a quad. Finding all corners in one tile at once, as the CPU does, took twice as long on a software adapter,
// which ran both paths, and four times as long to compile.
fn find_corner(quad: ptr<function, Quad>, corner: u32, camera: u32, x: i32, y: i32) {
    if x < 0 || y < 0 || x >= views[camera].width || y >= views[camera].height {
        return;
    }
    let column = u32(x) & 15u;
    let row = u32(y) & 15u;
    var number = lookup[cell_of(camera, x, y)];
    while number < visible_tiles {
        let entry = stage.entries_at + 2u * number;
        let piece_index = lookup[entry];
        let piece = pieces[piece_index];
        let at = tile_at(piece, number);
        if (half_word(piece.page, at + TILE_ROWS, row) >> column & 1u) == 1u {
            set_corner(quad, corner, piece_index, piece, at, rank(piece.page, at, column, row));
            return;
        }
        number = lookup[entry + 1u];
    }
}

// The samples of a camera at columns `x`, `x + 1` and rows `y`, `y + 1`, which may lie outside its picture.
fn quad_at(camera: u32, x: i32, y: i32) -> Quad {
    var quad: Quad;
    for (var corner = 0u; corner < 4u; corner++) {
        quad.depth[corner] = MISSING;
    }
    for (var corner = 0u; corner < 4u; corner++) {
        find_corner(&quad, corner, camera, x + i32(corner & 1u), y + i32(corner >> 1u));
    }
    return quad;
}
