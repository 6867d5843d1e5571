//! The shaders: each is its own file after the shared pieces that it needs.

use overlook_shaders::common;

/// One compute shader.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shader {
    /// Its one entry point, which is also its name.
    pub(super) entry: &'static str,
    pieces: &'static [&'static str],
}

impl Shader {
    /// The whole source.
    pub(super) fn source(&self) -> String {
        self.pieces.concat()
    }
}

/// The shader with this entry point: a file of its own, behind the shared pieces that it needs.
macro_rules! shader {
    ($entry:literal, $own:ident $(: $($piece:ident)+)?) => {
        Shader { entry: $entry, pieces: &[$($(common::$piece,)+)? overlook_shaders::$own] }
    };
}

/// The surface stage with 64-bit atomics.
pub(super) const SURFACE_64: Shader =
    shader!("surface", SURFACE: STAGE SAMPLES PROJECT EDGES DENSE_TILE KEYS_64);
/// The surface stage with 32-bit atomics.
pub(super) const SURFACE_32: Shader =
    shader!("surface", SURFACE: STAGE SAMPLES PROJECT EDGES DENSE_TILE KEYS_32);
pub(super) const BLEND: Shader = shader!("blend", BLEND: STAGE SAMPLES PROJECT EDGES DENSE_TILE SUMS);
/// The resolve stage of kernels that do not gather.
pub(super) const RESOLVE: Shader = shader!("resolve", RESOLVE: STAGE SAMPLES SUMS PICTURE);
pub(super) const SILHOUETTE: Shader =
    shader!("silhouette", SILHOUETTE: STAGE SAMPLES PROJECT LOOKUP REPROJECT PATCH);
pub(super) const GATHER: Shader =
    shader!("gather", GATHER: STAGE SAMPLES PROJECT LOOKUP REPROJECT PATCH PICTURE);
pub(super) const DISPLAY: Shader = shader!("display", DISPLAY);
pub(super) const AVERAGE: Shader = shader!("average", AVERAGE);

/// Carries samples into the cells of cameras.
pub(super) const CARRY: Shader = shader!("carry", CARRY: STAGE SAMPLES PROJECT CELL_VIEW DENSE_TILE);
pub(super) const FREE_DEPTHS: Shader = shader!("free_depths", FREE_DEPTHS: PROJECT CELL_VIEW);
pub(super) const SUM_SKY: Shader = shader!("sum_sky", SUM_SKY: STAGE SAMPLES DENSE_TILE SUMS SKY_GRIDS);
pub(super) const HALVE_SKY: Shader = shader!("halve_sky", HALVE_SKY: SUMS SKY_GRIDS SKY_LEVELS);
pub(super) const FILL_SKY: Shader = shader!("fill_sky", FILL_SKY: SKY_GRIDS SKY_LEVELS);

/// The stages that finish a picture, in the order in which they first run.
pub(super) const FINISH: [Shader; 14] = [
    shader!("square_ranges", SQUARE_RANGES: FINISH SURROUNDINGS),
    shader!("lines_of_sight", LINES_OF_SIGHT: PROJECT CELL_VIEW FINISH SURROUNDINGS RAY_TEST),
    shader!("enclosed", ENCLOSED: FINISH SURROUNDINGS),
    shader!("open_holes", OPEN_HOLES: PROJECT CELL_VIEW FINISH SURROUNDINGS RAY_TEST),
    shader!("rims", RIMS: FINISH),
    shader!("holes", HOLES: FINISH TALLY),
    shader!("sky", SKY: FINISH SKY_GRIDS ENVIRONMENT),
    shader!("ray_masks", RAY_MASKS: FINISH HOLE_RAYS SOURCES),
    shader!("open_sky", OPEN_SKY: FINISH HOLE_RAYS SOURCES),
    shader!("kinds", KINDS: FINISH TALLY),
    shader!("pull", PULL: FINISH HOLE_RAYS PYRAMID SOURCES),
    shader!(
        "fill",
        FILL: PROJECT CELL_VIEW FINISH SKY_GRIDS ENVIRONMENT HOLE_RAYS SOURCES RAY_TEST ROUND FILLINGS PYRAMID
    ),
    shader!("around", AROUND: FINISH SKY_GRIDS ENVIRONMENT HOLE_RAYS FILLINGS),
    shader!("put_over", PUT_OVER: FINISH),
];

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga;
    use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

    fn problem(source: &str, capabilities: Capabilities) -> Option<String> {
        let module = match naga::front::wgsl::parse_str(source) {
            Ok(module) => module,
            Err(error) => return Some(error.emit_to_string(source)),
        };
        let checked = Validator::new(ValidationFlags::all(), capabilities).validate(&module);
        checked.err().map(|error| error.emit_to_string(source))
    }

    #[test]
    fn every_shader_is_valid() {
        // Halves in 32 bits are all that adapters without extras must have: see `Context::new`.
        let plain = Capabilities::SHADER_FLOAT16_IN_FLOAT32;
        let wide = plain | Capabilities::SHADER_INT64 | Capabilities::SHADER_INT64_ATOMIC_MIN_MAX;
        let plain_ones = [
            SURFACE_32,
            BLEND,
            RESOLVE,
            SILHOUETTE,
            GATHER,
            DISPLAY,
            AVERAGE,
            CARRY,
            FREE_DEPTHS,
            SUM_SKY,
            HALVE_SKY,
            FILL_SKY,
        ];
        let plain_ones = plain_ones.into_iter().chain(FINISH).map(|shader| (shader, plain));
        for (shader, capabilities) in plain_ones.chain([(SURFACE_64, wide)]) {
            let source = shader.source();
            assert_eq!(problem(&source, capabilities), None, "{}", shader.entry);
            let module = naga::front::wgsl::parse_str(&source).unwrap();
            let entries: Vec<_> = module.entry_points.iter().map(|entry| entry.name.as_str()).collect();
            assert_eq!(entries, [shader.entry]);
        }
    }

    #[test]
    fn a_broken_shader_is_found() {
        let source = BLEND.source().replace("share * share * trust / area", "share * slope");
        assert!(problem(&source, Capabilities::empty()).unwrap().contains("slope"));
        let without_wide = problem(&SURFACE_64.source(), Capabilities::SHADER_FLOAT16_IN_FLOAT32).unwrap();
        assert!(without_wide.contains("SHADER_INT64"), "{without_wide}");
    }
}
