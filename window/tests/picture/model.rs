//! A room with light in it, and its pictures by the graphics card and by `display`.

use display::shade::{self, Shading};
use display::tone::Tone;
use display::{Camera, Size};
use glam::DVec3;
use scene::function::{IrradianceFunction, Refinement};
use scene::{PatchId, Rgb, Solution};
use test_scenes::colourful_room;
use visibility::Cull;
use window::loaded::Loaded;
use window::looks::Looks;
use window::renderer::Renderer;
use window::values::Values;
use window::view::Asked;

/// Samples along a pixel's side, those of `display`.
pub const SAMPLES: u32 = shade::SAMPLES;

/// Small enough for software, odd enough for rows that end anywhere.
pub const SIZE: Size = Size {
    width: 75,
    height: 58,
};

/// The best adapter, software too.
pub fn adapter() -> Option<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let options = wgpu::RequestAdapterOptions::default();
    pollster::block_on(instance.request_adapter(&options)).ok()
}

/// A renderer on it.
pub fn renderer() -> Renderer {
    let adapter = adapter().expect("there is no GPU adapter");
    let descriptor = wgpu::DeviceDescriptor::default();
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Renderer::new(&device, &queue)
}

/// A number between 0 and 1 that depends on k in a wild way.
fn wild(k: usize) -> f32 {
    (k.wrapping_mul(0x9e37_79b9) >> 8 & 0xffff) as f32 / 65_536.0
}

/// A room whose patches and vertices have irradiances of their own. One of its blocks has no vertices.
pub fn room() -> Loaded {
    let scene = colourful_room(0.05);
    let mut solution = Solution::dark(&scene);
    for (k, irradiance) in solution.irradiance.iter_mut().enumerate() {
        *irradiance = 4.0 * Rgb::new(wild(3 * k), wild(3 * k + 1), wild(3 * k + 2));
    }
    let mut refinement = Refinement::new(&scene, |s| s.0 < 24, |_, _| true);
    for step in 0..200 {
        let leaves: Vec<_> = refinement.leaves().collect();
        let leaf = leaves[(wild(step) * leaves.len() as f32) as usize];
        refinement.bisect(leaf);
    }
    let mesh = refinement.mesh().unwrap();
    let vertices = mesh.vertex_count() as usize;
    let of = |factor: f32| -> Vec<Rgb> {
        let value = |k: usize| factor * Rgb::new(wild(5 * k), wild(5 * k + 1), wild(5 * k + 2));
        (0..vertices).map(value).collect()
    };
    solution.function = Some(IrradianceFunction::new(mesh, of(5.0), of(2.0)).unwrap());
    Loaded::new(scene, Some(solution))
}

/// Where it is seen from inside.
pub fn inside() -> Camera {
    Camera::new(
        DVec3::new(0.31, 0.27, 1.57),
        DVec3::new(1.0, 0.71, -0.42),
        DVec3::Z,
        70.0,
    )
}

/// And from outside, above a corner.
pub fn outside() -> Camera {
    Camera::new(
        DVec3::new(-3.1, -4.3, 5.2),
        DVec3::new(1.0, 1.13, -0.86),
        DVec3::Z,
        40.0,
    )
}

/// What is asked of the graphics card: all the samples that `display` takes.
pub fn asked(camera: Camera, looks: Looks, picked: Option<PatchId>) -> Asked {
    Asked {
        camera,
        scene_size: 5.4,
        size: [SIZE.width, SIZE.height],
        samples: SAMPLES as f32,
        looks,
        picked,
    }
}

/// The samples of a picture by the graphics card, row by row from the top: sRGB codes and patches.
pub fn drawn(loaded: &Loaded, asked: &Asked) -> Vec<([u8; 3], Option<PatchId>)> {
    let mut renderer = renderer();
    let values = Values::new(loaded, &asked.looks).unwrap();
    let tone = asked.looks.tone(values.range);
    let Loaded {
        scene, solution, ..
    } = loaded;
    renderer
        .set_scene(scene, solution.as_ref(), &values, tone)
        .unwrap();
    renderer.draw(asked);
    assert_eq!(
        renderer.sample_size(),
        Some([SIZE.width * SAMPLES, SIZE.height * SAMPLES])
    );
    let samples = renderer.samples().unwrap();
    assert_eq!(renderer.failure(), None);
    samples
}

/// The cull of `display` that a choice stands for.
pub fn cull(looks: &Looks) -> Cull {
    if looks.has_backs {
        Cull::Nothing
    } else {
        Cull::BackFaces
    }
}

/// The patches that `display` sees at the same samples.
pub fn patches_of_display(loaded: &Loaded, asked: &Asked) -> Vec<Option<PatchId>> {
    let size = Size {
        width: SIZE.width * SAMPLES,
        height: SIZE.height * SAMPLES,
    };
    shade::ids(&loaded.scene, &asked.camera, size, cull(&asked.looks)).0
}

/// The display light of each pixel of a picture by `display`.
pub fn light_of_display(loaded: &Loaded, asked: &Asked, tone: &Tone) -> Vec<Rgb> {
    let Loaded {
        scene, solution, ..
    } = loaded;
    let shown = asked.looks.shown;
    let values = shown.of_patches(scene, solution.as_ref()).unwrap();
    let function = shown.function(scene, solution.as_ref(), &values);
    let shading = match function.filter(|_| !asked.looks.is_flat) {
        Some(function) => Shading::Function(function),
        None => Shading::Flat(&values),
    };
    let cull = cull(&asked.looks);
    shade::light(scene, &asked.camera, SIZE, cull, &shading, tone).display
}

/// The samples of each pixel, row by row.
pub fn by_pixel<T: Copy>(samples: &[T]) -> Vec<Vec<T>> {
    let (width, along) = (SIZE.width as usize, SAMPLES as usize);
    let of_pixel = |pixel: usize| {
        let (row, column) = (pixel / width, pixel % width);
        let place = |k: usize| {
            let (x, y) = (column * along + k % along, row * along + k / along);
            samples[y * width * along + x]
        };
        (0..along * along).map(place).collect()
    };
    (0..width * SIZE.height as usize).map(of_pixel).collect()
}
