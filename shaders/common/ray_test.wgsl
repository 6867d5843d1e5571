// Which parts of a line of sight no camera has seen free. Twin: src/engine/render/free_space/ray_test.rs.

@group(1) @binding(5) var<storage, read> views: array<CellView>;
@group(1) @binding(7) var<storage, read> free_depths: array<f32>;

// What cameras know about a line of sight.
const FREE: u32 = 0u;
const UNSEEN_IN_PART: u32 = 1u;
const HIDDEN: u32 = 2u;

struct LineOfSight {
    kind: u32,
    // The inverse depth at which the longest hidden part ends.
    end: f32,
    // Share of the tested inverse depths that is hidden.
    share: f32,
}

// At which of 32 inverse depths from number `first` on, other than those in `known`, a camera saw a line of sight free, and at which it
// saw something in front of it: one bit each.
fn look(view: CellView, sight: vec3<f32>, near: f32, step: f32, first: u32, known: u32) -> vec2<u32> {
    let corners = vec2<u32>(view.across - 1u, view.down - 1u);
    let last = vec2<f32>(corners - 1u);
    let origin = view.cells_from_target.origin;
    var found = vec2<u32>(0u);
    for (var left = ~known; left != 0u; left &= left - 1u) {
        let nth = firstTrailingBit(left);
        let w = near - step * (f32(first + nth) + 0.5);
        let point = sight + origin * w;
        let reciprocal = 1.0 / point.z;
        if !(reciprocal > 0.0) {
            continue;
        }
        let corner = vec2<u32>(clamp(point.xy * reciprocal + 1.5, vec2<f32>(0.0), last));
        let farthest = free_depths[view.first + corner.y * corners.x + corner.x];
        if farthest < w * reciprocal * view.behind_ratio {
            found.x |= 1u << nth;
        } else if farthest < UNSEEN {
            found.y |= 1u << nth;
        }
    }
    return found;
}

// Tests the line of sight of a pixel between two inverse depths.
fn test_line(at: vec2<f32>, near: f32, far: f32) -> LineOfSight {
    let step = (near - far) / 64.0;
    var free = vec2<u32>(0u);
    var blocked = vec2<u32>(0u);
    for (var nth = 0u; nth < finish.view_count; nth++) {
        let view = views[nth];
        let sight = ray(view.cells_from_target, at.x, at.y);
        let nearer = look(view, sight, near, step, 0u, free.x);
        let farther = look(view, sight, near, step, 32u, free.y);
        free |= vec2<u32>(nearer.x, farther.x);
        blocked |= vec2<u32>(nearer.y, farther.y);
        if all(free == vec2<u32>(0xffffffffu)) {
            break;
        }
    }
    blocked &= ~free;
    if any(blocked != vec2<u32>(0u)) {
        let share = f32(countOneBits(blocked.x) + countOneBits(blocked.y)) / 64.0;
        return LineOfSight(HIDDEN, near - step * f32(end_of_longest_run(blocked)), share);
    }
    return LineOfSight(select(UNSEEN_IN_PART, FREE, all(free == vec2<u32>(0xffffffffu))), 0.0, 0.0);
}

// The position after the longest run of set bits.
fn end_of_longest_run(bits: vec2<u32>) -> u32 {
    var longest = 0u;
    var end = 0u;
    var length = 0u;
    for (var nth = 0u; nth < 64u; nth++) {
        let word = select(bits.x, bits.y, nth >= 32u);
        length = select(0u, length + 1u, (word >> (nth & 31u) & 1u) == 1u);
        if length > longest {
            longest = length;
            end = nth + 1u;
        }
    }
    return end;
}
