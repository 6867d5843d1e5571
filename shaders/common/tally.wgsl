// Counts over all pixels, with one atomic addition a workgroup.

var<workgroup> tally: array<atomic<u32>, 6>;

fn begin_tally(thread: u32) {
    if thread < 6u {
        atomicStore(&tally[thread], 0u);
    }
    workgroupBarrier();
}

fn count_if(holds: bool, place: u32) {
    if holds {
        atomicAdd(&tally[place], 1u);
    }
}

fn end_tally(thread: u32) {
    workgroupBarrier();
    if thread < 6u {
        let count = atomicLoad(&tally[thread]);
        if count > 0u {
            atomicAdd(&counts[thread], count);
        }
    }
}
