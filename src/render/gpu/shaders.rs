//! The shaders: each is its own file after the shared pieces that it needs.

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

/// The shader of a name, after the shared pieces that it needs.
macro_rules! shader {
    ($entry:literal $(, $piece:literal)*) => {
        Shader {
            entry: $entry,
            pieces: &[
                $(include_str!(concat!("../../../shaders/common/", $piece, ".wgsl")),)*
                include_str!(concat!("../../../shaders/", $entry, ".wgsl")),
            ],
        }
    };
}

/// The surface stage with 64-bit atomics.
pub(super) const SURFACE_64: Shader =
    shader!("surface", "stage", "samples", "project", "dense_tile", "keys_64");
/// The surface stage with 32-bit atomics.
pub(super) const SURFACE_32: Shader =
    shader!("surface", "stage", "samples", "project", "dense_tile", "keys_32");
pub(super) const BLEND: Shader = shader!("blend", "stage", "samples", "project", "dense_tile", "sums");
/// The resolve stage of kernels that do not gather.
pub(super) const RESOLVE: Shader = shader!("resolve", "stage", "samples", "sums", "picture");
pub(super) const SILHOUETTE: Shader =
    shader!("silhouette", "stage", "samples", "project", "lookup", "reproject", "patch");
pub(super) const GATHER: Shader =
    shader!("gather", "stage", "samples", "project", "lookup", "reproject", "patch", "picture");
pub(super) const DISPLAY: Shader = shader!("display");

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
