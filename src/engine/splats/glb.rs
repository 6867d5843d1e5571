//! Splats as binary glTF: a node for each span of frames, shown by an animation of its visibility.
//!
//! Source: Khronos, glTF 2.0 with `KHR_gaussian_splatting`, `KHR_node_visibility` and `KHR_animation_pointer`, all ratified. `COLOR_0`
//! is for programs that show points: it is linear, as glTF means it, while the coefficients are of sRGB-encoded values.

use std::io::Write;

use glam::Vec3;
use serde_json::{Value, json};

use super::field::{Field, SpanSplats};
use super::gaussian::{Gaussian, coefficients};
use super::timing::Timing;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::Span;

const MAGIC: u32 = 0x4654_6c67;
const VERSION: u32 = 2;
const JSON_CHUNK: u32 = 0x4e4f_534a;
const BINARY_CHUNK: u32 = 0x004e_4942;

/// Component types.
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const FLOAT: u32 = 5126;

/// What a buffer view of vertices is for.
const ARRAY_BUFFER: u32 = 34962;

/// An attribute of splats.
struct Attribute {
    name: &'static str,
    kind: &'static str,
    component: u32,
    /// Bytes of a splat.
    bytes: u64,
    /// Appends those of a splat.
    push: fn(&mut Vec<u8>, &Gaussian),
}

fn push_floats(bytes: &mut Vec<u8>, floats: &[f32]) {
    bytes.extend(floats.iter().flat_map(|float| float.to_le_bytes()));
}

fn push_color(bytes: &mut Vec<u8>, splat: &Gaussian) {
    let [red, green, blue] = splat.color;
    let shorts = [red, green, blue, splat.opacity].map(|part| (part * 65_535.0 + 0.5) as u16);
    bytes.extend(shorts.iter().flat_map(|short| short.to_le_bytes()));
}

const ATTRIBUTES: [Attribute; 6] = [
    Attribute {
        name: "POSITION",
        kind: "VEC3",
        component: FLOAT,
        bytes: 12,
        push: |bytes, splat| push_floats(bytes, &splat.center.to_array()),
    },
    Attribute {
        name: "KHR_gaussian_splatting:ROTATION",
        kind: "VEC4",
        component: FLOAT,
        bytes: 16,
        push: |bytes, splat| push_floats(bytes, &splat.rotation.to_array()),
    },
    Attribute {
        name: "KHR_gaussian_splatting:SCALE",
        kind: "VEC3",
        component: FLOAT,
        bytes: 12,
        push: |bytes, splat| push_floats(bytes, &splat.radii.to_array()),
    },
    Attribute {
        name: "KHR_gaussian_splatting:OPACITY",
        kind: "SCALAR",
        component: FLOAT,
        bytes: 4,
        push: |bytes, splat| push_floats(bytes, &[splat.opacity]),
    },
    Attribute {
        name: "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0",
        kind: "VEC3",
        component: FLOAT,
        bytes: 12,
        push: |bytes, splat| push_floats(bytes, &coefficients(splat.color)),
    },
    Attribute { name: "COLOR_0", kind: "VEC4", component: UNSIGNED_SHORT, bytes: 8, push: push_color },
];

/// Writes the splats of a field. `name` is that of the capture.
///
/// # Errors
/// `Invalid` for more than the 4 GiB that a file can have, `Io` naming `place`, `Cancelled`.
pub(super) fn write(
    target: &mut impl Write,
    field: &Field<'_>,
    name: &str,
    timing: Timing,
    place: &std::path::Path,
    job: &Job,
) -> Result<()> {
    let io = |error| Error::io(place, error);
    let layout = Layout::new(field, name, timing, job)?;
    let mut text =
        serde_json::to_vec(&layout.document).map_err(|error| Error::invalid(name, error.to_string()))?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let all = 12 + 8 + text.len() as u64 + 8 + layout.binary_bytes;
    let (Ok(all_bytes), Ok(binary_bytes)) = (u32::try_from(all), u32::try_from(layout.binary_bytes)) else {
        let what = "is not written: it is more than the 4 GiB that a glTF file can have; lower it by --at-most-splats, or choose --format usda";
        return Err(Error::invalid(name, what));
    };
    let mut words =
        |words: &[u32]| words.iter().try_for_each(|word| target.write_all(&word.to_le_bytes())).map_err(io);
    words(&[MAGIC, VERSION, all_bytes, text.len() as u32, JSON_CHUNK])?;
    target.write_all(&text).map_err(io)?;
    target.write_all(&[binary_bytes, BINARY_CHUNK].map(u32::to_le_bytes).concat()).map_err(io)?;
    let mut bytes = Vec::new();
    for span in &field.spans {
        let splats = field.splats(span, job)?;
        for attribute in &ATTRIBUTES {
            bytes.clear();
            for splat in &splats {
                (attribute.push)(&mut bytes, splat);
            }
            target.write_all(&bytes).map_err(io)?;
        }
    }
    target.write_all(&layout.animation).map_err(io)
}

/// The JSON of a file, and its binary part.
struct Layout {
    document: Value,
    binary_bytes: u64,
    /// What follows the splats: times as floats, then visibilities as bytes.
    animation: Vec<u8>,
}

