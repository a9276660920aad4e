// What the faces of hemicubes see of a scene's surfaces: those above the horizon that come into a face, and
// all that is the same for their pixels. Twin of cpu/projection.rs, where the theory is. Constants,
// inclusive_sum.wgsl and item_buffer.wgsl are put in front by structs.rs.

struct Surface {
    corner_0: vec3f,
    first_patch: u32,
    corner_1: vec3f,
    depth: u32,
    corner_2: vec3f,
    padding: u32,
}

// Where a face's surfaces are among those of all faces.
struct Span {
    start: u32,
    end: u32,
}

struct DrawArguments {
    vertex_count: atomic<u32>,
    instance_count: u32,
    first_vertex: u32,
    first_instance: u32,
}

@group(0) @binding(0) var<uniform> settings: DrawSettings;
@group(0) @binding(1) var<storage, read> surfaces: array<Surface>;
@group(0) @binding(2) var<storage, read> faces: array<Face>;
// A bit for each surface that rises above a hemicube's horizon, one horizon after the other.
@group(0) @binding(3) var<storage, read> horizons: array<u32>;
@group(0) @binding(4) var<storage, read_write> projected: array<Projected>;
@group(0) @binding(5) var<storage, read_write> spans: array<Span>;
@group(0) @binding(6) var<storage, read_write> draw_arguments: DrawArguments;

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

// As cpu::is_in_plane, both sides times the normal's length: whether the eye sees a surface edge-on.
fn is_edge_on(surface: Surface, normal: vec3f, determinant: f32, reach: vec3f) -> bool {
    let tolerance = min(
        settings.plane_tolerance * length(normal),
        COORDINATE_ULPS * dot(abs(normal), reach),
    );
    return abs(determinant) <= tolerance;
}

fn reach_of(surface: Surface, face: Face) -> vec3f {
    let far_corner = max(max(abs(surface.corner_0), abs(surface.corner_1)), abs(surface.corner_2));
    return max(far_corner, abs(face.eye_high));
}

fn normal_of(surface: Surface) -> vec3f {
    return cross(surface.corner_1 - surface.corner_0, surface.corner_2 - surface.corner_0);
}

// Whether a surface may be seen in a face: above the horizon as the host knows it, not edge-on, and not all
// beyond one of the face's borders. Those are half a pixel from any pixel's centre; what the corners may be
// off by is left to the surfaces that nearly touch them.
fn is_seen(index: u32, face: Face) -> bool {
    if (horizons[face.horizon + index / 32u] & (1u << (index % 32u))) == 0u {
        return false;
    }
    let surface = surfaces[index];
    let reach = reach_of(surface, face);
    let corners = array(
        in_face(from_eye(surface.corner_0, face), face),
        in_face(from_eye(surface.corner_1, face), face),
        in_face(from_eye(surface.corner_2, face), face),
    );
    let x = vec3f(corners[0].x, corners[1].x, corners[2].x);
    let y = vec3f(corners[0].y, corners[1].y, corners[2].y);
    let z = vec3f(corners[0].z, corners[1].z, corners[2].z);
    let slack = vec3f(CULLED_OUTSET * (reach.x + reach.y + reach.z));
    let is_outside = all(z < -slack)
        || all(x > z + slack)
        || all(-x > z + slack)
        || all(y < face.bottom * z - slack)
        || all(y > (face.bottom + face.height) * z + slack);
    if is_outside {
        return false;
    }
    let normal = normal_of(surface);
    return !is_edge_on(surface, normal, dot(normal, from_eye(surface.corner_0, face)), reach);
}

// Where the moved edges i and j meet: q - w / s (u_i (q_i - q) + u_j (q_j - q)), times s; x, y, w, the face's
// borders being at x, y = -w and w.
fn moved_corner(q: vec3f, q_i: vec3f, q_j: vec3f, u_i: f32, u_j: f32, face: Face) -> vec3f {
    let inwards = u_i * (q_i - q) + u_j * (q_j - q);
    let meeting = (1.0 + inwards.z) * q.xy - q.z * inwards.xy;
    // Both factors are exact.
    let y = meeting.y * (2.0 / face.height) - q.z * (2.0 * face.bottom / face.height + 1.0);
    return vec3f(meeting.x, y, q.z);
}

