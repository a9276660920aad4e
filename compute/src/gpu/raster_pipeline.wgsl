// Item buffers by the fixed pipeline: all surfaces that all faces see, in one draw. Same pixels as
// raster_compute.wgsl. Constants, item_buffer.wgsl and `enable clip_distances` are put in front by structs.rs.

@group(0) @binding(0) var<uniform> settings: DrawSettings;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
@group(0) @binding(2) var<storage, read> projected: array<Projected>;

struct Corner {
    @builtin(position) position: vec4f,
    // A face has no viewport of its own: it is cut out by its borders.
    @builtin(clip_distances) borders: array<f32, 4>,
    @location(0) @interpolate(flat) edge_0: vec3f,
    @location(1) @interpolate(flat) edge_1: vec3f,
    @location(2) @interpolate(flat) edge_2: vec3f,
    @location(3) @interpolate(flat) margins: vec3f,
    @location(4) @interpolate(flat) inverse_depth: vec3f,
    // Where the face starts in the atlas, pixels, and its bottom and height, dimensionless.
    @location(5) @interpolate(flat) place: vec4f,
    @location(6) @interpolate(flat) tree: vec3u,
}

struct Seen {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) edge_0: vec3f,
    @location(1) @interpolate(flat) edge_1: vec3f,
    @location(2) @interpolate(flat) edge_2: vec3f,
    @location(3) @interpolate(flat) margins: vec3f,
    @location(4) @interpolate(flat) inverse_depth: vec3f,
    @location(5) @interpolate(flat) place: vec4f,
    @location(6) @interpolate(flat) tree: vec3u,
}

struct Pixel {
    @location(0) id: vec4u,
    @builtin(frag_depth) depth: f32,
}

@vertex
fn place_corner(@builtin(vertex_index) vertex: u32) -> Corner {
    let surface = projected[vertex / 3u];
    let face = faces[surface.face];
    let k = vertex % 3u;
    let at_corner = select(
        select(surface.corner_0, surface.corner_1, k == 1u),
        surface.corner_2,
        k == 2u,
    );
    let w = at_corner.z;
    // From the face to the atlas. Rows grow upwards in a face and downwards in both pictures' pixels.
    let size = vec2f(f32(settings.resolution), f32(rows_of(face, settings)));
    let atlas = vec2f(settings.atlas_width, settings.atlas_height);
    let centre = vec2f(face.origin_x, face.origin_y) + 0.5 * size;
    let in_atlas = at_corner.xy * (size / atlas) + w * (2.0 * centre / atlas - 1.0);

    var corner: Corner;
    // Reversed depth, though pixels have their own: what is nearer than the near plane is cut off.
    corner.position = vec4f(in_atlas.x, -in_atlas.y, settings.near, w);
    corner.borders = array(w + at_corner.x, w - at_corner.x, w + at_corner.y, w - at_corner.y);
    corner.edge_0 = surface.edge_0;
    corner.edge_1 = surface.edge_1;
    corner.edge_2 = surface.edge_2;
    corner.margins = surface.margins;
    corner.inverse_depth = surface.inverse_depth;
    corner.place = vec4f(face.origin_x, face.origin_y, face.bottom, face.height);
    corner.tree = vec3u(surface.first_patch, surface.depth, surface.is_back_face);
    return corner;
}

@fragment
fn look_up(seen: Seen) -> Pixel {
    let bottom = seen.place.z;
    let xy = ray(seen.position.xy - seen.place.xy, bottom, settings.pixel);
    // Cut off to the pixel, however the borders are rounded.
    if any(abs(vec2f(xy.x, (xy.y - bottom) * (2.0 / seen.place.w) - 1.0)) > vec2f(1.0)) {
        discard;
    }
    let barycentric = vec3f(at(seen.edge_0, xy), at(seen.edge_1, xy), at(seen.edge_2, xy));
    if any(barycentric < -seen.margins) {
        discard;
    }
    var pixel: Pixel;
    pixel.depth = depth_at(seen.inverse_depth, xy);
    pixel.id = texel_of(seen.tree.z, seen.tree.x, seen.tree.y, barycentric);
    return pixel;
}
