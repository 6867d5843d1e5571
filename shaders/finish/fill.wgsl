// The stage that fills holes from the surface behind. Twins: `surface_behind` in src/engine/render/fill/surface.rs, `Pyramid::push` in
// src/engine/render/fill/pyramid.rs.

// Directions in which the hole is up to this many times as wide as where it is narrowest count.
const MAX_WIDTH_RATIO: f32 = 4.0;
// A surface counts as no farther than a limit from this share of its inverse depth on.
const LIMIT_SLACK: f32 = 0.95;
// A block counts fully if at least this share of it is painted.
const FULL_SHARE: f32 = 0.5;
// Blocks up to this many times as wide as the distance to the surface count.
const MAX_BLOCK_RATIO: f32 = 8.0;
// Filling a pixel ends when less than this share of it is open.
const MAX_OPEN_SHARE: f32 = 0.015625;
const LARGEST: f32 = 0x1.fffffep+127f;
// Densities of surfaces in hidden space, and the share of the sky within nearer surfaces where hardly anything is hidden.
// Twin: src/engine/render/free_space/sky_share.rs.
const FACING_DENSITY: f32 = 16.0;
const ENCLOSED_DENSITY: f32 = 24.0;
const ENCLOSED_SKY: f32 = 0.9;

struct HoleSurface {
    is_found: bool,
    // Smallest and largest inverse depth of it that the pixel sees.
    range: vec2<f32>,
    // The mean of what the pixel sees of it.
    mean: WeightedMean,
    // Distance to the remotest pixel that it sees of it.
    reach: f32,
}

// The smallest inverse depth that the surface hidden in a hole may have, from the hole's own.
fn hidden_surface_limit(hole: f32) -> f32 {
    return select(0.0, HOLE - hole, hole > OPEN_HOLE && hole < HOLE);
}

// Inverse depth and distance of the surface that goes on through the hole: the farthest that is no farther than `limit`, across the hole
// where it is narrow, else the nearest; a distance of NONE if the pixel sees nothing.
fn behind(distances: array<f32, 8>, depths: array<f32, 8>, limit: f32) -> vec2<f32> {
    var distance_of = distances;
    var w = depths;
    var widths: array<f32, 4>;
    var narrowest = NONE;
    for (var nth = 0u; nth < 4u; nth++) {
        let both = distance_of[nth] + distance_of[nth + 4u];
        // Where one of two opposite rays leaves the picture, the hole is taken to be as wide on that side as on the other.
        widths[nth] = select(2.0 * min(distance_of[nth], distance_of[nth + 4u]), both, both < NONE);
        narrowest = select(narrowest, min(narrowest, both), both < NONE);
    }
    var found = vec2<f32>(0.0, NONE);
    var nearest = vec2<f32>(-1.0, NONE);
    for (var direction = 0u; direction < 8u; direction++) {
        let distance = distance_of[direction];
        if distance >= NONE {
            continue;
        }
        let far = w[direction];
        if far > nearest.x || (far == nearest.x && distance < nearest.y) {
            nearest = vec2<f32>(far, distance);
        }
        let counts_here = far >= limit * LIMIT_SLACK && widths[direction & 3u] <= MAX_WIDTH_RATIO * narrowest;
        if counts_here && (found.y >= NONE || far < found.x || (far == found.x && distance < found.y)) {
            found = vec2<f32>(far, distance);
        }
    }
    return select(found, nearest, found.y >= NONE);
}

fn surface_behind(all_seen: HoleNeighbors, limit: f32, covering: u32) -> HoleSurface {
    var seen = all_seen;
    var w: array<f32, 8>;
    for (var direction = 0u; direction < 8u; direction++) {
        w[direction] = select(0.0, depth_at(seen.pixel[direction]), seen.distance[direction] < NONE);
    }
    var chosen = behind(seen.distance, w, limit);
    if covering < NO_DIRECTION {
        chosen = vec2<f32>(w[covering], seen.distance[covering]);
    }
    let far = chosen.x;
    var surface: HoleSurface;
    var mean: WeightedMean;
    surface.is_found = chosen.y < NONE;
    surface.range = vec2<f32>(far);
    for (var direction = 0u; direction < 8u; direction++) {
        let near = w[direction];
        let distance = seen.distance[direction];
        if distance < NONE && max(near, far) <= min(near, far) * tolerance_over(distance + chosen.y) {
            surface.range = vec2<f32>(min(surface.range.x, near), max(surface.range.y, near));
            surface.reach = max(surface.reach, distance);
            add(&mean, 1.0 / (distance * distance), color_at(seen.pixel[direction]), near);
        }
    }
    if surface.is_found {
        surface.mean = normalized(mean);
    }
    return surface;
}

