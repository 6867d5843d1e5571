// The stage that makes one level of the pyramid: every cell is the mean of the farthest surface in its block of 2×2.
// Twin: `halve` in src/engine/render/fill/pyramid.rs.

fn part_at(set_of: u32, finer: Level, is_finest: bool, column: u32, row: u32) -> WeightedMean {
    if is_finest {
        let pixel = row * finish.width + column;
        return WeightedMean(color_at(pixel), depth_at(pixel), select(0.0, 1.0, is_source(set_of, pixel)));
    }
    return cell_at(finer, column, row);
}

@compute @workgroup_size(16, 16)
fn pull(@builtin(global_invocation_id) at: vec3<u32>) {
    let set_of = at.z;
    let is_finest = finish.step == 0u;
    var finer = Level(vec2<u32>(finish.width, finish.height), 0u);
    var level = finest_level(set_of);
    for (var nth = 0u; nth < finish.step; nth++) {
        finer = level;
        level = coarser_level(level);
    }
    if at.x >= level.size.x || at.y >= level.size.y || !is_asked(set_of) {
        return;
    }
    // The last block of an odd picture is smaller: its pixels count twice.
    let first = 2u * at.xy;
    let last = min(first + 1u, finer.size - 1u);
    var parts: array<WeightedMean, 4>;
    var farthest = 0x1.fffffep+127f;
    for (var nth = 0u; nth < 4u; nth++) {
        let column = select(first.x, last.x, (nth & 1u) == 1u);
        let row = select(first.y, last.y, nth >= 2u);
        parts[nth] = part_at(set_of, finer, is_finest, column, row);
        farthest = select(farthest, min(farthest, parts[nth].inverse_depth), parts[nth].weight > 0.0);
    }
    let limit = farthest * tolerance_over(f32(2u << finish.step));
    var sum: WeightedMean;
    for (var nth = 0u; nth < 4u; nth++) {
        if parts[nth].weight > 0.0 && parts[nth].inverse_depth <= limit {
            add(&sum, parts[nth].weight, parts[nth].color, parts[nth].inverse_depth);
        }
    }
    if sum.weight > 0.0 {
        sum = normalized(sum);
        sum.weight /= 4.0;
    }
    let place = 5u * (level.first + at.y * level.size.x + at.x);
    pyramid[place] = sum.color.x;
    pyramid[place + 1u] = sum.color.y;
    pyramid[place + 2u] = sum.color.z;
    pyramid[place + 3u] = sum.inverse_depth;
    pyramid[place + 4u] = sum.weight;
}
