//! The textures that a picture is drawn into: its colours, the patches seen, and depths.

use std::panic::{AssertUnwindSafe, catch_unwind};

use wgpu::{Device, Extent3d, Queue, Texture, TextureFormat, TextureUsages, TextureView};

/// sRGB codes, as egui takes them.
pub const COLOR: TextureFormat = TextureFormat::Rgba8Unorm;
/// Patch IDs.
pub const SEEN: TextureFormat = TextureFormat::R32Uint;
/// Reversed depths.
pub const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// Textures of one size.
#[derive(Debug)]
pub struct Targets {
    /// Pixels in a row, and rows.
    pub size: [u32; 2],
    /// See [`COLOR`].
    pub color: Texture,
    /// See [`SEEN`].
    pub seen: Texture,
    /// See [`DEPTH`].
    pub depth: Texture,
}

impl Targets {
    /// Textures of a size, whose sides are at least 1 and at most what the device allows.
    pub fn new(device: &Device, size: [u32; 2]) -> Self {
        let texture = |label, format| {
            let usage = TextureUsages::RENDER_ATTACHMENT
                | TextureUsages::TEXTURE_BINDING
                | TextureUsages::COPY_SRC;
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: extent(size),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        Self {
            size,
            color: texture("color", COLOR),
            seen: texture("seen", SEEN),
            depth: texture("depth", DEPTH),
        }
    }

    /// The colours as the window shows them.
    pub fn color_view(&self) -> TextureView {
        view(&self.color)
    }
}

/// A whole texture.
pub fn view(texture: &Texture) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn extent([width, height]: [u32; 2]) -> Extent3d {
    Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    }
}

/// The texels of a rectangle, of 4 bytes each, row by row from the top; `None` where the device fails.
pub fn read(
    device: &Device,
    queue: &Queue,
    texture: &Texture,
    [x, y]: [u32; 2],
    size: [u32; 2],
) -> Option<Vec<[u8; 4]>> {
    let [width, height] = size;
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("texels"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d { x, y, z: 0 },
            ..texture.as_image_copy()
        },
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: None,
            },
        },
        extent(size),
    );
    queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
        // Nobody else listens.
        let _ = sender.send(mapped.is_ok());
    });
    // wgpu 30 panics where it waits for a device that turns out to be lost.
    let wait = || device.poll(wgpu::PollType::wait_indefinitely());
    catch_unwind(AssertUnwindSafe(wait)).ok()?.ok()?;
    if !receiver.recv().ok()? {
        return None;
    }
    let mapped = buffer.get_mapped_range(..).ok()?;
    let rows = mapped.chunks_exact(row as usize);
    let texels = rows.flat_map(|row| row[..4 * width as usize].chunks_exact(4));
    Some(texels.map(|t| [t[0], t[1], t[2], t[3]]).collect())
}
