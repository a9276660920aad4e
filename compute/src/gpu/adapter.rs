//! Opening an adapter, and making errors of what wgpu would panic about.
//!
//! By default wgpu panics on any error that no scope captures; here they are noted, and whatever comes
//! next returns [`BackendError::DeviceLost`]. Two panics cannot be configured away (wgpu 30): waiting
//! for a device that turns out to be lost, and dropping the queue of one. The first is caught; the
//! second is avoided by never dropping such a queue.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use wgpu::util::DeviceExt;

use crate::rows::BackendError;
use crate::settings::AdapterChoice;

/// A submission that has not ended by then is taken for a lost device: far above what any driver's
/// watchdog allows, for the sake of software adapters on busy machines.
const TIMEOUT: Duration = Duration::from_mins(10);

/// Set once it is known that this machine has no graphics card: drivers take a while to say so, and some write to
/// standard error each time.
static NO_REAL_ADAPTER: OnceLock<()> = OnceLock::new();

/// Preference among adapters, the best first; `None`: not accepted.
fn rank(device_type: wgpu::DeviceType, choice: AdapterChoice) -> Option<u32> {
    match (device_type, choice) {
        (wgpu::DeviceType::DiscreteGpu, _) => Some(0),
        (wgpu::DeviceType::IntegratedGpu, _) => Some(1),
        (wgpu::DeviceType::VirtualGpu, _) => Some(2),
        (wgpu::DeviceType::Other, AdapterChoice::Any) => Some(3),
        (wgpu::DeviceType::Cpu, AdapterChoice::Any) => Some(4),
        (_, AdapterChoice::RealOnly) => None,
    }
}

