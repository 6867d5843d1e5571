// Raises keys with two 32-bit maxima, in two passes over the samples: the upper half first, then the lower half among the
// samples that have the winning upper half. The keys equal those of one 64-bit maximum. Both passes run the same instructions
// up to this function, so that a sample finds the very upper half that it wrote.

@group(1) @binding(0) var<storage, read_write> keys: array<atomic<u32>>;

fn raise(pixel: u32, upper: u32, slot: u32) {
    if stage.step == 0u {
        atomicMax(&keys[2u * pixel + 1u], upper);
    } else if atomicLoad(&keys[2u * pixel + 1u]) == upper {
        atomicMax(&keys[2u * pixel], ~slot);
    }
}
