// Surfaces, each pixel in the colour of the patch or of the leaf of the function that it sees. The meaning of every number is told
// in structs.rs, that of the tone curves in display's tone.rs, and that of bisections in scene's bisection.rs.

struct Surface {
    corner_0: vec3f,
    first_patch: u32,
    corner_1: vec3f,
    depth: u32,
    corner_2: vec3f,
    root: u32,
    material: u32,
}

struct Material {
    more: vec3f,
    factor: vec3f,
}

struct View {
    eye: vec3f,
    half_width: f32,
    right: vec3f,
    half_height: f32,
    up: vec3f,
    near: f32,
    forward: vec3f,
    samples: f32,
    start: f32,
    factor: f32,
    is_logarithmic: u32,
    mode: u32,
    channel: u32,
    has_function: u32,
    has_wires: u32,
    picked: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> surfaces: array<Surface>;
// Three numbers a patch.
@group(0) @binding(2) var<storage, read> patch_values: array<f32>;
// Three vertices, and the first child or 0.
@group(0) @binding(3) var<storage, read> nodes: array<vec4u>;
// Three numbers a vertex.
@group(0) @binding(4) var<storage, read> vertex_values: array<f32>;
@group(0) @binding(5) var<storage, read> materials: array<Material>;
// Display light, COLORS entries.
@group(0) @binding(6) var<storage, read> colors: array<vec4f>;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) barycentric: vec3f,
    @location(1) @interpolate(flat) surface: u32,
}

struct Pixel {
    // sRGB codes over 255.
    @location(0) color: vec4f,
    @location(1) seen: u32,
}

@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let surface = index / 3u;
    let k = index % 3u;
    var place = surfaces[surface].corner_0;
    if k == 1u {
        place = surfaces[surface].corner_1;
    } else if k == 2u {
        place = surfaces[surface].corner_2;
    }
    let q = place - view.eye;
    let depth = dot(q, view.forward);
    var out: Corner;
    // Depth is reversed: near / distance, which f32 holds best.
    out.position = vec4f(
        dot(q, view.right) / view.half_width,
        dot(q, view.up) / view.half_height,
        view.near,
        depth,
    );
    out.barycentric = vec3f(f32(k == 0u), f32(k == 1u), f32(k == 2u));
    out.surface = surface;
    return out;
}

// A point's barycentric coordinates in a triangle, in the half of it that holds the point. It is linear, so that differences of
// coordinates go the same way.
fn in_half(point: vec3f, is_second: bool) -> vec3f {
    if is_second {
        return vec3f(point.z, point.y - point.x, 2.0 * point.x);
    }
    return vec3f(point.x - point.y, point.z, 2.0 * point.y);
}

struct Seen {
    id: u32,
    // Distance of the nearest side, pixels of the screen.
    side: f32,
    // The least height of the patch in the picture, pixels of the screen.
    height: f32,
}

// The patch at a point of a surface, whose coordinates change by these differences from pixel to pixel.
fn patch_at(surface: u32, barycentric: vec3f, difference_x: vec3f, difference_y: vec3f) -> Seen {
    var point = barycentric;
    var dx = difference_x;
    var dy = difference_y;
    var code = 0u;
    for (var level = 0u; level < surfaces[surface].depth; level += 1u) {
        let is_second = point.x < point.y;
        point = in_half(point, is_second);
        dx = in_half(dx, is_second);
        dy = in_half(dy, is_second);
        code = code << 1u | u32(is_second);
    }
    // What a coordinate changes by in a pixel: it is 1 at the height over its side.
    let slope = max(sqrt(dx * dx + dy * dy) * view.samples, vec3f(1e-20));
    let sides = max(point, vec3f(0.0)) / slope;
    let heights = 1.0 / slope;
    var seen: Seen;
    seen.id = surfaces[surface].first_patch + code;
    seen.side = min(sides.x, min(sides.y, sides.z));
    seen.height = min(heights.x, min(heights.y, heights.z));
    return seen;
}

fn patch_value(id: u32) -> vec3f {
    return vec3f(patch_values[3u * id], patch_values[3u * id + 1u], patch_values[3u * id + 2u]);
}

fn vertex_value(id: u32) -> vec3f {
    return vec3f(vertex_values[3u * id], vertex_values[3u * id + 1u], vertex_values[3u * id + 2u]);
}

fn luminance(value: vec3f) -> f32 {
    return dot(value, LUMINANCE_WEIGHTS);
}

fn of_channels(value: vec3f) -> vec3f {
    switch view.channel {
        case CHANNEL_LUMINANCE: { return vec3f(luminance(value)); }
        case CHANNEL_RED: { return value.xxx; }
        case CHANNEL_GREEN: { return value.yyy; }
        case CHANNEL_BLUE: { return value.zzz; }
        default: { return value; }
    }
}

