//! What the cameras that are asked about lines of sight saw: the stages of `shaders/seen/`.

use super::painted::{Known, Painted, Recording};
use crate::capture::Camera;
use crate::error::Result;
use crate::render::free_space::{CELL_BORDER, behind_ratio, cameras_to_ask};
use crate::render::gpu::context::Context;
use crate::render::gpu::layout::{GpuCellView, GpuProjector};
use crate::render::gpu::pipelines::{Pipelines, READ, WRITE, bind, layout, pipeline};
use crate::render::gpu::scene::list;
use crate::render::gpu::shaders::{CARRY, FREE_DEPTHS};
use crate::render::stage_times::Stage;
use crate::samples::halved_camera;
use wgpu::BufferUsages as Usage;

/// Threads of a workgroup along each side, as in `free_depths.wgsl`.
const GROUP: u32 = 16;

/// The compiled stages, and what they found.
#[derive(Debug)]
pub(super) struct SeenCells {
    carry_layout: wgpu::BindGroupLayout,
    free_layout: wgpu::BindGroupLayout,
    carry: wgpu::ComputePipeline,
    free: wgpu::ComputePipeline,
    slots: Option<Slots>,
}

/// Places for what some cameras saw.
#[derive(Debug)]
struct Slots {
    /// Cells of a place: as many as the largest camera has.
    cells: u64,
    /// The nearest surface in each cell according to the background, and according to the frame.
    background: wgpu::Buffer,
    frame: wgpu::Buffer,
    /// How far lines of sight are free.
    free: wgpu::Buffer,
    held: Vec<Slot>,
}

/// A place, and whose it is.
#[derive(Clone, Copy, Debug, Default)]
struct Slot {
    camera: Option<usize>,
    has_background: bool,
    has_frame: bool,
}

impl Slots {
    fn new(context: &Context, count: usize, cells: u64) -> Result<Self> {
        let bytes = 4 * cells * count as u64;
        let usage = Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC;
        let buffer = |label| context.buffer(label, bytes, usage);
        Ok(Self {
            cells,
            background: buffer("what cameras saw of the background")?,
            frame: buffer("what cameras saw")?,
            free: buffer("free space of cameras")?,
            held: vec![Slot::default(); count],
        })
    }

    /// Gives a place to each of the wanted cameras; the places in their order.
    fn assign(&mut self, wanted: &[usize]) -> Vec<usize> {
        let is_wanted = |slot: &Slot| slot.camera.is_some_and(|camera| wanted.contains(&camera));
        let mut free: Vec<usize> =
            (0..self.held.len()).filter(|nth| !is_wanted(&self.held[*nth])).rev().collect();
        let place_of = |camera: &usize| {
            let known = self.held.iter().position(|slot| slot.camera == Some(*camera));
            known.or_else(|| {
                let place = free.pop()?;
                self.held[place] = Slot { camera: Some(*camera), ..Slot::default() };
                Some(place)
            })
        };
        wanted.iter().filter_map(place_of).collect()
    }
}

/// A camera that is asked, and its place.
struct AskedCamera {
    place: usize,
    cells: Camera,
    view: GpuCellView,
}

impl SeenCells {
    /// Compiles the stages.
    pub(super) fn new(context: &Context, pipelines: &Pipelines) -> Self {
        let device = &context.device;
        let carry_layout = layout(device, "carry", &[READ, READ, WRITE]);
        let free_layout = layout(device, "free depths", &[READ, READ, WRITE]);
        let over_samples = [Some(&pipelines.scene_layout), Some(&carry_layout)];
        Self {
            carry: pipeline(device, &CARRY, &over_samples),
            free: pipeline(device, &FREE_DEPTHS, &[None, Some(&free_layout)]),
            carry_layout,
            free_layout,
            slots: None,
        }
    }

    /// How far lines of sight of cameras are free, once that was recorded.
    pub(super) fn free_depths(&self) -> Option<&wgpu::Buffer> {
        self.slots.as_ref().map(|slots| &slots.free)
    }

    pub(super) fn drop_buffers(&mut self) {
        self.slots = None;
    }

    /// Records the work that finds what the cameras asked from a vantage saw, as far as it is not known. Returns their views, the nearest
    /// camera first.
    pub(super) fn record(
        &mut self,
        recording: &mut Recording<'_, '_>,
        known: Known,
    ) -> Result<Vec<GpuCellView>> {
        let (context, painted) = (recording.context, recording.painted);
        let cameras = &painted.frame.set.cameras;
        let wanted = cameras_to_ask(cameras, painted.camera);
        let most = cameras.iter().map(cell_count).max().unwrap_or(0);
        let fits = |slots: &Slots| (slots.held.len(), slots.cells) == (wanted.len(), most);
        let mut slots = match self.slots.take().filter(fits) {
            Some(slots) => slots,
            None => Slots::new(context, wanted.len(), most)?,
        };
        for slot in &mut slots.held {
            slot.has_background &= known.background;
            slot.has_frame &= known.frame;
        }
        let places = slots.assign(&wanted);
        let asked = |(camera, place): (&usize, &usize)| {
            let cells = halved_camera(&cameras[*camera]);
            let view = view_of(&cells, painted.camera, *place as u64 * most);
            AskedCamera { place: *place, cells, view }
        };
        let asked: Vec<AskedCamera> = wanted.iter().zip(&places).map(asked).collect();
        self.complete(recording, &mut slots, &asked)?;
        self.slots = Some(slots);
        Ok(asked.iter().map(|asked| asked.view).collect())
    }

