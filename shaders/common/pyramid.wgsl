// Means of ever larger blocks of sources, each of one surface alone. Twin: src/engine/render/fill/pyramid.rs.
//
// Five words a cell: color, inverse depth, and weight. Levels follow each other, the finest first, and so do two sets of sources.

@group(1) @binding(9) var<storage, read_write> pyramid: array<f32>;

struct WeightedMean {
    color: vec3<f32>,
    inverse_depth: f32,
    weight: f32,
}

fn add(sum: ptr<function, WeightedMean>, weight: f32, color: vec3<f32>, inverse_depth: f32) {
    (*sum).color += weight * color;
    (*sum).inverse_depth += weight * inverse_depth;
    (*sum).weight += weight;
}

fn normalized(sum: WeightedMean) -> WeightedMean {
    let scale = 1.0 / sum.weight;
    return WeightedMean(sum.color * scale, sum.inverse_depth * scale, sum.weight);
}

// Columns and rows of a level, and where its cells begin.
struct Level {
    size: vec2<u32>,
    first: u32,
}

// The finest level of a set.
fn finest_level(set_of: u32) -> Level {
    let size = (vec2<u32>(finish.width, finish.height) + 1u) / 2u;
    return Level(size, set_of * (arrayLength(&pyramid) / 10u));
}

// The next coarser level.
fn coarser_level(level: Level) -> Level {
    return Level((level.size + 1u) / 2u, level.first + level.size.x * level.size.y);
}

fn cell_at(level: Level, column: u32, row: u32) -> WeightedMean {
    let at = 5u * (level.first + row * level.size.x + column);
    let color = vec3<f32>(pyramid[at], pyramid[at + 1u], pyramid[at + 2u]);
    return WeightedMean(color, pyramid[at + 3u], pyramid[at + 4u]);
}

// The factor by which inverse depths of one surface may differ over a distance in pixels.
fn tolerance_over(distance: f32) -> f32 {
    return 1.0 + (finish.footprints + distance) / finish.focal;
}