/// An opened device.
#[derive(Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its only queue.
    pub queue: wgpu::Queue,
    name: String,
    /// The first thing that went wrong; nothing is done any more after that.
    failure: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// Opens the best adapter that the choice accepts.
    pub fn open(choice: AdapterChoice) -> Result<Self, BackendError> {
        if choice == AdapterChoice::RealOnly && NO_REAL_ADAPTER.get().is_some() {
            return Err(BackendError::NoAdapter);
        }
        // The first-class interfaces only: those in which compute shaders and atomics are certain.
        let backends = wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = pollster::block_on(instance.enumerate_adapters(backends))
            .into_iter()
            .filter_map(|adapter| Some((rank(adapter.get_info().device_type, choice)?, adapter)))
            .min_by_key(|(rank, _)| *rank)
            .map(|(_, adapter)| adapter)
            .ok_or_else(|| {
                if choice == AdapterChoice::RealOnly {
                    NO_REAL_ADAPTER.get_or_init(|| ());
                }
                BackendError::NoAdapter
            })?;
        let info = adapter.get_info();
        let unsuitable = |what: String| BackendError::Unsuitable {
            adapter: info.name.clone(),
            what,
        };
        if !adapter.get_downlevel_capabilities().is_webgpu_compliant() {
            return Err(unsuitable(
                "the driver lacks features that WebGPU asks for".into(),
            ));
        }
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("radiosity"),
            // All it offers: buffers are sized by a budget of our own, within these limits.
            required_limits: adapter.limits(),
            required_features: adapter.features() & wgpu::Features::CLIP_DISTANCES,
            ..wgpu::DeviceDescriptor::default()
        }))
        .map_err(|error| unsuitable(format!("the device could not be opened ({error})")))?;

        let failure = Arc::new(Mutex::new(None));
        let note = |failure: &Mutex<Option<String>>, what: String| {
            failure
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .get_or_insert(what);
        };
        let noted = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            note(&noted, one_line(&error.to_string()));
        }));
        let noted = Arc::clone(&failure);
        device.set_device_lost_callback(move |reason, message| {
            note(&noted, one_line(&format!("{reason:?}: {message}")));
        });
        Ok(Self {
            device,
            queue,
            name: format!("{}, {}", info.name, info.backend),
            failure,
        })
    }

    /// The adapter's name and the interface it is driven through.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// An error that says why the adapter will not do.
    pub fn unsuitable(&self, what: String) -> BackendError {
        BackendError::Unsuitable {
            adapter: self.name.clone(),
            what,
        }
    }

    /// An error if anything has gone wrong so far.
    pub fn check(&self) -> Result<(), BackendError> {
        match self.failure() {
            None => Ok(()),
            Some(what) => Err(BackendError::DeviceLost { what }),
        }
    }

    /// Submits commands, to be carried out after all that was submitted before.
    pub fn submit(
        &self,
        encoder: wgpu::CommandEncoder,
    ) -> Result<wgpu::SubmissionIndex, BackendError> {
        let commands = encoder.finish();
        self.check()?;
        Ok(self.queue.submit([commands]))
    }

    /// Submits commands and waits until they have been carried out.
    pub fn run(&self, encoder: wgpu::CommandEncoder) -> Result<(), BackendError> {
        let submission = self.submit(encoder)?;
        self.wait(submission)
    }

    /// Waits until a submission has been carried out, and all before it.
    pub fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), BackendError> {
        self.check()?;
        let poll = || {
            self.device.poll(wgpu::PollType::Wait {
                submission_index: Some(submission),
                timeout: Some(TIMEOUT),
            })
        };
        // wgpu panics in its outermost layer, where it holds nothing that could be left half done.
        match catch_unwind(AssertUnwindSafe(poll)) {
            Ok(Ok(_)) => self.check(),
            Ok(Err(error)) => Err(self.lost(&error.to_string())),
            Err(_) => Err(self.lost("waiting for it failed")),
        }
    }

    /// Gives the device up. The first reason ever noted is the one told: it is the cause of the
    /// others.
    pub fn lost(&self, what: &str) -> BackendError {
        let what = self
            .locked_failure()
            .get_or_insert_with(|| one_line(what))
            .clone();
        BackendError::DeviceLost { what }
    }

    /// A new command encoder.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// A new buffer of zeros; empty ones have room for 16 bytes, as no binding may be empty.
    pub fn buffer(&self, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(16).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT),
            usage,
            mapped_at_creation: false,
        })
    }

    /// A new buffer that holds these values.
    pub fn constant_buffer<T: bytemuck::NoUninit>(
        &self,
        label: &str,
        values: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        self.device
            .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents: bytemuck::cast_slice(values),
                usage,
            })
    }

    /// A texture that is drawn into, for the uses given besides.
    pub fn texture(
        &self,
        label: &str,
        size: wgpu::Extent3d,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        })
    }

    /// A compiled shader.
    pub fn shader(&self, label: &str, wgsl: String) -> wgpu::ShaderModule {
        self.device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(wgsl.into()),
            })
    }

    /// Resources bound in order, from binding 0 on.
    pub fn bind_group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding,
                resource: resource.clone(),
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        })
    }

    /// What has gone wrong, if anything has.
    pub fn failure(&self) -> Option<String> {
        self.locked_failure().clone()
    }

    fn locked_failure(&self) -> MutexGuard<'_, Option<String>> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        // Dropping the queue of a lost device waits for work that never ends, or panics.
        if self.failure().is_some() {
            std::mem::forget(self.queue.clone());
        }
    }
}

/// wgpu's messages are trees of several lines; an error message is one.
fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::DeviceType::{Cpu, DiscreteGpu, IntegratedGpu, Other, VirtualGpu};

    #[test]
    fn graphics_cards_come_first_and_software_only_when_asked_for() {
        let order = [DiscreteGpu, IntegratedGpu, VirtualGpu, Other, Cpu];
        let ranks = order.map(|device_type| rank(device_type, AdapterChoice::Any));
        assert!(ranks.is_sorted() && ranks.iter().all(Option::is_some));
        for device_type in order {
            let is_real = matches!(device_type, DiscreteGpu | IntegratedGpu | VirtualGpu);
            assert_eq!(
                rank(device_type, AdapterChoice::RealOnly).is_some(),
                is_real
            );
        }
    }
}
