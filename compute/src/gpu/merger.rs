//! Sums delta form factors by patch on the device, and reads the sums that are not zero. Twin of the
//! merging in `cpu.rs`.

use super::adapter::Gpu;
use super::atlas::AtlasLayout;
use super::readback::Readback;
use super::structs::{
    self, CountedEntry, MergeSettings, PIXELS_PER_THREAD, RowSummary, Tile, WORKGROUP_SIZE,
};
use crate::hemicubes::Hemicubes;
use crate::rows::{BackendError, Entry, Row, RowBatch, Unseen};
use visibility::hemicube;

/// What a batch's sums may take, and what its entries may, bytes each, unless one row alone takes
/// more. Not tuned.
const BATCH_BUDGET: u64 = 64 << 20;
/// The most rows in a batch: what one dispatch can count in one dimension.
const MAX_ROWS: u64 = 65_535;

/// Batches whose results can wait to be read: one is read while the device works on the next.
pub const SLOTS: usize = 2;
/// Entries of a row that are copied while nothing is known of any, at most.
const FIRST_EXPECTED: u32 = 1024;

/// Sums of the rows of a batch.
#[derive(Debug)]
pub struct Merger {
    /// `row_count` is that of the batch finished last.
    settings: MergeSettings,
    max_rows: u32,
    /// How many hemicubes the patches have for whom the tables of delta form factors are, in order.
    counts: Vec<u32>,
    add_pixels: wgpu::ComputePipeline,
    count_entries: wgpu::ComputePipeline,
    place_entries: wgpu::ComputePipeline,
    write_entries: wgpu::ComputePipeline,
    settings_buffer: wgpu::Buffer,
    tiles: wgpu::Buffer,
    slots: [Slot; SLOTS],
    /// The slot of the batch that tiles are added to.
    slot: usize,
    /// Entries that a row is expected to have: so many are copied before it is known.
    expected_per_row: u64,
}

/// What a batch's results are written to, and stay in until they are read.
#[derive(Debug)]
struct Slot {
    bind_group: wgpu::BindGroup,
    entries: wgpu::Buffer,
    summaries: wgpu::Buffer,
    summaries_readback: Readback,
    /// Grows with what there is to read.
    entries_readback: Readback,
    row_count: u32,
    /// How much was copied to `entries_readback`.
    entries_bytes: u64,
}

impl Slot {
    fn summaries_bytes(&self) -> u64 {
        u64::from(self.row_count) * size_of::<RowSummary>() as u64
    }
}