fn project(surface: Surface, face_index: u32) -> Projected {
    let face = faces[face_index];
    let q_0 = from_eye(surface.corner_0, face);
    let q_1 = from_eye(surface.corner_1, face);
    let q_2 = from_eye(surface.corner_2, face);

    var seen: Projected;
    seen.face = face_index;
    seen.first_patch = surface.first_patch;
    seen.depth = surface.depth;
    // All of the plane's geometry is found in the scene's axes, where walls mostly lie along them
    // and little is lost; turned into the face's, every product would be rounded.
    let normal = normal_of(surface);
    let determinant = dot(normal, q_0);
    let is_back_face = determinant > 0.0;
    seen.is_back_face = u32(is_back_face);
    let inside = select(-1.0, 1.0, is_back_face);
    let edge_0 = inside * edge(q_1, q_2, surface.corner_2 - surface.corner_1);
    let edge_1 = inside * edge(q_2, q_0, surface.corner_0 - surface.corner_2);
    let edge_2 = inside * edge(q_0, q_1, surface.corner_1 - surface.corner_0);
    seen.edge_0 = in_face(edge_0, face);
    seen.edge_1 = in_face(edge_1, face);
    seen.edge_2 = in_face(edge_2, face);

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
    // The moved edges' determinant over the edges' own.
    let growth = 1.0 + dot(u, vec3f(corners[0].z, corners[1].z, corners[2].z));
    if growth < MIN_GROWTH {
        // The whole picture. Behind the eye, outwards is inwards: there, a triangle that is all but
        // edge-on may be turned inside out.
        seen.corner_0 = vec3f(-1.0, -1.0, 1.0);
        seen.corner_1 = vec3f(3.0, -1.0, 1.0);
        seen.corner_2 = vec3f(-1.0, 3.0, 1.0);
        return seen;
    }
    seen.corner_0 = moved_corner(corners[0], corners[1], corners[2], u.y, u.z, face);
    seen.corner_1 = moved_corner(corners[1], corners[2], corners[0], u.z, u.x, face);
    seen.corner_2 = moved_corner(corners[2], corners[0], corners[1], u.x, u.y, face);
    return seen;
}

// No pixel is above its margins.
fn never_seen() -> Projected {
    var nothing: Projected;
    nothing.margins = vec3f(-1.0);
    return nothing;
}

var<workgroup> start_of_face: u32;

// A workgroup for each face. Its surfaces keep their order, in which the first of those that are equally near
// wins; where the faces' own lists come, among those of all faces, makes no difference.
@compute @workgroup_size(WORKGROUP_SIZE)
fn project_surfaces(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let face = faces[workgroup.x];
    let per_thread = (settings.surface_count + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    let start = min(thread * per_thread, settings.surface_count);
    let end = min(start + per_thread, settings.surface_count);
    var count = 0u;
    for (var index = start; index < end; index++) {
        count += u32(is_seen(index, face));
    }
    let sum = inclusive_sum(thread, count);
    if thread == WORKGROUP_SIZE - 1u {
        let first = atomicAdd(&draw_arguments.vertex_count, 3u * sum) / 3u;
        spans[workgroup.x] = Span(first, first + sum);
        start_of_face = first;
    }
    workgroupBarrier();
    let place_end = start_of_face + sum;
    var place = place_end - count;
    for (var index = start; index < end; index++) {
        if place < place_end && is_seen(index, face) {
            projected[place] = project(surfaces[index], workgroup.x);
            place += 1u;
        }
    }
    // Only if a compiler made the two loops round differently, and a surface is as good as edge-on.
    for (; place < place_end; place++) {
        projected[place] = never_seen();
    }
}
