// Raises keys with one 64-bit maximum. Twin: `KeyUpdates` in src/engine/render/splat/surface.rs.

@group(1) @binding(0) var<storage, read_write> keys: array<atomic<u64>>;

fn raise(pixel: u32, upper: u32, slot: u32) {
    atomicMax(&keys[pixel], (u64(upper) << 32u) | u64(~slot));
}
