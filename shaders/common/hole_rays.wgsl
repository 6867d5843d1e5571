// What a hole pixel sees across its own hole: the first source in each of eight directions. Twin: src/engine/render/fill/rays.rs.
//
// Where the sources are is told by a bit each, 32 pixels of a line a word, so that a ray passes 32 pixels at a step. Lines run in
// four ways:
//
//   along rows        word of row y and columns 32·k …        bits by column
//   along columns     word of column x and rows 32·k …        bits by row
//   falling to the right, and to the left                     bits by row; lines are told apart by x − y and by x + y
//
// Two of these sets are kept side by side.

@group(1) @binding(8) var<storage, read_write> masks: array<u32>;

// Sets of sources: what shows anything; what shows a surface; and what is no open hole, in the place of the first.
const ALL_SOURCES: u32 = 0u;
const SURFACE_SOURCES: u32 = 1u;
const SOURCES_OF_OPEN: u32 = 2u;

// No source in a direction.
const NONE: f32 = 1e30;

// Words of the lines of each kind: along rows, along columns, falling to the right and to the left.
fn mask_words() -> vec4<u32> {
    let bands = (finish.height + 31u) / 32u;
    let slanted = bands * (finish.width + finish.height - 1u);
    return vec4<u32>(finish.height * ((finish.width + 31u) / 32u), bands * finish.width, slanted, slanted);
}

// Where the words of a set begin.
fn masks_at(set_of: u32) -> u32 {
    let words = mask_words();
    return (set_of & 1u) * (words.x + words.y + words.z + words.w);
}

// The words of one line.
struct Line {
    first: u32,
    stride: u32,
    count: u32,
}

// The line of a kind through a pixel.
fn line_of(set_of: u32, kind: u32, at: vec2<u32>) -> Line {
    let words = mask_words();
    let start = masks_at(set_of);
    let across = (finish.width + 31u) / 32u;
    let bands = (finish.height + 31u) / 32u;
    let slanted = finish.width + finish.height - 1u;
    switch kind {
        case 0u: { return Line(start + at.y * across, 1u, across); }
        case 1u: { return Line(start + words.x + words.y + at.x + finish.height - 1u - at.y, slanted, bands); }
        case 2u: { return Line(start + words.x + at.x, finish.width, bands); }
        default: { return Line(start + words.x + words.y + words.z + at.x + at.y, slanted, bands); }
    }
}

// Steps from a position of a line to the first source before it; 0 if there is none.
fn steps_back(line: Line, position: u32) -> u32 {
    var nth = position / 32u;
    var word = masks[line.first + nth * line.stride] & (0xffffffffu >> (31u - (position & 31u)));
    while word == 0u && nth > 0u {
        nth -= 1u;
        word = masks[line.first + nth * line.stride];
    }
    return select(position - (32u * nth + firstLeadingBit(word)), 0u, word == 0u);
}

// Steps to the first source after it.
fn steps_on(line: Line, position: u32) -> u32 {
    var nth = position / 32u;
    var word = masks[line.first + nth * line.stride] & (0xffffffffu << (position & 31u));
    while word == 0u && nth + 1u < line.count {
        nth += 1u;
        word = masks[line.first + nth * line.stride];
    }
    return select(32u * nth + firstTrailingBit(word) - position, 0u, word == 0u);
}

// What a hole pixel sees: to the left, up left, up, up right, and in the four opposite directions.
struct HoleNeighbors {
    pixel: array<u32, 8>,
    // NONE where there is no source.
    distance: array<f32, 8>,
}

fn neighbors_of(set_of: u32, at: vec2<u32>) -> HoleNeighbors {
    var seen: HoleNeighbors;
    let pixel = at.y * finish.width + at.x;
    for (var kind = 0u; kind < 4u; kind++) {
        let line = line_of(set_of, kind, at);
        let position = select(at.y, at.x, kind == 0u);
        // Pixels from one step to the next, row-major.
        let stride = select(finish.width + 2u - kind, 1u, kind == 0u);
        let length = select(1.0, 1.41421356, (kind & 1u) == 1u);
        let back = steps_back(line, position);
        let on = steps_on(line, position);
        seen.pixel[kind] = pixel - back * stride;
        seen.distance[kind] = select(f32(back) * length, NONE, back == 0u);
        seen.pixel[kind + 4u] = pixel + on * stride;
        seen.distance[kind + 4u] = select(f32(on) * length, NONE, on == 0u);
    }
    return seen;
}
