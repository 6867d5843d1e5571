// The stage that carries samples into the cells of cameras, to know what these saw. One workgroup a tile.
// Twin: `CellDepths::add` in src/engine/render/free_space/seen_depth.rs.

@group(1) @binding(0) var<storage, read> views: array<CellView>;
// For each view, what carries the samples of every camera into its cells.
@group(1) @binding(1) var<storage, read> into_cells: array<Projector>;
// The nearest surface in each cell: the bits of the inverse depth plus one; 0 where the camera saw nothing.
@group(1) @binding(2) var<storage, read_write> nearest: array<atomic<u32>>;

// One of this many rows of samples is carried.
const ROW_STEP: u32 = 2u;

@compute @workgroup_size(16, 16)
fn carry(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let nth = group.y * GROUPS_ACROSS + group.x;
    if nth >= stage.tile_count {
        return;
    }
    let number = stage.first_tile + nth;
    let piece = pieces[piece_of(number)];
    let pixel = lay_out(piece, number, local.xy);
    let w = pixel.inverse_depth;
    if w < 0.0 || local.y % ROW_STEP != 0u {
        return;
    }
    let count = arrayLength(&views);
    let cameras = arrayLength(&into_cells) / count;
    for (var nth = 0u; nth < count; nth++) {
        let projector = into_cells[nth * cameras + piece.camera];
        let projected = project(projector, pixel.corner.x, pixel.corner.y + f32(local.y), f32(local.x), w);
        let size = vec2<u32>(views[nth].across, views[nth].down) - 2u * BORDER;
        let is_inside = projected.reciprocal > 0.0
            && all(projected.pixel >= vec2<f32>(0.0))
            && all(projected.pixel < vec2<f32>(size));
        if is_inside {
            let cell = vec2<u32>(projected.pixel) + BORDER;
            let bits = bitcast<u32>(w * projected.reciprocal) + 1u;
            atomicMax(&nearest[views[nth].first + cell.y * views[nth].across + cell.x], bits);
        }
    }
}
