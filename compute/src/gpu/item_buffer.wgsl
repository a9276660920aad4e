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
    @builtin(position) position: vec4f,
    // e_k(x, y) = edge_k . (x, y, 1): the barycentric coordinates up to a common factor.
    @location(0) @interpolate(flat) edge_0: vec3f,
    @location(1) @interpolate(flat) edge_1: vec3f,
    @location(2) @interpolate(flat) edge_2: vec3f,
    // How far below 0 each e_k may be.
    @location(3) @interpolate(flat) margins: vec3f,
    // Reversed depth, near / w = inverse_depth . (x, y, 1), with the far plane at infinity.
    @location(4) @interpolate(flat) inverse_depth: vec3f,
    // Where the face starts in the atlas, pixels, and its bottom, dimensionless.
    @location(5) @interpolate(flat) origin: vec3f,
    @location(6) @interpolate(flat) first_patch: u32,
    @location(7) @interpolate(flat) depth: u32,
    @location(8) @interpolate(flat) is_back_face: u32,
}

struct Pixel {
    @location(0) id: vec4u,
    @builtin(frag_depth) depth: f32,
}

// The eye is close to the patch's plane and far from the scene's origin: its two parts keep the
// difference as exact as f32 allows.
fn from_eye(corner: vec3f, face: Face) -> vec3f {
    return (corner - face.eye_high) - face.eye_low;
}

fn in_face(vector: vec3f, face: Face) -> vec3f {
    return vec3f(dot(vector, face.right), dot(vector, face.up), dot(vector, face.forward));
}

// How far a corner may be off across an edge's plane, relative to the outset: the magnitudes of its
// coordinates and of the eye's, along the plane's unit normal, metres.
fn off_across(corner: vec3f, normal: vec3f, face: Face) -> f32 {
    return dot(max(abs(corner), abs(face.eye_high)), abs(normal));
}

// How far below 0 an e_k may be for a corner's rounding: off by d across the edge's plane, it moves the plane
// q_i x q_j by d times the other corner's length at most, and no ray through a picture is longer than
// sqrt(3). Besides, products round the plane itself.
fn margin(edge: vec3f, q_i: vec3f, q_j: vec3f, corner_i: vec3f, corner_j: vec3f, face: Face) -> f32 {
    let squared = dot(edge, edge);
    if squared == 0.0 {
        return 0.0;
    }
    let normal = edge * inverseSqrt(squared);
    let off_i = off_across(corner_i, normal, face);
    let off_j = off_across(corner_j, normal, face);
    let product = min(length(q_i), length(q_j)) * length(corner_j - corner_i);
    return sqrt(3.0) * (FRONT_FACE_OUTSET * (off_i * length(q_j) + off_j * length(q_i))
        + PRODUCT_ULPS * product);
}

