// Sums delta form factors by patch and picks out the sums that are not zero, in patch order. Twin of
// the Merger in cpu/rows.rs. Constants are put in front by structs.rs.

struct Tile {
    origin_x: u32,
    origin_y: u32,
    row: u32,
    first_factor: u32,
    factor_period: u32,
}

struct MergeSettings {
    resolution: u32,
    patch_count: u32,
    blocks_per_row: u32,
    row_count: u32,
}

struct RowSummary {
    end: u32,
    open: u32,
    back_face: u32,
}

struct Entry {
    patch_id: u32,
    units: u32,
}

@group(0) @binding(0) var<uniform> settings: MergeSettings;
@group(0) @binding(1) var atlas: texture_2d<u32>;
@group(0) @binding(2) var<storage, read> tiles: array<Tile>;
@group(0) @binding(3) var<storage, read> delta_form_factors: array<u32>;
// One row after the other: a sum for each patch, one for nothing, one for back faces.
@group(0) @binding(4) var<storage, read_write> sums: array<atomic<u32>>;
// One per block of sums: its number of non-zero ones, then where its entries start.
@group(0) @binding(5) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(6) var<storage, read_write> entries: array<Entry>;
@group(0) @binding(7) var<storage, read_write> summaries: array<RowSummary>;

fn slots_per_row() -> u32 {
    return settings.patch_count + 2u;
}

fn slot_of(texel: vec4u) -> u32 {
    if texel.a == ALPHA_PATCH {
        return (texel.r << 16u) | (texel.g << 8u) | texel.b;
    }
    return settings.patch_count + u32(texel.a == ALPHA_BACK_FACE);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn add_pixels(
    @builtin(global_invocation_id) invocation: vec3u,
    @builtin(workgroup_id) workgroup: vec3u,
) {
    let tile = tiles[workgroup.y];
    let first = invocation.x * PIXELS_PER_THREAD;
    let end = min(first + PIXELS_PER_THREAD, settings.resolution * settings.resolution);
    let row = tile.row * slots_per_row();
    // Neighbours mostly see the same patch: one addition for all of a run.
    var slot = 0u;
    var sum = 0u;
    for (var pixel = first; pixel < end; pixel++) {
        let position = vec2u(
            tile.origin_x + pixel % settings.resolution,
            tile.origin_y + pixel / settings.resolution,
        );
        let here = slot_of(textureLoad(atlas, position, 0));
        if here != slot {
            if sum != 0u {
                atomicAdd(&sums[row + slot], sum);
            }
            slot = here;
            sum = 0u;
        }
        sum += delta_form_factors[tile.first_factor + pixel % tile.factor_period];
    }
    if sum != 0u {
        atomicAdd(&sums[row + slot], sum);
    }
}

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

// First and end of the patches whose sums one thread searches.
fn patches_of(block: u32, thread: u32) -> vec2u {
    let first = (block * WORKGROUP_SIZE + thread) * SLOTS_PER_THREAD;
    return vec2u(first, min(first + SLOTS_PER_THREAD, settings.patch_count));
}

fn count_in(row: u32, patches: vec2u) -> u32 {
    var count = 0u;
    for (var id = patches.x; id < patches.y; id++) {
        count += u32(atomicLoad(&sums[row + id]) != 0u);
    }
    return count;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn count_entries(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let row = workgroup.y * slots_per_row();
    let count = count_in(row, patches_of(workgroup.x, thread));
    let total = inclusive_sum(thread, count);
    if thread == WORKGROUP_SIZE - 1u {
        blocks[workgroup.y * settings.blocks_per_row + workgroup.x] = total;
    }
}

// One workgroup for the whole batch.
@compute @workgroup_size(WORKGROUP_SIZE)
fn place_entries(@builtin(local_invocation_index) thread: u32) {
    let block_count = settings.blocks_per_row * settings.row_count;
    let per_thread = (block_count + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    let start = min(thread * per_thread, block_count);
    let end = min(start + per_thread, block_count);
    var count = 0u;
    for (var block = start; block < end; block++) {
        count += blocks[block];
    }
    var place = inclusive_sum(thread, count) - count;
    for (var block = start; block < end; block++) {
        let here = blocks[block];
        blocks[block] = place;
        place += here;
        if block % settings.blocks_per_row == settings.blocks_per_row - 1u {
            summaries[block / settings.blocks_per_row].end = place;
        }
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn write_entries(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let row = workgroup.y * slots_per_row();
    let patches = patches_of(workgroup.x, thread);
    let count = count_in(row, patches);
    var place = blocks[workgroup.y * settings.blocks_per_row + workgroup.x]
        + inclusive_sum(thread, count) - count;
    for (var id = patches.x; id < patches.y; id++) {
        let units = atomicLoad(&sums[row + id]);
        if units != 0u {
            entries[place] = Entry(id, units);
            place += 1u;
            // The next batch starts from zero.
            atomicStore(&sums[row + id], 0u);
        }
    }
    if workgroup.x == 0u && thread == 0u {
        let nothing = row + settings.patch_count;
        summaries[workgroup.y].open = atomicExchange(&sums[nothing], 0u);
        summaries[workgroup.y].back_face = atomicExchange(&sums[nothing + 1u], 0u);
    }
}
