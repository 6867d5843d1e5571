// How far round things go on beyond what was seen of them. Twin: src/engine/render/fill/round.rs.

// Pixels from each sample of a section to the next: the widest first, less by two each time, down to two.
const WIDEST_SPACING: i32 = 6;
const JOINED_PX: f32 = 8.0;
const LARGEST_RADIUS: f32 = 0.3;
const ODDS_OF_COVERED: f32 = 0.05;
const MOST_DOUBLINGS: u32 = 3u;
const MOST_SKY_OF_COVERED: f32 = 0.97;
// No direction.
const NO_DIRECTION: u32 = 8u;
const STEP = array<vec2<i32>, 8>(
    vec2<i32>(-1, 0), vec2<i32>(-1, -1), vec2<i32>(0, -1), vec2<i32>(1, -1),
    vec2<i32>(1, 0), vec2<i32>(1, 1), vec2<i32>(0, 1), vec2<i32>(-1, 1),
);

struct RoundVotes {
    // The direction of the nearest thing that goes on through the pixel, or NO_DIRECTION.
    covering: u32,
    covering_count: u32,
    ending_count: u32,
    silent_count: u32,
}

fn line_of_sight(at: vec2<i32>) -> vec3<f32> {
    return finish.first_ray + finish.ray_across * f32(at.x) + finish.ray_down * f32(at.y);
}

// Whether a pixel shows a surface that holes are filled from. What fills a hole meanwhile has no image.
fn is_surface_source(set_of: u32, at: vec2<i32>) -> bool {
    if any(at < vec2<i32>(0)) || any(at >= vec2<i32>(vec2<u32>(finish.width, finish.height))) {
        return false;
    }
    let pixel = u32(at.y) * finish.width + u32(at.x);
    return image_at(pixel) != NO_IMAGE && depth_at(pixel) > 0.0 && (set_of == ALL_SOURCES || !is_left_out(pixel));
}

fn depth_of(at: vec2<i32>) -> f32 {
    return depth_at(u32(at.y) * finish.width + u32(at.x));
}

// The center of a section and its squared radius, 0 where there is none, at a pixel beside a hole.
fn section_at(set_of: u32, at: vec2<i32>, direction: u32) -> vec4<f32> {
    let step = STEP[direction];
    let joined = tolerance_over(JOINED_PX);
    var last = depth_of(at);
    var length = 0;
    while length < 2 * WIDEST_SPACING {
        let there = at + step * (length + 1);
        if !is_surface_source(set_of, there) {
            break;
        }
        let next = depth_of(there);
        if max(next, last) > min(next, last) * joined {
            break;
        }
        last = next;
        length++;
    }
    let spacing = min(length / 4 * 2, WIDEST_SPACING);
    if spacing == 0 {
        return vec4<f32>(0.0);
    }
    let far = at + step * (2 * spacing);
    let near = at + step * spacing;
    let start = line_of_sight(far) / depth_of(far);
    let middle = line_of_sight(near) / depth_of(near);
    let a = line_of_sight(at) / depth_of(at) - start;
    let b = middle - start;
    let normal = cross(a, b);
    let square = dot(normal, normal);
    if square <= 0x1p-126f {
        return vec4<f32>(0.0);
    }
    let from_start = cross(b * dot(a, a) - a * dot(b, b), normal) / (2.0 * square);
    let center = start + from_start;
    let radius_squared = dot(from_start, from_start);
    let is_round = dot(center - middle, middle) > 0.0;
    let is_small = radius_squared < LARGEST_RADIUS * LARGEST_RADIUS * dot(middle, middle);
    return select(vec4<f32>(0.0), vec4<f32>(center, radius_squared), is_round && is_small);
}

// Whether any camera saw through the line of sight of a pixel somewhere between two inverse depths.
fn sees_through(at: vec2<f32>, near: f32, far: f32) -> bool {
    for (var nth = 0u; nth < finish.view_count; nth++) {
        let view = views[nth];
        let sight = ray(view.cells_from_target, at.x, at.y);
        if look(view, sight, near, (near - far) / 4.0, 0u, 0xfffffff0u).x != 0u {
            return true;
        }
    }
    return false;
}

// Whether a round thing goes on through a pixel.
fn goes_on(section: vec4<f32>, at: vec2<i32>) -> bool {
    let line = line_of_sight(at);
    let along = dot(section.xyz, line);
    let square = dot(line, line);
    let inside = along * along - square * (dot(section.xyz, section.xyz) - section.w);
    let front = along - sqrt(max(inside, 0.0));
    return inside > 0.0 && front > 0.0 && !sees_through(vec2<f32>(at), square / front, square / along);
}

fn votes_of_round_things(set_of: u32, at: vec2<u32>, seen: HoleNeighbors) -> RoundVotes {
    var votes = RoundVotes(NO_DIRECTION, 0u, 0u, 0u);
    var nearest = 0.0;
    var seen_of = seen;
    // Of an orthographic camera all lines of sight are one.
    if !knows_sky() || all(finish.ray_across == vec3<f32>(0.0)) {
        return votes;
    }
    for (var direction = 0u; direction < 8u; direction++) {
        if seen_of.distance[direction] >= NONE {
            continue;
        }
        let pixel = seen_of.pixel[direction];
        let w = depth_at(pixel);
        let there = vec2<i32>(vec2<u32>(pixel % finish.width, pixel / finish.width));
        if !is_surface_source(set_of, there) {
            continue;
        }
        let section = section_at(set_of, there, direction);
        if section.w == 0.0 {
            votes.silent_count++;
        } else if !goes_on(section, vec2<i32>(at)) {
            votes.ending_count++;
        } else {
            votes.covering_count++;
            if w > nearest {
                nearest = w;
                votes.covering = direction;
            }
        }
    }
    return votes;
}

// The share of the sky in a pixel, where it is `without` round things.
fn sky_share_by(votes: RoundVotes, without: f32) -> f32 {
    let share = min(without, select(1.0, MOST_SKY_OF_COVERED, votes.covering < NO_DIRECTION));
    var odds = f32(1u << min(max(votes.ending_count, votes.silent_count) - votes.silent_count, MOST_DOUBLINGS));
    for (var nth = 0u; nth < votes.covering_count; nth++) {
        odds *= ODDS_OF_COVERED;
    }
    let sky = share * odds;
    return select(share, sky / (sky + 1.0 - share), odds != 1.0 && sky > 0.0);
}
