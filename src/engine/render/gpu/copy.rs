//! How fast the adapter copies its own memory: the limit that painting on it is held against.

use super::context::{AdapterChoice, Context};
use crate::error::Result;
use wgpu::BufferUsages as Usage;

/// Two buffers on an adapter.
#[derive(Debug)]
pub struct GpuCopy {
    context: Context,
    from: wgpu::Buffer,
    to: wgpu::Buffer,
}

impl GpuCopy {
    /// Two buffers of `bytes`, or of what the adapter takes at most, on the best adapter of a choice.
    ///
    /// # Errors
    /// `Gpu` if there is no adapter.
    pub fn new(adapter: AdapterChoice, bytes: u64) -> Result<Self> {
        let context = Context::new(adapter)?;
        let bytes = bytes.min(context.max_binding());
        let buffer = |label| context.buffer(label, bytes, Usage::COPY_SRC | Usage::COPY_DST);
        let (from, to) = context.guarded(|| Ok((buffer("from")?, buffer("to")?)))?;
        Ok(Self { context, from, to })
    }

    /// Bytes that one copy reads and writes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.from.size()
    }

    /// Copies once and waits for it.
    ///
    /// # Errors
    /// `Gpu` where the adapter fails.
    pub fn copy(&self) -> Result<()> {
        self.context.guarded(|| {
            let mut encoder =
                self.context.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(&self.from, 0, &self.to, 0, self.bytes());
            self.context.queue.submit([encoder.finish()]);
            self.context.wait()
        })
    }
}