impl Merger {
    /// Sums for rows of a scene's hemicubes, from an atlas.
    pub fn new(
        gpu: &Gpu,
        atlas: &wgpu::TextureView,
        layout: AtlasLayout,
        hemicubes: &Hemicubes,
    ) -> Result<Self, BackendError> {
        let patch_count = hemicubes.sources().count();
        let counts: Vec<u32> = hemicubes.tables().map(|(count, _)| count).collect();
        let hemicubes_per_row = counts.last().copied().unwrap_or(1);
        let sums_per_row = u64::from(patch_count) + 2;
        let pixels_per_row =
            hemicube::pixel_count(layout.resolution) as u64 * u64::from(hemicubes_per_row);
        let entries_per_row = u64::from(patch_count).min(pixels_per_row);
        let sums_bytes = sums_per_row * size_of::<u32>() as u64;
        let entries_bytes = entries_per_row * size_of::<CountedEntry>() as u64;
        let factors: Vec<u32> = hemicubes
            .tables()
            .flat_map(|(_, table)| [table.face(0), table.face(1)])
            .flatten()
            .copied()
            .collect();

        let limits = gpu.device.limits();
        let most = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let needed = sums_bytes
            .max(entries_bytes)
            .max(size_of_val(factors.as_slice()) as u64);
        if needed > most {
            return Err(gpu.unsuitable(format!(
                "{patch_count} patches at resolution {} need a buffer of {needed} bytes, of which it \
                 allows {most}",
                layout.resolution
            )));
        }
        let budget = BATCH_BUDGET.min(most);
        let max_rows = (budget / sums_bytes.max(entries_bytes)).clamp(1, MAX_ROWS);
        let words_per_row = patch_count.div_ceil(u32::BITS);
        let blocks_per_row = words_per_row.div_ceil(WORKGROUP_SIZE);

        let storage = wgpu::BufferUsages::STORAGE;
        let (to, from) = (wgpu::BufferUsages::COPY_DST, wgpu::BufferUsages::COPY_SRC);
        let summaries_bytes = max_rows * size_of::<RowSummary>() as u64;
        let tiles_bytes = u64::from(layout.tiles()) * size_of::<Tile>() as u64;
        let settings = MergeSettings {
            resolution: layout.resolution,
            patch_count,
            words_per_row,
            blocks_per_row,
            row_count: 0,
        };
        let settings_usage = wgpu::BufferUsages::UNIFORM | to;
        let settings_buffer = gpu.constant_buffer("merge settings", &[settings], settings_usage);
        let tiles = gpu.buffer("tiles", tiles_bytes, storage | to);
        let touched = gpu.buffer("touched", 4 * max_rows * u64::from(words_per_row), storage);
        let blocks = gpu.buffer("blocks", 4 * max_rows * u64::from(blocks_per_row), storage);
        let sums = gpu.buffer("sums", max_rows * sums_bytes, storage);

        let group_layout = group_layout(gpu);
        let factors = gpu.constant_buffer("delta form factors", &factors, storage);
        let slots = [(); SLOTS].map(|()| {
            let entries = gpu.buffer("entries", max_rows * entries_bytes, storage | from);
            let summaries = gpu.buffer("summaries", summaries_bytes, storage | from);
            let bind_group = gpu.bind_group(
                &group_layout,
                &[
                    settings_buffer.as_entire_binding(),
                    wgpu::BindingResource::TextureView(atlas),
                    tiles.as_entire_binding(),
                    factors.as_entire_binding(),
                    sums.as_entire_binding(),
                    touched.as_entire_binding(),
                    blocks.as_entire_binding(),
                    entries.as_entire_binding(),
                    summaries.as_entire_binding(),
                ],
            );
            Slot {
                bind_group,
                entries,
                summaries,
                summaries_readback: Readback::new(gpu, "summaries readback", summaries_bytes),
                entries_readback: Readback::new(gpu, "entries readback", 0),
                row_count: 0,
                entries_bytes: 0,
            }
        });
        let module = gpu.shader("merger.wgsl", structs::merger_wgsl());
        let pipeline = |name| pipeline(gpu, &module, &group_layout, name);
        Ok(Self {
            settings,
            max_rows: max_rows as u32,
            counts,
            add_pixels: pipeline("add_pixels"),
            count_entries: pipeline("count_entries"),
            place_entries: pipeline("place_entries"),
            write_entries: pipeline("write_entries"),
            settings_buffer,
            tiles,
            slots,
            slot: 0,
            expected_per_row: FIRST_EXPECTED.min(patch_count).into(),
        })
    }

    /// The most rows in a batch.
    pub fn max_rows(&self) -> u32 {
        self.max_rows
    }

    /// Describes a tile of a hemicube, of which the row's patch has `count`, to [`Self::add`].
    pub fn tile(&self, [origin_x, origin_y]: [u32; 2], row: u32, tile: usize, count: u32) -> Tile {
        let pixels = self.settings.resolution.pow(2);
        // A table holds the top, then the one half face that serves all sides.
        let table = self.counts.partition_point(|&c| c < count) as u32;
        let first = table * (pixels + pixels / 2);
        let (first_factor, factor_period) = if tile == 0 {
            (first, pixels)
        } else {
            (first + pixels, pixels / 2)
        };
        Tile {
            origin_x,
            origin_y,
            row,
            first_factor,
            factor_period,
        }
    }

    /// Adds tiles of the atlas to the rows of the next batch, numbered from 0.
    pub fn add(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, tiles: &[Tile]) {
        gpu.queue
            .write_buffer(&self.tiles, 0, bytemuck::cast_slice(tiles));
        let pixels = self.settings.resolution.pow(2);
        let mut pass = self.pass(encoder);
        pass.set_pipeline(&self.add_pixels);
        pass.dispatch_workgroups(
            pixels.div_ceil(WORKGROUP_SIZE * PIXELS_PER_THREAD),
            tiles.len() as u32,
            1,
        );
    }

    /// Picks out the sums that are not zero, and sets all to zero for the next batch. The batch has at most
    /// [`Self::max_rows`] rows, and at most [`SLOTS`] are finished and not yet read.
    pub fn finish(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        row_count: u32,
    ) -> FinishedBatch {
        self.settings.row_count = row_count;
        gpu.queue
            .write_buffer(&self.settings_buffer, 0, bytemuck::bytes_of(&self.settings));
        let blocks_per_row = self.settings.blocks_per_row;
        let mut pass = self.pass(encoder);
        pass.set_pipeline(&self.count_entries);
        pass.dispatch_workgroups(blocks_per_row, row_count, 1);
        pass.set_pipeline(&self.place_entries);
        pass.dispatch_workgroups(1, 1, 1);
        pass.set_pipeline(&self.write_entries);
        pass.dispatch_workgroups(blocks_per_row, row_count, 1);
        drop(pass);

        let finished = FinishedBatch { slot: self.slot };
        let slot = &mut self.slots[self.slot];
        self.slot = (self.slot + 1) % SLOTS;
        slot.row_count = row_count;
        let expected = u64::from(row_count) * self.expected_per_row;
        slot.entries_bytes = (expected * size_of::<CountedEntry>() as u64).min(slot.entries.size());
        if slot.entries_bytes > slot.entries_readback.bytes() {
            let bytes = slot.entries_bytes.next_power_of_two();
            slot.entries_readback = Readback::new(gpu, "entries readback", bytes);
        }
        let mut copy = |from: &wgpu::Buffer, to: &Readback, bytes| {
            encoder.copy_buffer_to_buffer(from, 0, to.buffer(), 0, bytes);
        };
        let summaries_bytes = slot.summaries_bytes();
        copy(&slot.summaries, &slot.summaries_readback, summaries_bytes);
        copy(&slot.entries, &slot.entries_readback, slot.entries_bytes);
        finished
    }