/// Lists of a document, while it is made.
#[derive(Default)]
struct Lists {
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    accessors: Vec<Value>,
    views: Vec<Value>,
    samplers: Vec<Value>,
    channels: Vec<Value>,
    /// Bytes of the binary part so far.
    bytes: u64,
    times: Vec<u8>,
    visibilities: Vec<u8>,
}

impl Layout {
    fn new(field: &Field<'_>, name: &str, timing: Timing, job: &Job) -> Result<Self> {
        let mut lists = Lists::default();
        let children: Vec<usize> = (1..=field.spans.len()).collect();
        let mut root = json!({ "name": name, "children": children });
        if let Some(offset) = field.space.offset() {
            root["translation"] = json!(offset.to_array());
        }
        lists.nodes.push(root);
        for span in &field.spans {
            lists.add_span(span, field.bounds(span, job)?, timing);
        }
        lists.finish_animation();
        let mut animation = std::mem::take(&mut lists.times);
        animation.append(&mut lists.visibilities);
        animation.resize(animation.len().next_multiple_of(4), 0);
        let binary_bytes = lists.bytes + animation.len() as u64;
        Ok(Self { document: lists.document(binary_bytes), binary_bytes, animation })
    }
}

impl Lists {
    /// A node with its mesh, and when it is seen.
    fn add_span(&mut self, span: &SpanSplats, [low, high]: [Vec3; 2], timing: Timing) {
        let (start, end) = (span.span.start, span.span.end);
        let mut attributes = serde_json::Map::new();
        for attribute in &ATTRIBUTES {
            let bytes = attribute.bytes * span.count;
            let view =
                json!({ "buffer": 0, "byteOffset": self.bytes, "byteLength": bytes, "target": ARRAY_BUFFER });
            let mut accessor = json!({
                "bufferView": self.views.len(), "componentType": attribute.component, "count": span.count,
                "type": attribute.kind,
            });
            match attribute.name {
                "POSITION" => {
                    accessor["min"] = json!(low.to_array());
                    accessor["max"] = json!(high.to_array());
                }
                "COLOR_0" => accessor["normalized"] = json!(true),
                _ => {}
            }
            attributes.insert(attribute.name.to_owned(), json!(self.accessors.len()));
            self.accessors.push(accessor);
            self.views.push(view);
            self.bytes += bytes;
        }
        let splatting = json!({ "kernel": "ellipse", "colorSpace": "srgb_rec709_display" });
        self.meshes.push(json!({ "primitives": [{
            "attributes": attributes, "mode": 0, "extensions": { "KHR_gaussian_splatting": splatting },
        }] }));
        let mut node =
            json!({ "name": format!("frames {start} to {}", end - 1), "mesh": self.meshes.len() - 1 });
        if !timing.is_always(span.span) {
            node["extensions"] = json!({ "KHR_node_visibility": { "visible": start == 0 } });
            self.animate(self.nodes.len(), timing, span.span);
        }
        self.nodes.push(node);
    }

    /// Shows and hides a node. Views and offsets of the accessors are those after all splats: see [`Self::finish_animation`].
    fn animate(&mut self, node: usize, timing: Timing, span: Span) {
        let changes = timing.changes(span);
        let input = self.accessors.len();
        let ends = [changes.first(), changes.last()].map(|end| timing.seconds(end.map_or(0, |end| end.0)));
        self.accessors.push(json!({
            "byteOffset": self.times.len(), "componentType": FLOAT, "count": changes.len(), "type": "SCALAR",
            "min": [ends[0]], "max": [ends[1]],
        }));
        self.accessors.push(json!({
            "byteOffset": self.visibilities.len(), "componentType": UNSIGNED_BYTE, "count": changes.len(),
            "type": "SCALAR",
        }));
        for (frame, is_visible) in changes {
            self.times.extend(timing.seconds(frame).to_le_bytes());
            self.visibilities.push(u8::from(is_visible));
        }
        let pointer = format!("/nodes/{node}/extensions/KHR_node_visibility/visible");
        self.channels.push(json!({ "sampler": self.samplers.len(), "target": {
            "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } },
        } }));
        self.samplers.push(json!({ "input": input, "output": input + 1, "interpolation": "STEP" }));
    }

    /// The views of times and visibilities, behind all splats.
    fn finish_animation(&mut self) {
        if self.samplers.is_empty() {
            return;
        }
        let times = self.views.len();
        for accessor in self.accessors.iter_mut().filter(|accessor| accessor.get("bufferView").is_none()) {
            let is_time = accessor["componentType"] == FLOAT;
            accessor["bufferView"] = json!(if is_time { times } else { times + 1 });
        }
        let middle = self.bytes + self.times.len() as u64;
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes, "byteLength": self.times.len() }));
        self.views.push(json!({ "buffer": 0, "byteOffset": middle, "byteLength": self.visibilities.len() }));
    }

    fn document(self, binary_bytes: u64) -> Value {
        let mut used = vec!["KHR_gaussian_splatting"];
        let is_animated = !self.samplers.is_empty();
        if is_animated {
            used.extend(["KHR_node_visibility", "KHR_animation_pointer"]);
        }
        let mut document = json!({
            "asset": { "version": "2.0", "generator": concat!("overlook ", env!("CARGO_PKG_VERSION")) },
            "extensionsUsed": used,
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{ "byteLength": binary_bytes }],
        });
        if is_animated {
            document["animations"] =
                json!([{ "name": "frames", "channels": self.channels, "samplers": self.samplers }]);
        }
        document
    }
}