// The normal of the plane through the eye and an edge, q_i x q_j, from the nearer corner, with less to
// cancel. From the other side of the edge it is the same to the bit, but for its sign.
fn edge(q_i: vec3f, q_j: vec3f, along: vec3f) -> vec3f {
    let length_i = dot(q_i, q_i);
    let length_j = dot(q_j, q_j);
    let q = select(select(q_j, q_i, length_i < length_j), 0.5 * (q_i + q_j), length_i == length_j);
    return cross(q, along);
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
    let inside = select(-1.0, 1.0, is_back_face);
    let edge_0 = inside * edge(q_1, q_2, surface.corner_2 - surface.corner_1);
    let edge_1 = inside * edge(q_2, q_0, surface.corner_0 - surface.corner_2);
    let edge_2 = inside * edge(q_0, q_1, surface.corner_1 - surface.corner_0);
    seen.edge_0 = in_face(edge_0, face);
    seen.edge_1 = in_face(edge_1, face);
    seen.edge_2 = in_face(edge_2, face);
    seen.origin = vec3f(face.origin_x, face.origin_y, face.bottom);
    seen.first_patch = surface.first_patch;
    seen.depth = surface.depth;

    // Where a front and a back meet at the silhouette of a closed body, their depths are the same but
    // for rounding: the front is to win.
    let near = settings.near * select(1.0, BACK_FACE_RETREAT, is_back_face);
    seen.inverse_depth = in_face(normal, face) / determinant * near;

    // By how much each e_k changes from one pixel to the next.
    let edge_per_pixel = settings.pixel * vec3f(
        dot(abs(seen.edge_0.xy), vec2f(1.0)),
        dot(abs(seen.edge_1.xy), vec2f(1.0)),
        dot(abs(seen.edge_2.xy), vec2f(1.0)),
    );
    let margins = vec3f(
        margin(edge_0, q_1, q_2, surface.corner_1, surface.corner_2, face),
        margin(edge_1, q_2, q_0, surface.corner_2, surface.corner_0, face),
        margin(edge_2, q_0, q_1, surface.corner_0, surface.corner_1, face),
    );
    seen.margins = select(min(margins, MOST_MARGIN * edge_per_pixel), vec3f(0.0), is_back_face);

    // What is rasterised has its edges farther outwards: wherever its corners are then rounded to, it
    // has all pixels that are seen. By u_k, as barycentric coordinates of a point at w = 1.
    let u = (seen.margins + RASTERISED_OUTSET * edge_per_pixel) / abs(determinant);
    let corners = array(in_face(q_0, face), in_face(q_1, face), in_face(q_2, face));
    let k = vertex % 3u;
    // The moved edges' determinant over the edges' own.
    let growth = 1.0 + dot(u, vec3f(corners[0].z, corners[1].z, corners[2].z));
    if growth < MIN_GROWTH {
        // The whole picture. Behind the eye, outwards is inwards: there, a triangle that is all but
        // edge-on may be turned inside out.
        seen.position = vec4f(select(-1.0, 3.0, k == 1u), select(-1.0, 3.0, k == 2u), 0.0, 1.0);
        return seen;
    }
    // Where the moved edges i and j meet: q - w / s (u_i (q_i - q) + u_j (q_j - q)), times s.
    let i = (k + 1u) % 3u;
    let j = (k + 2u) % 3u;
    let q = corners[k];
    let inwards = u[i] * (corners[i] - q) + u[j] * (corners[j] - q);
    let meeting = (1.0 + inwards.z) * q.xy - q.z * inwards.xy;
    // Rows grow upwards in a face and downwards in the atlas. Both factors are exact.
    let y = meeting.y * (2.0 / face.height) - q.z * (2.0 * face.bottom / face.height + 1.0);
    // Reversed depth, though pixels have their own: what is nearer than the near plane is cut off.
    seen.position = vec4f(meeting.x, -y, settings.near, q.z);
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
fn look_up(seen: Seen) -> Pixel {
    let x = (seen.position.x - seen.origin.x) * settings.pixel - 1.0;
    let y = (seen.position.y - seen.origin.y) * settings.pixel + seen.origin.z;
    let direction = vec3f(x, y, 1.0);
    let barycentric = vec3f(
        dot(seen.edge_0, direction),
        dot(seen.edge_1, direction),
        dot(seen.edge_2, direction),
    );
    if any(barycentric < -seen.margins) {
        discard;
    }
    var pixel: Pixel;
    // 0, where it fails against nothing at all, beyond the plane's horizon.
    pixel.depth = saturate(dot(seen.inverse_depth, direction));
    if seen.is_back_face != 0u {
        pixel.id = vec4u(0u, 0u, 0u, ALPHA_BACK_FACE);
    } else {
        let id = seen.first_patch + leaf_code(seen.depth, barycentric);
        pixel.id = vec4u((id >> 16u) & 255u, (id >> 8u) & 255u, id & 255u, ALPHA_PATCH);
    }
    return pixel;
}
