//! Reads files of Gaussian splats by the descriptions of their formats alone.

use std::path::Path;

use glam::{Quat, Vec3};
use serde_json::Value;

/// A splat as a viewer takes it from a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadSplat {
    pub(crate) center: Vec3,
    pub(crate) rotation: Quat,
    /// Standard deviations.
    pub(crate) radii: Vec3,
    /// sRGB-encoded, 0 to 1.
    pub(crate) color: Vec3,
    pub(crate) opacity: f32,
}

/// Splats that are seen together, and when: for each change a time and whether they are seen from there on; none if always.
#[derive(Debug)]
pub(crate) struct ReadSpan {
    pub(crate) splats: Vec<ReadSplat>,
    pub(crate) changes: Vec<(f32, bool)>,
}

impl ReadSpan {
    /// Whether the splats are seen at a time.
    pub(crate) fn is_seen(&self, time: f32) -> bool {
        let last = self.changes.iter().rfind(|change| change.0 <= time);
        last.is_none_or(|change| change.1)
    }
}

/// The color that a coefficient of degree 0 gives.
fn shown(coefficients: Vec3) -> Vec3 {
    coefficients * 0.282_094_8 + 0.5
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap())).collect()
}

/// The splats of a PLY file, and the lines of its header.
pub(crate) fn ply(path: &Path) -> (Vec<ReadSplat>, Vec<String>) {
    let bytes = std::fs::read(path).unwrap();
    let end = bytes.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let header: Vec<String> =
        String::from_utf8(bytes[..end].to_vec()).unwrap().lines().map(str::to_owned).collect();
    let names: Vec<&str> = header.iter().filter_map(|line| line.strip_prefix("property float ")).collect();
    let values = floats(&bytes[end..]);
    let splats = values.chunks_exact(names.len()).map(|values| {
        let get = |name: &str| values[names.iter().position(|known| *known == name).unwrap()];
        ReadSplat {
            center: Vec3::from(["x", "y", "z"].map(get)),
            rotation: Quat::from_array(["rot_1", "rot_2", "rot_3", "rot_0"].map(get)),
            radii: Vec3::from(["scale_0", "scale_1", "scale_2"].map(get).map(f32::exp)),
            color: shown(Vec3::from(["f_dc_0", "f_dc_1", "f_dc_2"].map(get))),
            opacity: 1.0 / (1.0 + (-get("opacity")).exp()),
        }
    });
    (splats.collect(), header)
}

/// The splats of an SPZ file of version 3, in its unit.
pub(crate) fn spz(path: &Path) -> Vec<ReadSplat> {
    let bytes = std::fs::read(path).unwrap();
    let length = u32::from_le_bytes(*bytes.last_chunk().unwrap()) as usize;
    let mut raw = vec![0; length];
    libdeflater::Decompressor::new().gzip_decompress(&bytes, &mut raw).unwrap();
    let word = |at: usize| u32::from_le_bytes(raw[at..at + 4].try_into().unwrap());
    assert_eq!((word(0), word(4), raw[12], raw[14], raw[15]), (0x5053_474e, 3, 0, 0, 0));
    let (count, steps) = (word(8) as usize, f32::from(raw[13]).exp2());
    assert_eq!(raw.len(), 16 + 20 * count);
    let at = |stream: usize, bytes: usize, nth: usize| 16 + stream * count + bytes * nth;
    let splat = |nth: usize| {
        let coordinate = |axis: usize| {
            let first = at(0, 9, nth) + 3 * axis;
            (i32::from_le_bytes([0, raw[first], raw[first + 1], raw[first + 2]]) >> 8) as f32 / steps
        };
        let three = |first: usize| Vec3::from([0, 1, 2].map(|axis| f32::from(raw[first + axis])));
        let logs = three(at(13, 3, nth)) / 16.0 - 10.0;
        ReadSplat {
            center: Vec3::from([0, 1, 2].map(coordinate)),
            rotation: smallest_three(word(at(16, 4, nth))),
            radii: Vec3::new(logs.x.exp(), logs.y.exp(), logs.z.exp()),
            color: shown((three(at(10, 3, nth)) / 255.0 - 0.5) / 0.15),
            opacity: f32::from(raw[at(9, 1, nth)]) / 255.0,
        }
    };
    (0..count).map(splat).collect()
}