// The two cells on both sides of a pixel's center along one side of the picture, and the share of the second.
struct CellEnds {
    first: u32,
    second: u32,
    share: f32,
}

fn ends(pixel: u32, count: u32, log2_block: u32) -> CellEnds {
    let past_center = i32(2u * pixel + 1u) - i32(1u << log2_block);
    let first = past_center >> (log2_block + 1u);
    let rest = past_center - (first << (log2_block + 1u));
    let last = i32(count) - 1;
    let share = f32(rest) / f32(2u << log2_block);
    return CellEnds(u32(clamp(first, 0, last)), u32(clamp(first + 1, 0, last)), share);
}

// The color and inverse depth for a hole pixel, from cells of the surface, else the mean of what it sees of it. A weight of 0 if there is
// neither.
fn push(set_of: u32, at: vec2<u32>, surface: HoleSurface) -> WeightedMean {
    var largest = LARGEST;
    if surface.is_found {
        largest = MAX_BLOCK_RATIO * surface.reach;
    }
    var sum: WeightedMean;
    var level = finest_level(set_of);
    for (var nth = 0u; nth < 32u; nth++) {
        let block = f32(2u << nth);
        if block > largest || sum.weight > 1.0 - MAX_OPEN_SHARE {
            break;
        }
        let factor = tolerance_over(block);
        var range = vec2<f32>(0.0, LARGEST);
        if surface.is_found {
            range = vec2<f32>(surface.range.x / factor, surface.range.y * factor);
        }
        let open = 1.0 - sum.weight;
        let columns = ends(at.x, level.size.x, nth + 1u);
        let rows = ends(at.y, level.size.y, nth + 1u);
        for (var corner = 0u; corner < 4u; corner++) {
            let is_right = (corner & 1u) == 1u;
            let is_below = corner >= 2u;
            let cell = cell_at(level, select(columns.first, columns.second, is_right), select(rows.first, rows.second, is_below));
            if cell.weight > 0.0 && cell.inverse_depth >= range.x && cell.inverse_depth <= range.y {
                let share = select(1.0 - columns.share, columns.share, is_right) * select(1.0 - rows.share, rows.share, is_below);
                add(&sum, open * share * min(cell.weight / FULL_SHARE, 1.0), cell.color, cell.inverse_depth);
            }
        }
        if level.size.x == 1u && level.size.y == 1u {
            break;
        }
        level = coarser_level(level);
    }
    if sum.weight > 0.0 {
        return normalized(sum);
    }
    return surface.mean;
}

// The share of a hole that shows the sky, by its mark and the share of its line of sight that is hidden.
fn sky_share(hole: f32, hidden: f32) -> f32 {
    if hole != OPEN_HOLE {
        return ENCLOSED_SKY * exp(-ENCLOSED_DENSITY * hidden);
    }
    return select(1.0, exp(FACING_DENSITY * hidden), hidden < 0.0);
}

@compute @workgroup_size(16, 16)
fn fill(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= finish.width || at.y >= finish.height || !has_filling() {
        return;
    }
    let pixel = at.y * finish.width + at.x;
    let hole = depth_at(pixel);
    var share = NOT_FILLED;
    if hole < 0.0 {
        let set_of = select(ALL_SOURCES, SURFACE_SOURCES, hole < HOLE);
        let seen = neighbors_of(set_of, at.xy);
        let votes = votes_of_round_things(set_of, at.xy, seen);
        let surface = surface_behind(seen, hidden_surface_limit(hole), votes.covering);
        let filling = push(set_of, at.xy, surface);
        if filling.weight > 0.0 {
            share = 0.0;
            if knows_sky() && hole < HOLE {
                share = sky_share_by(votes, sky_share(hole, planes[hidden_share_at(pixel)]));
            }
            set_color(pixel, filling.color);
            set_depth(pixel, filling.inverse_depth);
        }
    } else if hole == 0.0 && image_at(pixel) == NO_IMAGE {
        share = ONLY_SKY;
    }
    set_sky_share(pixel, share);
}
