//! How long each stage takes on the adapter, by its own clock.

use super::context::Context;
use super::target::read_words;
use crate::error::Result;
use wgpu::BufferUsages as Usage;

/// Stages that are timed in one picture at most.
const MAX_STAGES: u32 = 8;

struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    tick_ns: f32,
}

/// Times the passes of a picture; does nothing where the adapter has no clock.
pub(super) struct StageClock {
    clock: Option<Clock>,
    names: Vec<&'static str>,
    milliseconds: Vec<(&'static str, f64)>,
}

impl StageClock {
    /// A clock at rest.
    pub(super) fn new(context: &Context) -> Result<Self> {
        let bytes = 2 * 8 * u64::from(MAX_STAGES);
        let clock = context.tick_ns.map(|tick_ns| {
            Ok::<_, crate::error::Error>(Clock {
                queries: context.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("stages"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2 * MAX_STAGES,
                }),
                resolved: context.buffer("times", bytes, Usage::QUERY_RESOLVE | Usage::COPY_SRC)?,
                readback: context.buffer("times", bytes, Usage::MAP_READ | Usage::COPY_DST)?,
                tick_ns,
            })
        });
        Ok(Self { clock: clock.transpose()?, names: Vec::new(), milliseconds: Vec::new() })
    }

    /// Forgets the picture before.
    pub(super) fn start(&mut self) {
        self.names.clear();
        self.milliseconds.clear();
    }

    /// Begins the pass of a stage.
    pub(super) fn pass<'a>(
        &mut self,
        encoder: &'a mut wgpu::CommandEncoder,
        name: &'static str,
    ) -> wgpu::ComputePass<'a> {
        let first = 2 * self.names.len() as u32;
        let timed = self.clock.as_ref().filter(|_| first < 2 * MAX_STAGES);
        if timed.is_some() {
            self.names.push(name);
        }
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(name),
            timestamp_writes: timed.map(|clock| wgpu::ComputePassTimestampWrites {
                query_set: &clock.queries,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            }),
        })
    }

    /// Has the times copied to where the CPU can read them.
    pub(super) fn record_readback(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(clock) = &self.clock {
            let count = 2 * self.names.len() as u32;
            encoder.resolve_query_set(&clock.queries, 0..count, &clock.resolved, 0);
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, &clock.readback, 0, u64::from(count) * 8);
        }
    }

    /// Takes the times, once the picture is done.
    pub(super) fn read(&mut self, context: &Context) -> Result<()> {
        let Some(clock) = &self.clock else { return Ok(()) };
        let names = &self.names;
        self.milliseconds = read_words(context, &clock.readback, |words| {
            let tick = |index: usize| u64::from(words[2 * index]) | u64::from(words[2 * index + 1]) << 32;
            let elapsed = |nth: usize| tick(2 * nth + 1).saturating_sub(tick(2 * nth)) as f64;
            let in_ms = |nth: usize| elapsed(nth) * f64::from(clock.tick_ns) * 1e-6;
            names.iter().enumerate().map(|(nth, name)| (*name, in_ms(nth))).collect()
        })?;
        Ok(())
    }

    /// Stages of the last picture, in order, with their milliseconds; empty where the adapter has no clock.
    pub(super) fn milliseconds(&self) -> &[(&'static str, f64)] {
        &self.milliseconds
    }
}

impl std::fmt::Debug for StageClock {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StageClock").field("milliseconds", &self.milliseconds).finish_non_exhaustive()
    }
}
