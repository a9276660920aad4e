//! Memory that the device writes and the host reads, without waiting in between.

use std::sync::mpsc;

use super::adapter::Gpu;
use crate::rows::BackendError;

/// A buffer that the host can read.
#[derive(Debug)]
pub struct Readback {
    buffer: wgpu::Buffer,
    /// What was asked for: so many bytes, and the word that they can be read.
    asked: Option<(u64, mpsc::Receiver<Result<(), wgpu::BufferAsyncError>>)>,
}

impl Readback {
    /// Room for so many bytes.
    pub fn new(gpu: &Gpu, label: &str, bytes: u64) -> Self {
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        Self {
            buffer: gpu.buffer(label, bytes, usage),
            asked: None,
        }
    }

    /// Where the device writes.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// How many bytes there is room for.
    pub fn bytes(&self) -> u64 {
        self.buffer.size()
    }

    /// Asks for the first `bytes`, as they are when all that was submitted has been carried out. Until they
    /// are taken nothing may be submitted that uses the buffer.
    pub fn ask(&mut self, bytes: u64) {
        let (sender, receiver) = mpsc::channel();
        if bytes > 0 {
            self.buffer
                .slice(..bytes)
                .map_async(wgpu::MapMode::Read, move |result| {
                    // The receiver is gone only when nobody wants the bytes any more.
                    let _ = sender.send(result);
                });
        }
        self.asked = Some((bytes, receiver));
    }

    /// Takes what was asked for; the submissions before have been waited for.
    pub fn take<T>(&mut self, gpu: &Gpu, take: impl FnOnce(&[u8]) -> T) -> Result<T, BackendError> {
        gpu.check()?;
        let unread = |what: &str| gpu.lost(&format!("its memory could not be read: {what}"));
        let (bytes, receiver) = self
            .asked
            .take()
            .ok_or_else(|| unread("nothing was asked for"))?;
        if bytes == 0 {
            return Ok(take(&[]));
        }
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(unread(&error.to_string())),
            Err(error) => return Err(unread(&error.to_string())),
        }
        let view = self
            .buffer
            .slice(..bytes)
            .get_mapped_range()
            .map_err(|error| unread(&error.to_string()))?;
        let taken = take(&view);
        drop(view);
        self.buffer.unmap();
        Ok(taken)
    }
}
