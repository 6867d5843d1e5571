//! The graphics adapter, and how its failures become errors.
//!
//! wgpu reports most failures through callbacks and would abort the program by default. Here they are collected: all work runs
//! inside [`Context::guarded`], which returns them as [`Error::Gpu`], so that the caller can use the CPU instead.

use std::sync::{Arc, Mutex};

use crate::error::{Error, Result};

/// Storage buffers that the largest stage binds.
const STORAGE_BUFFERS: u32 = 11;

/// Which adapters may be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdapterChoice {
    /// Graphics cards alone.
    Hardware,
    /// Graphics cards first, else a software adapter.
    Any,
}

/// A device that a window draws with. Pictures painted on it are displayed without a copy.
#[derive(Clone, Debug)]
pub struct SharedDevice {
    /// What the device runs on.
    pub adapter: wgpu::Adapter,
    /// The device, opened with [`device_descriptor`].
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
}

/// How to open a device of `adapter` so that the renderer can share it: with all limits of the adapter.
#[must_use]
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    wgpu::DeviceDescriptor {
        label: Some("overlook"),
        required_features: (wide_atomics() | wgpu::Features::TIMESTAMP_QUERY) & adapter.features(),
        required_limits: adapter.limits(),
        ..Default::default()
    }
}

fn wide_atomics() -> wgpu::Features {
    wgpu::Features::SHADER_INT64 | wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX
}

/// Whether a device of `adapter` with these limits can run all stages.
fn is_able(limits: &wgpu::Limits, adapter: &wgpu::Adapter) -> bool {
    limits.max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
        && limits.max_compute_invocations_per_workgroup >= 256
        && adapter
            .get_downlevel_capabilities()
            .flags
            .contains(wgpu::DownlevelFlags::COMPUTE_SHADERS | wgpu::DownlevelFlags::SHADER_F16_IN_F32)
}

/// An open adapter.
#[derive(Debug)]
pub(crate) struct Context {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) adapter: wgpu::AdapterInfo,
    /// Whether there are 64-bit atomics.
    pub(crate) has_wide_atomics: bool,
    /// Whether a window draws with the same device.
    pub(crate) is_shared: bool,
    /// The first failure outside of [`Context::guarded`].
    failure: Arc<Mutex<Option<String>>>,
}

fn gpu_error(what: impl Into<String>) -> Error {
    Error::Gpu { what: what.into() }
}

/// The rank of an adapter, best 0; `None` if the choice excludes it.
fn preference(info: &wgpu::AdapterInfo, choice: AdapterChoice) -> Option<u32> {
    match info.device_type {
        wgpu::DeviceType::DiscreteGpu => Some(0),
        wgpu::DeviceType::IntegratedGpu => Some(1),
        wgpu::DeviceType::VirtualGpu => Some(2),
        wgpu::DeviceType::Other | wgpu::DeviceType::Cpu => (choice == AdapterChoice::Any).then_some(3),
    }
}

/// Whether there may be a graphics card. On Linux a card has a device file; without one, starting Vulkan would only cost a tenth
/// of a second and warnings of its drivers on stderr.
fn may_have_card() -> bool {
    let device_files = ["/dev/dri", "/dev/nvidiactl", "/dev/dxg", "/dev/kgsl-3d0", "/dev/mali0"];
    !cfg!(target_os = "linux") || device_files.iter().any(|path| std::path::Path::new(path).exists())
}

impl Context {
    /// Opens the best adapter.
    ///
    /// # Errors
    /// `Gpu` if there is no adapter, or no adapter can run the stages.
    pub(crate) fn new(choice: AdapterChoice) -> Result<Self> {
        let none =
            || gpu_error("there is no adapter that can compute; use the CPU instead (render.backend = cpu)");
        if choice == AdapterChoice::Hardware && !may_have_card() {
            return Err(none());
        }
        // Not OpenGL: it offers the same cards, and without one it writes errors to stderr.
        let backends = wgpu::Backends::PRIMARY;
        let description = wgpu::InstanceDescriptor {
            backends,
            // With debugging on, the loader logs every driver that it does not find as an error.
            flags: wgpu::InstanceFlags::empty(),
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        };
        let instance = wgpu::Instance::new(description);
        let adapters = pollster::block_on(instance.enumerate_adapters(backends));
        let found =
            adapters.iter().filter(|adapter| is_able(&adapter.limits(), adapter)).filter_map(|adapter| {
                preference(&adapter.get_info(), choice).map(|preference| (preference, adapter))
            });
        let (_, adapter) = found.min_by_key(|(preference, _)| *preference).ok_or_else(none)?;
        Self::open(adapter)
    }

