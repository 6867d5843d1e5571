// What surrounds a pixel. Twin: src/engine/render/free_space/surroundings.rs.
//
//   squares   nearest and farthest inverse depth of the surfaces in each square of 16×16 pixels; then, for each square again, of
//             those in it and around it

@group(1) @binding(4) var<storage, read_write> squares: array<vec2<f32>>;

// Nearer surfaces are searched for this far at most and at least, pixels, and in between for one pixel to so many columns.
const MOST_REACH: i32 = 16;
const LEAST_REACH: i32 = 8;
const COLUMNS_TO_REACH: u32 = 32u;
// A surface is nearer if its inverse depth is more than this many times as large.
const NEARER: f32 = 2.0;
// Beyond the picture there may be anything; also the inverse depth of the farthest surface where there is none.
const OUTSIDE: f32 = 0x1.fffffep+127f;
// Lines of sight are tested down to this share of the inverse depth of the farthest surface around.
const BEYOND_FARTHEST: f32 = 0.9;

const DIRECTIONS: array<vec2<i32>, 8> = array<vec2<i32>, 8>(
    vec2<i32>(1, 0),
    vec2<i32>(0, 1),
    vec2<i32>(1, 1),
    vec2<i32>(-1, 1),
    vec2<i32>(-1, 0),
    vec2<i32>(0, -1),
    vec2<i32>(-1, -1),
    vec2<i32>(1, -1),
);

fn reach() -> i32 {
    return clamp(i32(finish.width / COLUMNS_TO_REACH), LEAST_REACH, MOST_REACH);
}

fn squares_across() -> u32 {
    return (finish.width + 15u) / 16u;
}

fn square_count() -> u32 {
    return squares_across() * ((finish.height + 15u) / 16u);
}

// The surfaces in the square of a pixel and around it.
fn range_around(pixel: vec2<u32>) -> vec2<f32> {
    return squares[square_count() + pixel.y / 16u * squares_across() + pixel.x / 16u];
}

// Inverse depth of what a pixel shows: 0 at infinity and in holes.
fn shown_at(at: vec2<i32>) -> f32 {
    if at.x < 0 || at.y < 0 || at.x >= i32(finish.width) || at.y >= i32(finish.height) {
        return OUTSIDE;
    }
    return max(depth_at(u32(at.y) * finish.width + u32(at.x)), 0.0);
}

// The inverse depth of the farthest surface that a pixel shows; most of the pixel shows `w`.
fn farthest_shown(pixel: u32, w: f32) -> f32 {
    let front = front_at(pixel).w;
    return select(w, front, front >= 0.0);
}
