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

/// The surface stage with 64-bit atomics.
pub(super) const SURFACE_64: Shader = Shader {
    entry: "surface",
    pieces: &[
        common::STAGE,
        common::SAMPLES,
        common::PROJECT,
        common::EDGES,
        common::DENSE_TILE,
        common::KEYS_64,
        overlook_shaders::SURFACE,
    ],
};
/// The surface stage with 32-bit atomics.
pub(super) const SURFACE_32: Shader = Shader {
    entry: "surface",
    pieces: &[
        common::STAGE,
        common::SAMPLES,
        common::PROJECT,
        common::EDGES,
        common::DENSE_TILE,
        common::KEYS_32,
        overlook_shaders::SURFACE,
    ],
};
pub(super) const BLEND: Shader = Shader {
    entry: "blend",
    pieces: &[
        common::STAGE,
        common::SAMPLES,
        common::PROJECT,
        common::EDGES,
        common::DENSE_TILE,
        common::SUMS,
        overlook_shaders::BLEND,
    ],
};
/// The resolve stage of kernels that do not gather.
pub(super) const RESOLVE: Shader = Shader {
    entry: "resolve",
    pieces: &[common::STAGE, common::SAMPLES, common::SUMS, common::PICTURE, overlook_shaders::RESOLVE],
};
pub(super) const SILHOUETTE: Shader = Shader {
    entry: "silhouette",
    pieces: &[
        common::STAGE,
        common::SAMPLES,
        common::PROJECT,
        common::LOOKUP,
        common::REPROJECT,
        common::PATCH,
        overlook_shaders::SILHOUETTE,
    ],
};
pub(super) const GATHER: Shader = Shader {
    entry: "gather",
    pieces: &[
        common::STAGE,
        common::SAMPLES,
        common::PROJECT,
        common::LOOKUP,
        common::REPROJECT,
        common::PATCH,
        common::PICTURE,
        overlook_shaders::GATHER,
    ],
};
pub(super) const DISPLAY: Shader = Shader { entry: "display", pieces: &[overlook_shaders::DISPLAY] };
pub(super) const AVERAGE: Shader = Shader { entry: "average", pieces: &[overlook_shaders::AVERAGE] };

/// Carries samples into the cells of cameras.
pub(super) const CARRY: Shader = Shader {
    entry: "carry",
    pieces: &[
        common::STAGE,
        common::SAMPLES,
        common::PROJECT,
        common::CELL_VIEW,
        common::DENSE_TILE,
        overlook_shaders::CARRY,
    ],
};
pub(super) const FREE_DEPTHS: Shader = Shader {
    entry: "free_depths",
    pieces: &[common::PROJECT, common::CELL_VIEW, overlook_shaders::FREE_DEPTHS],
};
pub(super) const SUM_SKY: Shader = Shader {
    entry: "sum_sky",
    pieces: &[
        common::STAGE,
        common::SAMPLES,
        common::DENSE_TILE,
        common::SUMS,
        common::SKY_GRIDS,
        overlook_shaders::SUM_SKY,
    ],
};
pub(super) const HALVE_SKY: Shader = Shader {
    entry: "halve_sky",
    pieces: &[common::SUMS, common::SKY_GRIDS, common::SKY_LEVELS, overlook_shaders::HALVE_SKY],
};
pub(super) const FILL_SKY: Shader = Shader {
    entry: "fill_sky",
    pieces: &[common::SKY_GRIDS, common::SKY_LEVELS, overlook_shaders::FILL_SKY],
};

/// The stages that finish a picture, in the order in which they first run.
pub(super) const FINISH: [Shader; 14] = [
    Shader {
        entry: "square_ranges",
        pieces: &[common::FINISH, common::SURROUNDINGS, overlook_shaders::SQUARE_RANGES],
    },
    Shader {
        entry: "lines_of_sight",
        pieces: &[
            common::PROJECT,
            common::CELL_VIEW,
            common::FINISH,
            common::SURROUNDINGS,
            common::RAY_TEST,
            overlook_shaders::LINES_OF_SIGHT,
        ],
    },
    Shader { entry: "enclosed", pieces: &[common::FINISH, common::SURROUNDINGS, overlook_shaders::ENCLOSED] },
    Shader {
        entry: "open_holes",
        pieces: &[
            common::PROJECT,
            common::CELL_VIEW,
            common::FINISH,
            common::SURROUNDINGS,
            common::RAY_TEST,
            overlook_shaders::OPEN_HOLES,
        ],
    },
    Shader { entry: "rims", pieces: &[common::FINISH, overlook_shaders::RIMS] },
    Shader { entry: "holes", pieces: &[common::FINISH, common::TALLY, overlook_shaders::HOLES] },
    Shader {
        entry: "sky",
        pieces: &[common::FINISH, common::SKY_GRIDS, common::ENVIRONMENT, overlook_shaders::SKY],
    },
    Shader {
        entry: "ray_masks",
        pieces: &[common::FINISH, common::HOLE_RAYS, common::SOURCES, overlook_shaders::RAY_MASKS],
    },
    Shader {
        entry: "open_sky",
        pieces: &[common::FINISH, common::HOLE_RAYS, common::SOURCES, overlook_shaders::OPEN_SKY],
    },
    Shader { entry: "kinds", pieces: &[common::FINISH, common::TALLY, overlook_shaders::KINDS] },
    Shader {
        entry: "pull",
        pieces: &[
            common::FINISH,
            common::HOLE_RAYS,
            common::PYRAMID,
            common::SOURCES,
            overlook_shaders::PULL,
        ],
    },
    Shader {
        entry: "fill",
        pieces: &[
            common::FINISH,
            common::SKY_GRIDS,
            common::ENVIRONMENT,
            common::HOLE_RAYS,
            common::FILLINGS,
            common::PYRAMID,
            overlook_shaders::FILL,
        ],
    },
    Shader {
        entry: "around",
        pieces: &[
            common::FINISH,
            common::SKY_GRIDS,
            common::ENVIRONMENT,
            common::HOLE_RAYS,
            common::FILLINGS,
            overlook_shaders::AROUND,
        ],
    },
    Shader { entry: "put_over", pieces: &[common::FINISH, overlook_shaders::PUT_OVER] },
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