fn smallest_three(packed: u32) -> Quat {
    let largest = (packed >> 30) as usize;
    let (mut parts, mut left, mut rest) = ([0.0; 4], packed, 1.0_f32);
    for at in (0..4).rev().filter(|at| *at != largest) {
        let size = (left & 511) as f32 / 511.0 * std::f32::consts::FRAC_1_SQRT_2;
        parts[at] = if left >> 9 & 1 == 1 { -size } else { size };
        (left, rest) = (left >> 10, rest - size * size);
    }
    parts[largest] = rest.max(0.0).sqrt();
    Quat::from_array(parts)
}

/// The JSON of a binary glTF file, and its binary part.
pub(crate) fn glb_parts(path: &Path) -> (Value, Vec<u8>) {
    let bytes = std::fs::read(path).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (b"glTF".as_slice(), 2, bytes.len()));
    let json = 20 + word(12);
    assert_eq!((&bytes[16..20], &bytes[json + 4..json + 8]), (b"JSON".as_slice(), b"BIN\0".as_slice()));
    assert_eq!((json % 4, json + 8 + word(json)), (0, bytes.len()));
    (serde_json::from_slice(&bytes[20..json]).unwrap(), bytes[json + 8..].to_vec())
}

/// The spans of a binary glTF file, and by how much its root moves them.
pub(crate) fn glb(path: &Path) -> (Vec<ReadSpan>, glam::DVec3) {
    let (json, binary) = glb_parts(path);
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let bytes_of = |accessor: usize, size: usize| {
        let accessor = &json["accessors"][accessor];
        let view = &json["bufferViews"][number(&accessor["bufferView"])];
        let offset = accessor["byteOffset"].as_u64().unwrap_or(0) as usize;
        let first = number(&view["byteOffset"]) + offset;
        let length = size * number(&accessor["count"]);
        assert!(first.is_multiple_of(4) || size == 1, "aligned");
        assert!(offset + length <= number(&view["byteLength"]));
        binary[first..first + length].to_vec()
    };
    let root = &json["nodes"][number(&json["scenes"][0]["nodes"][0])];
    let moved = root["translation"].as_array().map_or(glam::DVec3::ZERO, |parts| {
        glam::DVec3::from_slice(&parts.iter().map(|part| part.as_f64().unwrap()).collect::<Vec<_>>())
    });
    let span = |child: &Value| {
        let node = &json["nodes"][number(child)];
        let primitive = &json["meshes"][number(&node["mesh"])]["primitives"][0];
        let splatting = &primitive["extensions"]["KHR_gaussian_splatting"];
        assert_eq!((&primitive["mode"], &splatting["kernel"]), (&Value::from(0), &Value::from("ellipse")));
        assert_eq!(splatting["colorSpace"], "srgb_rec709_display");
        let get = |name: &str, parts: usize| {
            let accessor = number(&primitive["attributes"][name]);
            assert_eq!(json["accessors"][accessor]["componentType"], 5126);
            floats(&bytes_of(accessor, 4 * parts))
                .chunks_exact(parts)
                .map(<[f32]>::to_vec)
                .collect::<Vec<_>>()
        };
        let of = |name: &str| {
            get(&format!("KHR_gaussian_splatting:{name}"), if name == "ROTATION" { 4 } else { 3 })
        };
        let opacity = get("KHR_gaussian_splatting:OPACITY", 1);
        let (positions, rotations, scales, colors) =
            (get("POSITION", 3), of("ROTATION"), of("SCALE"), of("SH_DEGREE_0_COEF_0"));
        let splats = (0..positions.len()).map(|nth| ReadSplat {
            center: Vec3::from_slice(&positions[nth]),
            rotation: Quat::from_slice(&rotations[nth]),
            radii: Vec3::from_slice(&scales[nth]),
            color: shown(Vec3::from_slice(&colors[nth])),
            opacity: opacity[nth][0],
        });
        let pointer = format!("/nodes/{child}/extensions/KHR_node_visibility/visible");
        let animation = &json["animations"][0];
        let channel = animation["channels"].as_array().into_iter().flatten().find(|channel| {
            channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"] == pointer.as_str()
        });
        let changes = channel.map_or(Vec::new(), |channel| {
            let sampler = &animation["samplers"][number(&channel["sampler"])];
            assert_eq!(
                (&sampler["interpolation"], &channel["target"]["path"]),
                (&"STEP".into(), &"pointer".into())
            );
            let times = floats(&bytes_of(number(&sampler["input"]), 4));
            times
                .into_iter()
                .zip(bytes_of(number(&sampler["output"]), 1).into_iter().map(|seen| seen == 1))
                .collect()
        });
        ReadSpan { splats: splats.collect(), changes }
    };
    (root["children"].as_array().unwrap().iter().map(span).collect(), moved)
}