    /// Asks for the results of a batch that has been submitted.
    pub fn ask(&mut self, batch: &FinishedBatch) {
        let slot = &mut self.slots[batch.slot];
        slot.summaries_readback.ask(slot.summaries_bytes());
        slot.entries_readback.ask(slot.entries_bytes);
    }

    /// Adds the rows of a batch whose [`Self::finish`] has been carried out.
    pub fn read(
        &mut self,
        gpu: &Gpu,
        batch: &FinishedBatch,
        rows: &mut RowBatch,
    ) -> Result<(), BackendError> {
        let slot = &mut self.slots[batch.slot];
        let summaries: Vec<RowSummary> = slot
            .summaries_readback
            .take(gpu, bytemuck::pod_collect_to_vec)?;
        let count = summaries.last().map_or(0, |summary| summary.end);
        let bytes = u64::from(count) * size_of::<CountedEntry>() as u64;
        if bytes > slot.entries.size() {
            return Err(gpu.lost("its sums are not those of any row"));
        }
        if bytes > slot.entries_bytes {
            // More than was expected: they are still where they were written.
            slot.entries_readback.take(gpu, |_| ())?;
            let mut all = Readback::new(gpu, "entries readback", bytes);
            let mut encoder = gpu.encoder();
            encoder.copy_buffer_to_buffer(&slot.entries, 0, all.buffer(), 0, bytes);
            let submission = gpu.submit(encoder)?;
            all.ask(bytes);
            gpu.wait(submission)?;
            slot.entries_readback = all;
        }
        let per_row = u64::from(count).div_ceil(u64::from(slot.row_count.max(1)));
        let patch_count = u64::from(self.settings.patch_count);
        self.expected_per_row = (per_row + per_row / 4)
            .max(self.expected_per_row)
            .min(patch_count);
        let entries: Vec<Entry> = slot.entries_readback.take(gpu, |read| {
            let counted: Vec<CountedEntry> =
                bytemuck::pod_collect_to_vec(read.get(..bytes as usize).unwrap_or(&[]));
            let entry = |CountedEntry { patch, units }| Entry {
                source: patch,
                units: units as f32,
            };
            counted.into_iter().map(entry).collect()
        })?;
        let mut start = 0;
        for summary in summaries {
            let end = summary.end as usize;
            let entries = entries
                .get(start..end)
                .ok_or_else(|| gpu.lost("its sums are not those of any row"))?
                .to_vec();
            let unseen = Unseen {
                open: summary.open,
                back_face: summary.back_face,
            };
            rows.push(Row { entries, unseen });
            start = end;
        }
        Ok(())
    }

    fn pass<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::ComputePass<'a> {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_bind_group(0, &self.slots[self.slot].bind_group, &[]);
        pass
    }
}

/// A batch of which the device makes rows, to be read once.
#[derive(Debug)]
pub struct FinishedBatch {
    slot: usize,
}

/// One layout for all four shaders, of which each uses a part.
fn group_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let buffer = |ty| wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let read_only = buffer(wgpu::BufferBindingType::Storage { read_only: true });
    let read_write = buffer(wgpu::BufferBindingType::Storage { read_only: false });
    let atlas = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Uint,
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let types = [
        buffer(wgpu::BufferBindingType::Uniform),
        atlas,
        read_only,
        read_only,
        read_write,
        read_write,
        read_write,
        read_write,
        read_write,
    ];
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        })
        .collect();
    gpu.device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("merger"),
            entries: &entries,
        })
}

fn pipeline(
    gpu: &Gpu,
    module: &wgpu::ShaderModule,
    group_layout: &wgpu::BindGroupLayout,
    entry_point: &str,
) -> wgpu::ComputePipeline {
    let layout = gpu
        .device
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("merger"),
            bind_group_layouts: &[Some(group_layout)],
            immediate_size: 0,
        });
    gpu.device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&layout),
            module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
}