    fn open(adapter: &wgpu::Adapter) -> Result<Self> {
        let opened = pollster::block_on(adapter.request_device(&device_descriptor(adapter)));
        let info = adapter.get_info();
        let (device, queue) =
            opened.map_err(|error| gpu_error(format!("{} cannot be opened: {error}", info.name)))?;
        let context = Self::around(info, device, queue);
        let note_error = context.note();
        context.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note_error(error.to_string())));
        Ok(context)
    }

    /// Shares the device of a window. Failures outside of [`Context::guarded`] still go to the window.
    ///
    /// # Errors
    /// `Gpu` where `choice` excludes the adapter, or the device was opened with less than the stages need.
    pub(crate) fn share(shared: &SharedDevice, choice: AdapterChoice) -> Result<Self> {
        let info = shared.adapter.get_info();
        if preference(&info, choice).is_none() {
            return Err(gpu_error(format!("{} is no GPU", info.name)));
        }
        if !is_able(&shared.device.limits(), &shared.adapter) {
            return Err(gpu_error(format!("{} draws the window but cannot render", info.name)));
        }
        Ok(Self { is_shared: true, ..Self::around(info, shared.device.clone(), shared.queue.clone()) })
    }

    fn around(adapter: wgpu::AdapterInfo, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let features = device.features();
        let context = Self {
            has_wide_atomics: features.contains(wide_atomics()),
            device,
            queue,
            adapter,
            is_shared: false,
            failure: Arc::default(),
        };
        let note_loss = context.note();
        context.device.set_device_lost_callback(move |reason, message| {
            note_loss(format!("the adapter was lost ({reason:?}): {message}"));
        });
        context
    }

    /// A callback that stores the first failure.
    fn note(&self) -> impl Fn(String) + Send + Sync + 'static {
        let failure = self.failure.clone();
        move |what: String| {
            if let Ok(mut first) = failure.lock() {
                first.get_or_insert(what);
            }
        }
    }

    /// Whether the adapter is software that runs on the processor.
    pub(crate) fn is_software(&self) -> bool {
        matches!(self.adapter.device_type, wgpu::DeviceType::Cpu | wgpu::DeviceType::Other)
    }

    /// Does some work and returns failures during it as an error.
    pub(crate) fn guarded<T>(&self, work: impl FnOnce() -> Result<T>) -> Result<T> {
        self.check()?;
        let filters =
            [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal];
        let mut scopes: Vec<_> =
            filters.into_iter().map(|filter| self.device.push_error_scope(filter)).collect();
        let result = work();
        let mut failure = None;
        while let Some(scope) = scopes.pop() {
            failure = pollster::block_on(scope.pop()).or(failure);
        }
        if let Some(error) = failure {
            return Err(self.error(error));
        }
        self.check()?;
        result
    }

    /// Whether something failed outside of [`Context::guarded`]: nothing can be painted any more.
    pub(crate) fn is_lost(&self) -> bool {
        self.check().is_err()
    }

    fn check(&self) -> Result<()> {
        let failure = self.failure.lock().ok().and_then(|failure| failure.clone());
        failure.map_or(Ok(()), |what| Err(self.error(what)))
    }

    /// A failure of this adapter.
    pub(crate) fn error(&self, what: impl std::fmt::Display) -> Error {
        gpu_error(format!("{}: {what}", self.adapter.name))
    }

    /// Waits until everything submitted is done.
    pub(crate) fn wait(&self) -> Result<()> {
        let waited = self.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map(drop).map_err(|error| self.error(error))
    }

    /// The longest buffer that a shader can see, bytes.
    pub(crate) fn max_binding(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) & !255
    }

    /// A buffer of at least `bytes` (and at least 4).
    ///
    /// # Errors
    /// `Gpu` where it is longer than shaders can see.
    pub(crate) fn buffer(&self, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer> {
        if bytes > self.max_binding() {
            return Err(gpu_error(format!(
                "{} takes buffers of at most {} MiB, and {label} needs {} MiB; choose a smaller picture or use the CPU",
                self.adapter.name,
                self.max_binding() >> 20,
                bytes.div_ceil(1 << 20)
            )));
        }
        Ok(self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(4).next_multiple_of(4),
            usage,
            mapped_at_creation: false,
        }))
    }

    /// A buffer with these bytes.
    pub(crate) fn written(
        &self,
        label: &str,
        bytes: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer> {
        let buffer = self.buffer(label, bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST)?;
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }
}
