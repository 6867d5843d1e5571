// What the stages that finish a painted picture share: its pixels, and what is known about its holes. Twin: src/engine/render/finish.rs.
//
//   picture   as in picture.wgsl
//   planes    a word per pixel for each of three planes: until where its line of sight is hidden, later whether its color may be
//             blended with one that is no longer shown; and its mark; and the share of its line of sight that is hidden, negative
//             where parts of a surface face each other across an open hole. Then three words per pixel: the color of what is shown in part

struct Finish {
    // Size of the picture, pixels.
    width: u32,
    height: u32,
    // Which of several runs of a stage this is.
    step: u32,
    // Entries of `views`.
    view_count: u32,
    // World-space ray of the center of the first pixel, and its growth by column and row.
    first_ray: vec3<f32>,
    // Footprints by which inverse depths of one surface may differ, and the focal length in pixels.
    footprints: f32,
    ray_across: vec3<f32>,
    focal: f32,
    ray_down: vec3<f32>,
    // 1 if the picture tells what pixels show in front of their farthest surface.
    with_fronts: u32,
    // 1 if lines of sight are tested.
    tests_lines: u32,
    // 1 if the picture tells which shares of pixels are shown.
    with_coverage: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(1) @binding(0) var<uniform> finish: Finish;
@group(1) @binding(1) var<storage, read_write> picture: array<u32>;
@group(1) @binding(2) var<storage, read_write> counts: array<atomic<u32>, 6>;
@group(1) @binding(3) var<storage, read_write> planes: array<f32>;
@group(1) @binding(6) var<storage, read> environment: array<vec4<f32>>;

// Places in `counts`: holes, those whose mark is OPEN_HOLE, those that are filled from all around and those that hide a surface,
// pixels that show a surface, and those of them whose color may be blended with one that is no longer shown.
const HOLES: u32 = 0u;
const OPEN_HOLES: u32 = 1u;
const PLAIN_HOLES: u32 = 2u;
const HIDING_HOLES: u32 = 3u;
const SURFACES: u32 = 4u;
const BLENDED_SURFACES: u32 = 5u;

// Marks a pixel that no sample reached.
const NO_IMAGE: u32 = 0xffffffffu;

// Marks of holes, in place of inverse depths, and of a pixel that shows its sample. See src/engine/render/free_space/hidden.rs.
const HOLE: f32 = -1.0;
const OPEN_HOLE: f32 = -0x1.fffffep+126f;
const SKY_HOLE: f32 = -0x1.fffffep+127f;
const SHOWN: f32 = 1.0;

// A pixel shows samples from this share on that they cover.
const LEAST_SHOWN: f32 = 0.5;
// From this share on a pixel is shown as a whole.
const WHOLE: f32 = 0.999;

// Where in the environment is told how often the sky was seen: behind all grids.
const SKY_SEEN_AT: u32 = 299593u;

// Workgroups in a row of a dispatch; further ones go into further rows, as one dimension holds 65535 at most.
const GROUPS_ACROSS: u32 = 32768u;

fn pixel_count() -> u32 {
    return finish.width * finish.height;
}

fn color_at(pixel: u32) -> vec3<f32> {
    let at = 3u * pixel;
    return vec3<f32>(bitcast<f32>(picture[at]), bitcast<f32>(picture[at + 1u]), bitcast<f32>(picture[at + 2u]));
}

fn set_color(pixel: u32, color: vec3<f32>) {
    picture[3u * pixel] = bitcast<u32>(color.x);
    picture[3u * pixel + 1u] = bitcast<u32>(color.y);
    picture[3u * pixel + 2u] = bitcast<u32>(color.z);
}

fn depth_at(pixel: u32) -> f32 {
    return bitcast<f32>(picture[3u * pixel_count() + pixel]);
}

fn set_depth(pixel: u32, inverse_depth: f32) {
    picture[3u * pixel_count() + pixel] = bitcast<u32>(inverse_depth);
}

fn image_at(pixel: u32) -> u32 {
    return picture[4u * pixel_count() + pixel];
}

// Whether a pixel is shown in part.
fn is_partial(pixel: u32) -> bool {
    let share = bitcast<f32>(picture[5u * pixel_count() + pixel]);
    return finish.with_coverage != 0u && share > 0.0 && share < WHOLE;
}

// Where the color of a pixel that is shown in part is kept.
fn kept_at(pixel: u32) -> u32 {
    return 3u * (pixel_count() + pixel);
}

// Where is told which share of a line of sight is hidden.
fn hidden_share_at(pixel: u32) -> u32 {
    return 2u * pixel_count() + pixel;
}

// The share of a pixel that lies in front of its farthest surface.
fn front_share_at(pixel: u32) -> f32 {
    if finish.with_fronts == 0u {
        return 0.0;
    }
    return bitcast<f32>(picture[6u * pixel_count() + 5u * pixel + 4u]);
}

// What a pixel shows in front of its farthest surface, and the inverse depth of that one; negative if there is but one.
fn front_at(pixel: u32) -> vec4<f32> {
    if finish.with_fronts == 0u {
        return vec4<f32>(0.0, 0.0, 0.0, -1.0);
    }
    let at = 6u * pixel_count() + 5u * pixel;
    return vec4<f32>(
        bitcast<f32>(picture[at]),
        bitcast<f32>(picture[at + 1u]),
        bitcast<f32>(picture[at + 2u]),
        bitcast<f32>(picture[at + 3u]),
    );
}

fn mark_at(pixel: u32) -> f32 {
    return planes[pixel_count() + pixel];
}

// Whether lines of sight are tested and a camera saw the sky; else nothing is known about what holes show.
fn knows_sky() -> bool {
    return finish.tests_lines != 0u && environment[SKY_SEEN_AT].w > 0.0;
}

// Whether there is something to fill, and something to fill it from.
fn has_filling() -> bool {
    let holes = atomicLoad(&counts[HOLES]);
    return holes > 0u && holes < pixel_count();
}
