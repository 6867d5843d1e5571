//! A window that draws with the device that paints shows the very picture, though its pixels never leave the adapter.
//!
//! Where the machine has no adapter, not even a software one, each test says so and passes; with `OVERLOOK_REQUIRE_GPU=1` it
//! fails instead.

use std::sync::Arc;

use crate::scene::{Scene, arc, camera};
use crate::skip::skip;
use glam::DVec3;
use overlook_engine::capture::Camera;
use overlook_engine::color::srgb8_from_linear;
use overlook_engine::job::Job;
use overlook_engine::preprocess::preprocess;
use overlook_engine::render::gpu::{GpuOptions, GpuRenderer, HolePattern, SharedDevice, device_descriptor};
use overlook_engine::render::{CpuRenderer, Renderer, Vantage, WindowPicture};
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{Backend, Fill, Kernel, RenderSettings, Settings};

/// Colors that no pixel of the scene has.
const HOLES: HolePattern = HolePattern { colors: [[255, 0, 255], [0, 255, 255]], stripe: 6 };

/// A device as a window would open it, or `None` where the machine cannot have one.
fn window_device() -> Option<SharedDevice> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let Some(adapter) = adapters.into_iter().next() else {
        skip(Some("OVERLOOK_REQUIRE_GPU"), "nothing was compared: there is no adapter");
        return None;
    };
    let opened = pollster::block_on(adapter.request_device(&device_descriptor(&adapter)));
    let (device, queue) = opened.unwrap();
    Some(SharedDevice { adapter, device, queue })
}

fn samples() -> Arc<SampleSet> {
    let capture = Scene::still_life().record(arc(3, 96), 2);
    preprocess(&capture, &Settings::default(), &Job::new()).unwrap().samples
}

fn vantage() -> Vantage {
    let camera: Camera = camera("novel", DVec3::new(-0.6, -4.2, 1.6), DVec3::new(0.3, 0.2, 0.3), 90);
    Vantage { camera, frame: 0 }
}

/// The pixels of a texture, row-major.
fn read(shared: &SharedDevice, texture: &wgpu::Texture) -> Vec<[u8; 4]> {
    let (width, height) = (texture.width(), texture.height());
    let pitch = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = shared.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(pitch * height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = shared.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(pitch),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    shared.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
    shared.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let view = buffer.get_mapped_range(..).unwrap();
    let rows = view.chunks_exact(pitch as usize);
    rows.flat_map(|row| bytemuck::cast_slice::<u8, [u8; 4]>(&row[..width as usize * 4]).to_vec()).collect()
}

#[test]
fn the_window_shows_what_the_cpu_paints_with_holes_filled_or_hatched() {
    let Some(shared) = window_device() else { return };
    let (samples, vantage) = (samples(), vantage());
    let mut gpu = GpuRenderer::sharing(&shared, &GpuOptions::default()).unwrap();
    let ways = Kernel::ALL.iter().flat_map(|kernel| [Fill::None, Fill::PushPull].map(|fill| (*kernel, fill)));
    for (kernel, fill) in ways {
        let settings = RenderSettings { kernel, fill, ..RenderSettings::default() };
        let (picture, expected) =
            CpuRenderer::new().render(&samples, &vantage, &settings, &Job::new()).unwrap();
        let (texture, stats) = gpu.show(&samples, &vantage, &settings, &HOLES, &Job::new()).unwrap();
        assert_eq!((stats.samples, stats.holes), (expected.samples, expected.holes), "{kernel}");
        let hatched = picture.inverse_depth.as_slice().iter().filter(|depth| **depth < 0.0).count();
        assert_eq!(hatched > 0, fill == Fill::None, "{kernel}: {hatched} pixels are hatched");
        assert!(stats.holes > 0 && stats.holes < 90 * 90, "{kernel}: {} holes", stats.holes);
        let width = picture.color.width();
        for (index, shown) in read(&shared, &texture).into_iter().enumerate() {
            let (x, y) = (index % width, index / width);
            let wanted = if picture.shows((x, y)) {
                picture.color[(x, y)].map(srgb8_from_linear)
            } else {
                HOLES.colors[(x + y) / HOLES.stripe as usize % 2]
            };
            for (shown, wanted) in shown.into_iter().zip(wanted) {
                assert!(shown.abs_diff(wanted) <= 1, "{kernel}: {shown} for {wanted} at {x}, {y}");
            }
        }
    }
}

#[test]
fn a_texture_on_screen_is_not_written_again() {
    let Some(shared) = window_device() else { return };
    let (samples, vantage) = (samples(), vantage());
    let mut gpu = GpuRenderer::sharing(&shared, &GpuOptions::default()).unwrap();
    let settings = RenderSettings::default();
    let mut show = |vantage: &Vantage| gpu.show(&samples, vantage, &settings, &HOLES, &Job::new()).unwrap().0;
    let on_screen = show(&vantage);
    let before = read(&shared, &on_screen);
    let next =
        show(&Vantage { camera: camera("other", DVec3::new(2.0, -4.0, 1.0), DVec3::ZERO, 90), frame: 1 });
    assert_ne!(on_screen, next);
    assert_eq!(read(&shared, &on_screen), before);
    assert_ne!(read(&shared, &next), before);
    drop(on_screen);
    let again = show(&vantage);
    assert_ne!(again, next);
    assert_eq!(read(&shared, &again), before);
}

#[test]
fn what_cannot_be_shown_from_the_adapter_comes_through_memory() {
    let Some(shared) = window_device() else { return };
    let (samples, vantage) = (samples(), vantage());
    let mut renderer = Renderer::sharing(Some(shared));
    let mut close_up = vantage.clone();
    let lens = &mut close_up.camera.intrinsics;
    (lens.width, lens.height) = (4 * lens.width, 4 * lens.height);
    for length in [&mut lens.fx, &mut lens.fy, &mut lens.cx, &mut lens.cy] {
        *length *= 4.0;
    }
    let mut is_on_adapter = |backend, kernel, vantage: &Vantage, holes| {
        let settings = RenderSettings { backend, kernel, ..RenderSettings::default() };
        let (shown, _) = renderer.show(&samples, vantage, &settings, holes, &Job::new()).unwrap();
        matches!(shown, WindowPicture::OnAdapter(_))
    };
    assert!(is_on_adapter(Backend::Gpu, Kernel::Gather, &vantage, Some(&HOLES)), "with all defaults");
    assert!(!is_on_adapter(Backend::Gpu, Kernel::Surfel, &vantage, None));
    assert!(!is_on_adapter(Backend::Gpu, Kernel::Surfel, &close_up, Some(&HOLES)));
    assert!(!is_on_adapter(Backend::Cpu, Kernel::Surfel, &vantage, Some(&HOLES)));
    let mut apart = Renderer::new();
    let settings = RenderSettings { backend: Backend::Gpu, ..RenderSettings::default() };
    let (shown, _) = apart.show(&samples, &vantage, &settings, Some(&HOLES), &Job::new()).unwrap();
    assert!(matches!(shown, WindowPicture::InMemory(_)));
}