// The function's value at a point of a surface that has vertices.
fn function_at(surface: u32, barycentric: vec3f) -> vec3f {
    var point = barycentric;
    var node = nodes[surfaces[surface].root];
    while node.w != 0u {
        let is_second = point.x < point.y;
        point = in_half(point, is_second);
        node = nodes[node.w + u32(is_second)];
    }
    let value = point.x * vertex_value(node.x) + point.y * vertex_value(node.y) + point.z * vertex_value(node.z);
    let material = materials[surfaces[surface].material];
    return of_channels(material.more + material.factor * max(value, vec3f(0.0)));
}

fn position_on_scale(light: f32) -> f32 {
    if view.is_logarithmic == 0u {
        return (light - view.start) * view.factor;
    }
    if light <= 0.0 {
        return -1e30;
    }
    return (log(light) - view.start) * view.factor;
}

fn decode(code: f32) -> f32 {
    if code <= 0.04045 {
        return code / 12.92;
    }
    return pow((code + 0.055) / 1.055, 2.4);
}

fn encode(light: f32) -> f32 {
    if light <= 0.0031308 {
        return 12.92 * light;
    }
    return 1.055 * pow(light, 1.0 / 2.4) - 0.055;
}

// A value of this luminance, above 0, scaled to a display luminance, and towards grey where a channel would exceed 1.
fn scaled_to(value: vec3f, light: f32, luminance_shown: f32) -> vec3f {
    let scaled = value * (luminance_shown / light);
    let largest = max(scaled.x, max(scaled.y, scaled.z));
    if largest <= 1.0 {
        return scaled;
    }
    let saturation = (1.0 - luminance_shown) / (largest - luminance_shown);
    return vec3f(luminance_shown) + saturation * (scaled - vec3f(luminance_shown));
}

fn filmic(position: f32) -> f32 {
    let x = clamp(position, 0.0, 10.0);
    return min(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 1.0);
}

fn display_light(value: vec3f) -> vec3f {
    switch view.mode {
        case MODE_LOG: {
            let light = luminance(value);
            let t = position_on_scale(light);
            if t <= 0.0 {
                return vec3f(0.0);
            }
            return scaled_to(value, light, decode(min(t, 1.0)));
        }
        case MODE_FILMIC: {
            return vec3f(
                filmic(position_on_scale(value.x)),
                filmic(position_on_scale(value.y)),
                filmic(position_on_scale(value.z)),
            );
        }
        case MODE_LINEAR: {
            return vec3f(
                position_on_scale(value.x),
                position_on_scale(value.y),
                position_on_scale(value.z),
            );
        }
        case MODE_FALSE_COLOR: {
            let t = clamp(position_on_scale(luminance(value)), 0.0, 1.0);
            return colors[u32(round(t * f32(COLORS - 1u)))].xyz;
        }
        // Patches' own colours are display light.
        default: { return value; }
    }
}

@fragment
fn shade(in: Corner, @builtin(front_facing) is_front: bool) -> Pixel {
    // All pixels of a block take part in differences, backs too.
    let dx = dpdx(in.barycentric);
    let dy = dpdy(in.barycentric);
    var out: Pixel;
    out.color = vec4f(0.0, 0.0, 0.0, 1.0);
    out.seen = NO_PATCH;
    if !is_front {
        return out;
    }
    let seen = patch_at(in.surface, in.barycentric, dx, dy);
    out.seen = seen.id;
    var value = vec3f(0.0);
    if view.has_function != 0u && surfaces[in.surface].root != NO_ROOT {
        value = function_at(in.surface, in.barycentric);
    } else {
        value = patch_value(seen.id);
    }
    let light = clamp(display_light(value), vec3f(0.0), vec3f(1.0));
    var color = vec3f(encode(light.x), encode(light.y), encode(light.z));
    // Where a sample is wider than a pixel, lines are as wide, so that they have no gaps; and a patch has to be seen by more pixels.
    let coarseness = max(1.0, 1.0 / view.samples);
    if view.has_wires != 0u && seen.side < WIRE_WIDTH * coarseness {
        // Dark on what is bright and bright on what is dark.
        let wire = vec3f(select(1.0, 0.0, luminance(color) > 0.4));
        color = mix(color, wire, WIRE_OPACITY * smoothstep(WIRED_FROM, WIRED_WHOLE, seen.height / coarseness));
    }
    let is_small = seen.height < OUTLINED_HEIGHT * coarseness;
    if seen.id == view.picked && (is_small || seen.side < OUTLINE_WIDTH * coarseness) {
        color = OUTLINE;
    }
    out.color = vec4f(color, 1.0);
    return out;
}
