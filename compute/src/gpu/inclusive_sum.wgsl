// A sum over the threads of a workgroup. Put in front of the shaders that ask for it by structs.rs.

var<workgroup> partial_sums: array<u32, WORKGROUP_SIZE>;

// Sum of the values of all threads up to and including this one.
fn inclusive_sum(thread: u32, value: u32) -> u32 {
    partial_sums[thread] = value;
    workgroupBarrier();
    for (var step = 1u; step < WORKGROUP_SIZE; step *= 2u) {
        var before = 0u;
        if thread >= step {
            before = partial_sums[thread - step];
        }
        workgroupBarrier();
        partial_sums[thread] += before;
        workgroupBarrier();
    }
    return partial_sums[thread];
}
