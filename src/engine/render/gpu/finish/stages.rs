//! The compiled stages that finish a picture, and the order in which they run.

use super::planes::{FinishPlanes, LEAST_STEPS, SETS};
use crate::render::gpu::commands::{Commands, dispatch};
use crate::render::gpu::context::Context;
use crate::render::gpu::pipelines::{READ, UNIFORM_AT, WRITE, layout, pipeline};
use crate::render::gpu::shaders::FINISH;
use crate::render::stage_times::Stage;

/// Threads of a workgroup along each side, as in most files of `shaders/finish/`.
const GROUP: usize = 16;

/// Pixels along each side of what a workgroup of `open_holes.wgsl` marks.
const OPEN_HOLES_GROUP: usize = 32;

/// The step at which `ray_masks.wgsl` tells open holes from everything else.
const OPEN_STEP: usize = LEAST_STEPS - 1;

/// Threads of a workgroup of `ray_masks.wgsl`.
const MASKS_GROUP: u64 = 256;

/// The compiled stages, which are called as the shaders of [`FINISH`], in their order.
macro_rules! stages {
    ($($stage:ident)+) => {
        /// The compiled stages.
        #[derive(Debug)]
        pub(super) struct FinishStages {
            pub(super) layout: wgpu::BindGroupLayout,
            $($stage: wgpu::ComputePipeline,)+
        }

        impl FinishStages {
            /// Compiles the stages.
            pub(super) fn new(context: &Context) -> Self {
                let device = &context.device;
                let bindings = [UNIFORM_AT, WRITE, WRITE, WRITE, WRITE, READ, READ, READ, WRITE, WRITE];
                let layout = layout(device, "finish", &bindings);
                let [$($stage),+] = FINISH.map(|shader| pipeline(device, &shader, &[None, Some(&layout)]));
                Self { layout, $($stage),+ }
            }
        }
    };
}

stages! {
    square_ranges lines_of_sight enclosed open_holes rims holes sky ray_masks open_sky kinds pull fill around put_over
}

impl FinishStages {
    /// Marks holes of a picture whose lines of sight are tested.
    pub(super) fn mark_holes(
        &self,
        commands: &mut Commands<'_>,
        planes: &FinishPlanes,
        group: &wgpu::BindGroup,
    ) {
        let (width, height) = (planes.layout.width, planes.layout.height);
        let mut pass = commands.pass(Stage::FreeSpace, "free-space");
        pass.set_bind_group(1, group, &FinishPlanes::at_step(0));
        let steps = [
            (&self.square_ranges, GROUP),
            (&self.lines_of_sight, GROUP),
            (&self.enclosed, GROUP),
            (&self.open_holes, OPEN_HOLES_GROUP),
            (&self.rims, GROUP),
        ];
        for (pipeline, side) in steps {
            pass.set_pipeline(pipeline);
            pass.dispatch_workgroups(width.div_ceil(side) as u32, height.div_ceil(side) as u32, 1);
        }
        if !planes.layout.fills {
            drop(pass);
            self.count_holes(commands, planes, group);
        }
    }

    /// Turns marked pixels into holes, and counts all holes.
    fn count_holes(&self, commands: &mut Commands<'_>, planes: &FinishPlanes, group: &wgpu::BindGroup) {
        commands.encoder.clear_buffer(&planes.counts, 0, None);
        let mut pass = commands.pass(Stage::FreeSpace, "free-space");
        pass.set_bind_group(1, group, &FinishPlanes::at_step(0));
        over_pixels(&mut pass, &self.holes, planes);
    }

    /// Fills the holes of a picture.
    pub(super) fn fill(&self, commands: &mut Commands<'_>, planes: &FinishPlanes, group: &wgpu::BindGroup) {
        self.count_holes(commands, planes, group);
        let mut pass = commands.pass(Stage::Fill, "fill");
        let mask_groups = planes.layout.mask_words().div_ceil(MASKS_GROUP) as u32;
        if planes.layout.tests_lines {
            pass.set_bind_group(1, group, &FinishPlanes::at_step(0));
            over_pixels(&mut pass, &self.sky, planes);
            pass.set_bind_group(1, group, &FinishPlanes::at_step(OPEN_STEP));
            pass.set_pipeline(&self.ray_masks);
            dispatch(&mut pass, mask_groups, 1);
            over_pixels(&mut pass, &self.open_sky, planes);
        }
        pass.set_bind_group(1, group, &FinishPlanes::at_step(0));
        over_pixels(&mut pass, &self.kinds, planes);
        pass.set_pipeline(&self.ray_masks);
        dispatch(&mut pass, mask_groups, SETS as u32);
        pass.set_pipeline(&self.pull);
        for (step, level) in planes.layout.levels().into_iter().enumerate() {
            pass.set_bind_group(1, group, &FinishPlanes::at_step(step));
            let groups = |side: usize| side.div_ceil(GROUP) as u32;
            pass.dispatch_workgroups(groups(level.0), groups(level.1), SETS as u32);
        }
        pass.set_bind_group(1, group, &FinishPlanes::at_step(0));
        over_pixels(&mut pass, &self.fill, planes);
        for step in [0, 1] {
            pass.set_bind_group(1, group, &FinishPlanes::at_step(step));
            over_pixels(&mut pass, &self.around, planes);
        }
        if planes.layout.has_coverage {
            for step in [0, 1] {
                pass.set_bind_group(1, group, &FinishPlanes::at_step(step));
                over_pixels(&mut pass, &self.put_over, planes);
            }
        }
    }
}

/// Runs a stage that has a thread for each pixel.
fn over_pixels(pass: &mut wgpu::ComputePass<'_>, pipeline: &wgpu::ComputePipeline, planes: &FinishPlanes) {
    let groups = |side: usize| side.div_ceil(GROUP) as u32;
    pass.set_pipeline(pipeline);
    pass.dispatch_workgroups(groups(planes.layout.width), groups(planes.layout.height), 1);
}
