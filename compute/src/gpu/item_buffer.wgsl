// Item buffers of hemicubes: surfaces are drawn, patches are looked up. Twin of cpu/raster.rs, where
// the theory is. Constants are put in front by structs.rs.

struct Surface {
    corner_0: vec3f,
    first_patch: u32,
    corner_1: vec3f,
    depth: u32,
    corner_2: vec3f,
    padding: u32,
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
    padding: f32,
}

struct DrawSettings {
    near: f32,
    plane_tolerance: f32,
    pixel: f32,
    padding: f32,
}

@group(0) @binding(0) var<uniform> settings: DrawSettings;
@group(0) @binding(1) var<storage, read> surfaces: array<Surface>;
@group(0) @binding(2) var<storage, read> faces: array<Face>;
// Surfaces that rise above a hemicube's horizon, one list after the other.
@group(0) @binding(3) var<storage, read> above_horizon: array<u32>;

struct Seen {
    // Surfaces that share corners must share them exactly, or pixels are lost between them.
    @builtin(position) @invariant position: vec4f,
    // e_k(x, y) = edge_k . (x, y, 1): the barycentric coordinates up to a common factor.
    @location(0) @interpolate(flat) edge_0: vec3f,
    @location(1) @interpolate(flat) edge_1: vec3f,
    @location(2) @interpolate(flat) edge_2: vec3f,
    // Where the face starts in the atlas, pixels, and its bottom, dimensionless.
    @location(3) @interpolate(flat) origin: vec3f,
    @location(4) @interpolate(flat) first_patch: u32,
    @location(5) @interpolate(flat) depth: u32,
    @location(6) @interpolate(flat) is_back_face: u32,
}

// The eye is close to the patch's plane and far from the scene's origin: its two parts keep the
// difference as exact as f32 allows.
fn from_eye(corner: vec3f, face: Face) -> vec3f {
    return (corner - face.eye_high) - face.eye_low;
}

fn in_face(vector: vec3f, face: Face) -> vec3f {
    return vec3f(dot(vector, face.right), dot(vector, face.up), dot(vector, face.forward));
}

@vertex
fn project(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Seen {
    let face = faces[instance];
    let surface = surfaces[above_horizon[vertex / 3u]];
    let q_0 = from_eye(surface.corner_0, face);
    let q_1 = from_eye(surface.corner_1, face);
    let q_2 = from_eye(surface.corner_2, face);

    var seen: Seen;
    // All of the plane's geometry is found in the scene's axes, where walls mostly lie along them
    // and little is lost; turned into the face's, every product would be rounded.
    let normal = cross(surface.corner_1 - surface.corner_0, surface.corner_2 - surface.corner_0);
    let determinant = dot(normal, q_0);
    // As cpu::is_in_plane, both sides times the normal's length.
    let far_corner = max(max(abs(surface.corner_0), abs(surface.corner_1)), abs(surface.corner_2));
    let reach = max(far_corner, abs(face.eye_high));
    let tolerance = min(
        settings.plane_tolerance * length(normal),
        COORDINATE_ULPS * dot(abs(normal), reach),
    );
    if abs(determinant) <= tolerance {
        // Edge-on: all three corners in one point outside the picture.
        seen.position = vec4f(2.0, 2.0, 0.0, 1.0);
        return seen;
    }
    let is_back_face = determinant > 0.0;
    seen.is_back_face = u32(is_back_face);
    // q_{k+1} x q_{k+2} = q_{k+1} x (q_{k+2} - q_{k+1}), with less to cancel; positive inside.
    let inside = select(-1.0, 1.0, is_back_face);
    seen.edge_0 = in_face(inside * cross(q_1, surface.corner_2 - surface.corner_1), face);
    seen.edge_1 = in_face(inside * cross(q_2, surface.corner_0 - surface.corner_2), face);
    seen.edge_2 = in_face(inside * cross(q_0, surface.corner_1 - surface.corner_0), face);
    seen.origin = vec3f(face.origin_x, face.origin_y, face.bottom);
    seen.first_patch = surface.first_patch;
    seen.depth = surface.depth;

    let corner = vertex % 3u;
    let q = in_face(select(select(q_2, q_1, corner == 1u), q_0, corner == 0u), face);
    // Rows grow upwards in a face and downwards in the atlas. Both factors are exact.
    let y = q.y * (2.0 / face.height) - q.z * (2.0 * face.bottom / face.height + 1.0);
    // Reversed depth, near / w, with the far plane at infinity. Where a front and a back meet at the
    // silhouette of a closed body, their depths are the same but for rounding: the front is to win.
    let near = settings.near * select(1.0, BACK_FACE_RETREAT, is_back_face);
    seen.position = vec4f(q.x, -y, near, q.z);
    return seen;
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

@fragment
fn look_up(seen: Seen) -> @location(0) vec4u {
    let x = (seen.position.x - seen.origin.x) * settings.pixel - 1.0;
    let y = (seen.position.y - seen.origin.y) * settings.pixel + seen.origin.z;
    let direction = vec3f(x, y, 1.0);
    let barycentric = vec3f(
        dot(seen.edge_0, direction),
        dot(seen.edge_1, direction),
        dot(seen.edge_2, direction),
    );
    var id = seen.first_patch + leaf_code(seen.depth, barycentric);
    var alpha = ALPHA_PATCH;
    if seen.is_back_face != 0u {
        // Rounded corners may let a surface cover a pixel that it passes by. For a back at the silhouette
        // of a closed body, that would show the inside.
        let least = min(barycentric.x, min(barycentric.y, barycentric.z));
        if least < -BACK_FACE_MARGIN * (barycentric.x + barycentric.y + barycentric.z) {
            discard;
        }
        id = NO_PATCH;
        alpha = ALPHA_BACK_FACE;
    }
    return vec4u((id >> 16u) & 255u, (id >> 8u) & 255u, id & 255u, alpha);
}
