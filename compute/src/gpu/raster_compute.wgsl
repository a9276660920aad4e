// Item buffers by a compute shader, for chips whose raster units are few. Same pixels as
// raster_pipeline.wgsl. A workgroup draws a block of a face's pixels, a thread each: it sorts out which
// surfaces come near the block, then every pixel tries those in their order. Constants and
// item_buffer.wgsl are put in front by structs.rs.

struct Span {
    start: u32,
    end: u32,
}

@group(0) @binding(0) var<uniform> settings: DrawSettings;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
@group(0) @binding(2) var<storage, read> projected: array<Projected>;
@group(0) @binding(3) var<storage, read> spans: array<Span>;
@group(0) @binding(4) var atlas: texture_storage_2d<rgba8uint, write>;

const WORDS: u32 = WORKGROUP_SIZE / 32u;

// A bit for each surface in turn that comes near the block.
var<workgroup> near_block: array<atomic<u32>, WORDS>;

// Whether e may be -margin or more at a pixel between two corners of a block: it is largest at a corner,
// rounded too.
fn reaches(e: vec3f, margin: f32, low: vec2f, high: vec2f) -> bool {
    return !(at(e, select(low, high, e.xy > vec2f(0.0))) < -margin);
}

fn comes_near(index: u32, low: vec2f, high: vec2f) -> bool {
    let margins = projected[index].margins;
    return reaches(projected[index].edge_0, margins.x, low, high)
        && reaches(projected[index].edge_1, margins.y, low, high)
        && reaches(projected[index].edge_2, margins.z, low, high);
}

fn barycentric_at(index: u32, xy: vec2f) -> vec3f {
    return vec3f(
        at(projected[index].edge_0, xy),
        at(projected[index].edge_1, xy),
        at(projected[index].edge_2, xy),
    );
}

@compute @workgroup_size(BLOCK_SIDE, BLOCK_SIDE)
fn draw_block(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let face = faces[workgroup.z];
    let rows = rows_of(face, settings);
    let first = BLOCK_SIDE * workgroup.xy;
    if first.y >= rows {
        return;
    }
    let pixel = first + local.xy;
    let last = first + BLOCK_SIDE - 1u;
    let xy = ray(vec2f(pixel) + 0.5, face.bottom, settings.pixel);
    let low = ray(vec2f(first) + 0.5, face.bottom, settings.pixel);
    let high = ray(vec2f(last) + 0.5, face.bottom, settings.pixel);

    var depth = 0.0;
    var nearest = 0u;
    let span = spans[workgroup.z];
    for (var start = span.start; start < span.end; start += WORKGROUP_SIZE) {
        if thread < WORDS {
            atomicStore(&near_block[thread], 0u);
        }
        workgroupBarrier();
        let candidate = start + thread;
        if candidate < span.end && comes_near(candidate, low, high) {
            atomicOr(&near_block[thread / 32u], 1u << (thread % 32u));
        }
        workgroupBarrier();
        for (var word = 0u; word < WORDS; word++) {
            var bits = atomicLoad(&near_block[word]);
            while bits != 0u {
                let index = start + 32u * word + countTrailingZeros(bits);
                bits &= bits - 1u;
                if any(barycentric_at(index, xy) < -projected[index].margins) {
                    continue;
                }
                let here = depth_at(projected[index].inverse_depth, xy);
                if here > depth {
                    depth = here;
                    nearest = index;
                }
            }
        }
        workgroupBarrier();
    }
    if pixel.x >= settings.resolution || pixel.y >= rows {
        return;
    }
    var texel = vec4u(0u, 0u, 0u, ALPHA_NOTHING);
    if depth > 0.0 {
        texel = texel_of(
            projected[nearest].is_back_face,
            projected[nearest].first_patch,
            projected[nearest].depth,
            barycentric_at(nearest, xy),
        );
    }
    textureStore(atlas, vec2u(vec2f(face.origin_x, face.origin_y)) + pixel, texel);
}
