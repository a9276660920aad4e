// Sums delta form factors by patch and picks out the sums that are not zero, in patch order. Twin of
// the Merger in cpu/rows.rs. Constants and inclusive_sum.wgsl are put in front by
// structs.rs.

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
    words_per_row: u32,
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
// One row after the other: a bit for each patch whose sum is not zero.
@group(0) @binding(5) var<storage, read_write> touched: array<atomic<u32>>;
// One per block, which is a word of bits for each thread of a workgroup: its number of bits that are
// set, then where its entries start.
@group(0) @binding(6) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(7) var<storage, read_write> entries: array<Entry>;
@group(0) @binding(8) var<storage, read_write> summaries: array<RowSummary>;

fn slots_per_row() -> u32 {
    return settings.patch_count + 2u;
}

fn slot_of(texel: vec4u) -> u32 {
    if texel.a == ALPHA_PATCH {
        return (texel.r << 16u) | (texel.g << 8u) | texel.b;
    }
    return settings.patch_count + u32(texel.a == ALPHA_BACK_FACE);
}

fn add_run(row: u32, slot: u32, units: u32) {
    if units == 0u {
        return;
    }
    // The first to come marks the sum.
    if atomicAdd(&sums[row * slots_per_row() + slot], units) == 0u && slot < settings.patch_count {
        atomicOr(&touched[row * settings.words_per_row + slot / 32u], 1u << (slot % 32u));
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn add_pixels(
    @builtin(global_invocation_id) invocation: vec3u,
    @builtin(workgroup_id) workgroup: vec3u,
) {
    let tile = tiles[workgroup.y];
    let first = invocation.x * PIXELS_PER_THREAD;
    let end = min(first + PIXELS_PER_THREAD, settings.resolution * settings.resolution);
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
            add_run(tile.row, slot, sum);
            slot = here;
            sum = 0u;
        }
        sum += delta_form_factors[tile.first_factor + pixel % tile.factor_period];
    }
    add_run(tile.row, slot, sum);
}

// The word of bits that a thread cares for, among those of its row.
fn word_index(block: u32, thread: u32) -> u32 {
    return block * WORKGROUP_SIZE + thread;
}

fn load_word(row: u32, index: u32) -> u32 {
    if index >= settings.words_per_row {
        return 0u;
    }
    return atomicLoad(&touched[row * settings.words_per_row + index]);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn count_entries(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let word = load_word(workgroup.y, word_index(workgroup.x, thread));
    let total = inclusive_sum(thread, countOneBits(word));
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
    let index = word_index(workgroup.x, thread);
    var word = load_word(workgroup.y, index);
    let count = countOneBits(word);
    var place = blocks[workgroup.y * settings.blocks_per_row + workgroup.x]
        + inclusive_sum(thread, count) - count;
    if word != 0u {
        // The next batch starts from zero.
        atomicStore(&touched[workgroup.y * settings.words_per_row + index], 0u);
    }
    while word != 0u {
        let id = index * 32u + countTrailingZeros(word);
        word &= word - 1u;
        entries[place] = Entry(id, atomicExchange(&sums[row + id], 0u));
        place += 1u;
    }
    if workgroup.x == 0u && thread == 0u {
        let nothing = row + settings.patch_count;
        summaries[workgroup.y].open = atomicExchange(&sums[nothing], 0u);
        summaries[workgroup.y].back_face = atomicExchange(&sums[nothing + 1u], 0u);
    }
}
