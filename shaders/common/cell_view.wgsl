// A camera that tells what it saw in cells of 2×2 pixels. Twin: src/engine/render/free_space/seen_depth.rs.

struct CellView {
    cells_from_target: Projector,
    // Columns and rows of cells with the border.
    across: u32,
    down: u32,
    // Where its cells, and the corners between them, begin.
    first: u32,
    // Inverse depths below this share of a point's are behind it.
    behind_ratio: f32,
}

// Empty cells around those of a camera.
const BORDER: u32 = 2u;

// Marks corners around which a camera saw nothing.
const UNSEEN: f32 = 0x1.fffffep+127f;