/// The spans of a USD file in its text form, times as time codes, and by how much its root moves them.
pub(crate) fn usda(path: &Path) -> (Vec<ReadSpan>, glam::DVec3) {
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.starts_with("#usda 1.0\n") && text.contains("upAxis = \"Y\""));
    let mut prims = text.split("def ParticleField3DGaussianSplat ");
    let head = prims.next().unwrap();
    let numbers = |text: &str| {
        text.split(['(', ')', '[', ']', ',', ' '])
            .filter_map(|part| part.parse::<f64>().ok())
            .collect::<Vec<_>>()
    };
    let moved = head.lines().find_map(|line| line.trim().strip_prefix("double3 xformOp:translate = "));
    let moved = moved.map_or(glam::DVec3::ZERO, |parts| glam::DVec3::from_slice(&numbers(parts)));
    let span = |prim: &str| {
        let value = |name: &str| {
            let start = format!("        {name} = ");
            prim.lines().find_map(|line| line.strip_prefix(&start))
        };
        let get = |name: &str, parts: usize| {
            let values: Vec<f32> =
                numbers(value(name).unwrap()).iter().map(|number| *number as f32).collect();
            values.chunks_exact(parts).map(<[f32]>::to_vec).collect::<Vec<_>>()
        };
        let (positions, rotations) = (get("point3f[] positions", 3), get("quatf[] orientations", 4));
        let (scales, opacities) = (get("float3[] scales", 3), get("float[] opacities", 1));
        let colors = get("float3[] radiance:sphericalHarmonicsCoefficients", 3);
        let splats = (0..positions.len()).map(|nth| ReadSplat {
            center: Vec3::from_slice(&positions[nth]),
            rotation: Quat::from_xyzw(
                rotations[nth][1],
                rotations[nth][2],
                rotations[nth][3],
                rotations[nth][0],
            ),
            radii: Vec3::from_slice(&scales[nth]),
            color: shown(Vec3::from_slice(&colors[nth])),
            opacity: opacities[nth][0],
        });
        let changes = value("token visibility.timeSamples").map_or(Vec::new(), |samples| {
            let samples = samples.trim_matches(['{', '}', ' ']).split(", ");
            let sample = |sample: &str| {
                let (time, value) = sample.split_once(": ").unwrap();
                (time.parse().unwrap(), value == "\"inherited\"")
            };
            samples.map(sample).collect()
        });
        ReadSpan { splats: splats.collect(), changes }
    };
    (prims.map(span).collect(), moved)
}
