use super::*;
use crate::demo::DemoSpec;
use crate::render::gpu::opened;
use crate::simd::skip::skip;

fn scene() -> (Arc<SampleSet>, Vantage) {
    crate::render::tests::scene(DemoSpec::new("orrery").cameras(2).size((48, 36)), 0)
}

fn settings(backend: Backend) -> RenderSettings {
    RenderSettings { backend, ..RenderSettings::default() }
}

fn any_adapter() -> Option<GpuRenderer> {
    opened(GpuRenderer::new(AdapterChoice::Any))
}

#[test]
fn the_cpu_paints_where_it_is_asked_for_and_where_there_is_no_graphics_card() {
    let (samples, vantage) = scene();
    let mut renderer = Renderer::new();
    renderer.render(&samples, &vantage, &settings(Backend::Cpu), &Job::new()).unwrap();
    assert_eq!(renderer.painter(), Some(&Painter::cpu()));
    let mut renderer = Renderer { adapter: Adapter::NoCard, ..Renderer::default() };
    renderer.render(&samples, &vantage, &settings(Backend::Auto), &Job::new()).unwrap();
    assert_eq!((renderer.painter(), renderer.notice()), (Some(&Painter::cpu()), None));
}

#[test]
fn a_software_adapter_is_never_chosen_by_itself() {
    let Some(gpu) = any_adapter() else { return };
    if !gpu.context.is_software() {
        skip(None, &format!("{} is no software adapter", gpu.adapter_name()));
        return;
    }
    let (samples, vantage) = scene();
    let mut renderer = Renderer { adapter: Adapter::Open(Box::new(gpu)), ..Renderer::default() };
    renderer.render(&samples, &vantage, &settings(Backend::Auto), &Job::new()).unwrap();
    assert_eq!(renderer.painter(), Some(&Painter::cpu()));
}

#[test]
fn a_notice_goes_when_the_cpu_paints_by_choice() {
    let (samples, vantage) = scene();
    let why = || Adapter::Missing("there is none".to_owned());
    let mut renderer = Renderer { adapter: why(), ..Renderer::default() };
    let mut notice = |backend| {
        renderer.render(&samples, &vantage, &settings(backend), &Job::new()).unwrap();
        renderer.notice().map(str::to_owned)
    };
    assert_eq!(notice(Backend::Gpu).as_deref(), Some("the CPU renders: there is none"));
    assert_eq!(notice(Backend::Auto), None);
    // A card that was found to be faster, and is gone, is missed.
    let faster = HashMap::from([(settings(Backend::Auto).kernel, Backend::Gpu)]);
    let mut renderer = Renderer { adapter: why(), faster, ..Renderer::default() };
    renderer.render(&samples, &vantage, &settings(Backend::Auto), &Job::new()).unwrap();
    assert!(renderer.notice().is_some());
}

#[test]
fn the_cpu_takes_over_with_a_notice_when_the_adapter_is_lost() {
    let Some(gpu) = any_adapter() else { return };
    let (samples, vantage) = scene();
    let mut renderer = Renderer { adapter: Adapter::Open(Box::new(gpu)), ..Renderer::default() };
    let paint = |renderer: &mut Renderer| {
        renderer.render(&samples, &vantage, &settings(Backend::Gpu), &Job::new()).unwrap().0
    };
    paint(&mut renderer);
    assert_eq!(renderer.painter().unwrap().backend, Backend::Gpu);
    assert_eq!(renderer.notice(), None);
    let Adapter::Open(gpu) = &renderer.adapter else { panic!("the adapter is gone") };
    gpu.context.device.destroy();
    for _ in 0..2 {
        let picture = paint(&mut renderer);
        assert_eq!(renderer.painter(), Some(&Painter::cpu()));
        assert!(renderer.notice().unwrap().starts_with("the CPU renders: "), "{:?}", renderer.notice());
        assert!(picture.holes() < 48 * 36);
    }
    assert!(matches!(renderer.adapter, Adapter::Missing(_)));
}

#[test]
fn samples_are_counted_once_where_edges_are_rendered_again() {
    let (samples, vantage) = scene();
    let vantage = Vantage { camera: samples.cameras[0].clone(), ..vantage };
    let stats = |antialias| {
        let settings = RenderSettings { antialias, ..settings(Backend::Cpu) };
        let again = supersamples_edges(&RecordedRates::of(&samples, &vantage), &vantage, &settings);
        assert_eq!(again, antialias == Antialias::Supersampled);
        Renderer::new().render(&samples, &vantage, &settings, &Job::new()).unwrap().1
    };
    let [once, twice] = [Antialias::Off, Antialias::Supersampled].map(stats);
    assert!(once.samples > 0 && once.samples == twice.samples, "{once:?} {twice:?}");
}
