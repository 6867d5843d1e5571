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
        for (shader, capabilities) in [
            (SURFACE_64, wide),
            (SURFACE_32, plain),
            (BLEND, plain),
            (RESOLVE, plain),
            (SILHOUETTE, plain),
            (GATHER, plain),
            (DISPLAY, plain),
        ] {
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
