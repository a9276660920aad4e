// What the shaders that draw item buffers have in common, above all the arithmetic of a pixel: whoever
// rasterises, what a pixel sees follows from this alone. Products and sums are fused by name, so that no
// compiler fuses them in one shader and not in another. Put in front of them by structs.rs.

// A surface as one face of a hemicube sees it: flat, in the face's axes.
struct Projected {
    // e_k(x, y) = edge_k . (x, y, 1): the barycentric coordinates up to a common factor.
    edge_0: vec3f,
    first_patch: u32,
    edge_1: vec3f,
    depth: u32,
    edge_2: vec3f,
    is_back_face: u32,
    // How far below 0 each e_k may be.
    margins: vec3f,
    face: u32,
    // Reversed depth, near / w = inverse_depth . (x, y, 1), with the far plane at infinity.
    inverse_depth: vec3f,
    padding: u32,
    // What is rasterised: x, y and w of the corners, where the face's borders are at x, y = -w and w.
    corner_0: vec3f,
    padding_0: u32,
    corner_1: vec3f,
    padding_1: u32,
    corner_2: vec3f,
    padding_2: u32,
}

struct Face {
    eye_high: vec3f,
    bottom: f32,
    eye_low: vec3f,
    height: f32,
    right: vec3f,
    origin_x: f32,
    up: vec3f,
    origin_y: f32,
    forward: vec3f,
    horizon: u32,
}

struct DrawSettings {
    near: f32,
    plane_tolerance: f32,
    pixel: f32,
    resolution: u32,
    surface_count: u32,
    atlas_width: f32,
    atlas_height: f32,
    padding: u32,
}

fn rows_of(face: Face, settings: DrawSettings) -> u32 {
    return u32(0.5 * face.height * f32(settings.resolution));
}

// Where the ray through a pixel's centre, counted from the face's first, meets the plane at distance 1.
fn ray(centre: vec2f, bottom: f32, pixel: f32) -> vec2f {
    return fma(centre, vec2f(pixel), vec2f(-1.0, bottom));
}

// e . (x, y, 1). Rounding it is monotone in x and in y.
fn at(e: vec3f, xy: vec2f) -> f32 {
    return fma(e.x, xy.x, fma(e.y, xy.y, e.z));
}

// Never below 0, where it fails against nothing at all, beyond the plane's horizon.
fn depth_at(inverse_depth: vec3f, xy: vec2f) -> f32 {
    return saturate(at(inverse_depth, xy));
}

// The walk down of scene::bisection::leaf_code.
fn leaf_code(depth: u32, barycentric: vec3f) -> u32 {
    var a = barycentric.x;
    var b = barycentric.y;
    var c = barycentric.z;
    var code = 0u;
    for (var level = 0u; level < depth; level++) {
        let second = a < b;
        let difference = abs(a - b);
        let newest = 2.0 * min(a, b);
        a = select(difference, c, second);
        b = select(c, difference, second);
        c = newest;
        code = (code << 1u) | u32(second);
    }
    return code;
}

fn texel_of(is_back_face: u32, first_patch: u32, depth: u32, barycentric: vec3f) -> vec4u {
    if is_back_face != 0u {
        return vec4u(0u, 0u, 0u, ALPHA_BACK_FACE);
    }
    let id = first_patch + leaf_code(depth, barycentric);
    return vec4u((id >> 16u) & 255u, (id >> 8u) & 255u, id & 255u, ALPHA_PATCH);
}