    /// Fills the places that hold nothing yet.
    fn complete(
        &self,
        recording: &mut Recording<'_, '_>,
        slots: &mut Slots,
        asked: &[AskedCamera],
    ) -> Result<()> {
        let (context, painted) = (recording.context, recording.painted);
        let carry = ("seen", &self.carry, &self.carry_layout);
        let place_bytes = 4 * slots.cells;
        let lacks = |has: fn(&Slot) -> bool| -> Vec<&AskedCamera> {
            asked.iter().filter(|asked| !has(&slots.held[asked.place])).collect()
        };
        let (no_background, no_frame) = (lacks(|slot| slot.has_background), lacks(|slot| slot.has_frame));
        if no_frame.is_empty() {
            return Ok(());
        }
        for asked in &no_background {
            let at = asked.place as u64 * place_bytes;
            recording.commands.encoder.clear_buffer(&slots.background, at, Some(place_bytes));
        }
        if !no_background.is_empty() {
            let views = CarriedInto::new(context, painted, &no_background)?;
            recording.over_layer(carry, 0, &[&views.views, &views.into_cells, &slots.background]);
        }
        let views = CarriedInto::new(context, painted, &no_frame)?;
        for asked in &no_frame {
            let at = asked.place as u64 * place_bytes;
            let encoder = &mut recording.commands.encoder;
            encoder.copy_buffer_to_buffer(&slots.background, at, &slots.frame, at, place_bytes);
        }
        recording.over_layer(carry, 1, &[&views.views, &views.into_cells, &slots.frame]);
        let resources = [&views.views, &slots.frame, &slots.free].map(wgpu::Buffer::as_entire_binding);
        let group = bind(&context.device, &self.free_layout, resources);
        let mut pass = recording.commands.pass(Stage::FreeSpace, "seen");
        pass.set_pipeline(&self.free);
        pass.set_bind_group(1, &group, &[]);
        let [across, down] = views.largest.map(|side| side.div_ceil(GROUP));
        pass.dispatch_workgroups(across, down, no_frame.len() as u32);
        drop(pass);
        for slot in &mut slots.held {
            (slot.has_background, slot.has_frame) = (slot.camera.is_some(), slot.camera.is_some());
        }
        Ok(())
    }
}

/// Cameras into which samples are carried.
struct CarriedInto {
    views: wgpu::Buffer,
    into_cells: wgpu::Buffer,
    /// Most columns and rows of their cells.
    largest: [u32; 2],
}

impl CarriedInto {
    fn new(context: &Context, painted: Painted<'_>, asked: &[&AskedCamera]) -> Result<Self> {
        let views: Vec<GpuCellView> = asked.iter().map(|asked| asked.view).collect();
        let cameras = &painted.frame.set.cameras;
        let into = |asked: &&AskedCamera| {
            cameras.iter().map(|camera| GpuProjector::new(camera, &asked.cells)).collect::<Vec<_>>()
        };
        let into_cells: Vec<GpuProjector> = asked.iter().flat_map(into).collect();
        let largest = |side: fn(&GpuCellView) -> u32| views.iter().map(side).max().unwrap_or(0);
        Ok(Self {
            largest: [largest(|view| view.across), largest(|view| view.down)],
            views: list(context, "views", &views)?,
            into_cells: list(context, "into cells", &into_cells)?,
        })
    }
}

/// Columns and rows of a camera's cells with the border, by the camera of the cells.
fn cells_with_border(cells: &Camera) -> [u32; 2] {
    let (width, height) = cells.intrinsics.size();
    [width, height].map(|side| (side + 2 * CELL_BORDER) as u32)
}

/// Cells of a camera, with the border.
fn cell_count(camera: &Camera) -> u64 {
    cells_with_border(&halved_camera(camera)).map(u64::from).into_iter().product()
}

fn view_of(cells: &Camera, target: &Camera, first: u64) -> GpuCellView {
    let [across, down] = cells_with_border(cells);
    let cells_from_target = GpuProjector::new(target, cells);
    GpuCellView { cells_from_target, across, down, first: first as u32, behind_ratio: behind_ratio(cells) }
}
