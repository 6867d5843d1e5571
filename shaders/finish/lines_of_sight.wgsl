// The stage that tests the lines of sight of pixels that nearer surfaces may enclose. One workgroup a square.
// Twin: `TestSquares` in src/engine/render/free_space/hidden.rs.

// Lines of sight are tested no farther than this many times the inverse depth of what is shown.
const BEFORE_SHOWN: f32 = 1.04;
// Directions that must lead to a nearer surface.
const ENOUGH_TO_TEST: u32 = 5u;
// Surfaces are looked for in this many squares on each side of a pixel's own.
const SQUARES_AROUND: i32 = 2;
// No part of a line of sight is hidden.
const NOT_HIDDEN: f32 = -1.0;
// The side of a square with what is looked at around it, pixels.
const SIDE: u32 = 48u;
const SIDE_SQUARED: u32 = 2304u;

var<workgroup> shown: array<f32, SIDE_SQUARED>;
var<workgroup> range_x: f32;
var<workgroup> range_y: f32;
var<workgroup> may_enclose: u32;

// Whether there is a surface in a square; beyond the picture there may be.
fn has_surface(square: vec2<i32>) -> bool {
    let full = vec2<i32>(vec2<u32>(finish.width, finish.height) / 16u);
    if any(square < vec2<i32>(0)) || any(square >= full) {
        return true;
    }
    return squares[u32(square.y) * squares_across() + u32(square.x)].x > 0.0;
}

// Whether surfaces in enough of the squares around one may enclose a pixel of it.
fn may_enclose_in(square: vec2<i32>) -> bool {
    var found = 0u;
    for (var nth = 0u; nth < 8u; nth++) {
        let direction = DIRECTIONS[nth];
        let leads = has_surface(square)
            || has_surface(square + vec2<i32>(direction.x, 0))
            || has_surface(square + vec2<i32>(0, direction.y))
            || has_surface(square + direction);
        found += select(0u, 1u, leads);
    }
    return found >= ENOUGH_TO_TEST;
}

// The surfaces in a square and around it.
fn joined_around(square: vec2<i32>) -> vec2<f32> {
    let across = i32(squares_across());
    let down = i32(square_count()) / across;
    var range = vec2<f32>(0.0, OUTSIDE);
    for (var y = max(square.y - SQUARES_AROUND, 0); y <= min(square.y + SQUARES_AROUND, down - 1); y++) {
        for (var x = max(square.x - SQUARES_AROUND, 0); x <= min(square.x + SQUARES_AROUND, across - 1); x++) {
            let other = squares[u32(y * across + x)];
            range = vec2<f32>(max(range.x, other.x), min(range.y, other.y));
        }
    }
    return range;
}

// Whether enough directions lead from a pixel of the square to a surface nearer than `w`, or out of the picture.
fn may_be_enclosed(local: vec2<u32>, w: f32) -> bool {
    let start = i32((local.y + 16u) * SIDE + local.x + 16u);
    let reach = reach();
    var found = 0u;
    for (var nth = 0u; nth < 8u; nth++) {
        let direction = DIRECTIONS[nth];
        let stride = direction.y * i32(SIDE) + direction.x;
        var nearest = 0.0;
        for (var step = 1; step <= reach; step++) {
            nearest = max(nearest, shown[start + step * stride]);
        }
        found += select(0u, 1u, nearest > w * NEARER);
    }
    return found >= ENOUGH_TO_TEST;
}

@compute @workgroup_size(16, 16)
fn lines_of_sight(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(global_invocation_id) at: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let square = vec2<i32>(group.xy);
    if thread == 0u {
        let range = joined_around(square);
        squares[square_count() + group.y * squares_across() + group.x] = range;
        range_x = range.x;
        range_y = range.y;
        may_enclose = select(0u, 1u, knows_sky() && may_enclose_in(square));
    }
    let is_inside = at.x < finish.width && at.y < finish.height;
    let pixel = at.y * finish.width + at.x;
    if is_inside {
        planes[pixel] = NOT_HIDDEN;
    }
    if workgroupUniformLoad(&may_enclose) == 0u {
        return;
    }
    for (var nth = thread; nth < SIDE_SQUARED; nth += 256u) {
        shown[nth] = shown_at(square * 16 + vec2<i32>(i32(nth % SIDE), i32(nth / SIDE)) - MOST_REACH);
    }
    workgroupBarrier();
    if !is_inside {
        return;
    }
    let w = farthest_shown(pixel, shown[(local.y + 16u) * SIDE + local.x + 16u]);
    let far = max(w * BEFORE_SHOWN, range_y * BEYOND_FARTHEST);
    if range_x > far && may_be_enclosed(local.xy, w) {
        let line = test_line(vec2<f32>(at.xy), range_x, far);
        if line.kind == HIDDEN {
            planes[pixel] = line.end;
            planes[hidden_share_at(pixel)] = line.share;
        }
    }
}
