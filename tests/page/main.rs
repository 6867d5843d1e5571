//! An exported page in a browser: it opens from disk and asks for nothing, plays, turns, keeps its view in its address, looks like the
//! program's own pictures, and survives what browsers do to it. Where there is no Chromium this is said, and nothing is tested.

mod browser;
#[expect(dead_code, reason = "other tests need its scene")]
#[path = "../common/command.rs"]
mod command;
#[path = "../common/skip.rs"]
mod skip;
#[expect(dead_code, reason = "other tests need its capture")]
#[path = "../common/small_capture.rs"]
mod small_capture;

use std::path::{Path, PathBuf};

use glam::DQuat;
use overlook_engine::capture::TruthView;
use overlook_engine::color::srgb_from_linear;
use overlook_engine::page::escaped;
use overlook_lab::metrics::psnr_db;
use serde_json::Value;

use browser::Browser;
use command::{overlook, succeed};

/// Tests fail without a browser where this is set.
const REQUIRED: &str = "OVERLOOK_REQUIRE_BROWSER";

/// A browser with a window of a size; `None`, said aloud, where there is none.
fn browser(size: [u32; 2], more: &[&str]) -> Option<Browser> {
    let program = browser::chromium();
    if program.is_none() {
        skip::skip(Some(REQUIRED), "there is no chromium, in which pages are tested");
    }
    program.map(|program| Browser::open(program, size, more))
}

/// The page of the small capture, with a camera path and a text.
fn small_page(folder: &Path) -> PathBuf {
    let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/small_capture");
    let capture = capture.to_str().unwrap();
    succeed(overlook(folder, &["preprocess", capture, "--out", "scene.ovl"]));
    let path = format!("{capture}/novel/transforms.json");
    std::fs::write(folder.join("path.json"), one_view_a_frame(&path)).unwrap();
    let words = ["--title", "Small & moving", "--text", "Two paragraphs.\n\nOf text.", "--path", "path.json"];
    succeed(overlook(
        folder,
        &[&["export", "page", "scene.ovl", "--out", "scene.html"], words.as_slice()].concat(),
    ));
    folder.join("scene.html")
}

/// A manifest with the first view of each frame alone, as camera paths have them.
fn one_view_a_frame(manifest: &str) -> String {
    let mut views: Value = serde_json::from_str(&std::fs::read_to_string(manifest).unwrap()).unwrap();
    let mut seen = Vec::new();
    views["frames"].as_array_mut().unwrap().retain(|view| {
        let is_new = !seen.contains(&view["time"].to_string());
        seen.push(view["time"].to_string());
        is_new
    });
    views.to_string()
}

/// What the page says of itself.
fn told(browser: &mut Browser, key: &str) -> Value {
    browser.value(&format!("document.documentElement.dataset.{key}"))
}

fn load(browser: &mut Browser, page: &Path, fragment: &str) {
    browser.load(page, fragment);
    browser.wait_for("document.documentElement.dataset.loaded && !overlook.isAwake");
    assert_eq!(told(browser, "state"), "ready");
}

#[test]
fn a_page_opens_from_disk_asks_for_nothing_plays_turns_and_reopens_its_view() {
    let Some(mut browser) = browser([640, 480], &[]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = small_page(folder.path());
    load(&mut browser, &page, "");
    assert_eq!(browser.value("document.title"), "Small & moving");
    assert_eq!(browser.value("document.querySelectorAll('#text p').length"), 2);

    // Time passes while it plays, and stops.
    let before = browser.value("overlook.pictures").as_u64().unwrap();
    browser.press(" ", "Space");
    browser.wait_for(&format!("overlook.pictures > {before} + 4 && overlook.isPlaying"));
    browser.press(" ", "Space");
    browser.wait_for("!overlook.isPlaying && !overlook.isAwake");
    // The slider and the arrow keys choose frames.
    let choose = "(() => { const s = document.getElementById('frame'); s.value = 2; s.dispatchEvent(new Event('input')); })()";
    browser.value(choose);
    browser.wait_for(
        "document.documentElement.dataset.frame === String(overlook.scene.frames[2]) && !overlook.isAwake",
    );
    browser.press("ArrowRight", "ArrowRight");
    browser.wait_for("overlook.frame === 3 && !overlook.isAwake");

    // Dragging orbits: the pivot stays where it is, and as far away.
    let pivot = "JSON.stringify(overlook.view.pivot().map((part) => part.toFixed(6)))";
    let (pivot_before, pose_before) = (browser.value(pivot), browser.value("overlook.view.pose.join()"));
    browser.drag([300.0, 200.0], [80.0, 20.0]);
    browser.wait_for("!overlook.isAwake");
    assert_eq!(browser.value(pivot), pivot_before);
    assert_ne!(browser.value("overlook.view.pose.join()"), pose_before);

    // The address reopens the same picture, in another window too.
    let address = browser.value("location.hash");
    // What has the focus is no part of the picture.
    browser.value("document.activeElement.blur()");
    let shown = browser.screenshot();
    load(&mut browser, &page, address.as_str().unwrap());
    assert!(browser.screenshot() == shown, "the same address shows another picture");
    assert_eq!(browser.value("location.hash"), address);

    // The path moves the view, and a hand on the view leaves the path.
    browser.press("p", "KeyP");
    browser.wait_for("overlook.follows && overlook.isPlaying && overlook.pictures > 4");
    browser.drag([300.0, 200.0], [10.0, 0.0]);
    browser.wait_for("!overlook.follows");

    assert_eq!(browser.problems(), Vec::<String>::new());
    let own = |address: &String| {
        ["file://", "about:", "data:,", "blob:null/"].iter().any(|start| address.starts_with(start))
    };
    let others: Vec<String> = browser.requests().into_iter().filter(|address| !own(address)).collect();
    assert!(others.is_empty(), "{others:?}");
}

#[test]
fn a_page_within_another_document_as_in_a_notebook_plays_and_leaves_the_address_alone() {
    let Some(mut browser) = browser([640, 480], &[]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = std::fs::read_to_string(small_page(folder.path())).unwrap();
    let outer = folder.path().join("notebook.html");
    let frame = format!("<iframe srcdoc=\"{}\" width=\"600\" height=\"440\"></iframe>", escaped(&page));
    std::fs::write(&outer, frame).unwrap();
    browser.load(&outer, "");
    browser.wait_for("frames[0]?.document?.documentElement?.dataset?.loaded && !frames[0].overlook.isAwake");
    let address = browser.value("location.href");
    let pose = "frames[0].overlook.view.pose.join()";
    let before = browser.value(pose);
    browser.drag([300.0, 200.0], [80.0, 20.0]);
    browser.wait_for(&format!("{pose} !== '{}' && !frames[0].overlook.isAwake", before.as_str().unwrap()));
    assert_eq!(
        browser.value("[location.href, frames[0].location.href].join()"),
        format!("{},about:srcdoc", address.as_str().unwrap())
    );
    assert_eq!(browser.value("frames[0].document.getElementById('link').hidden"), true);
    assert_eq!(browser.problems(), Vec::<String>::new());
}

/// The address of a view through the lens that its true picture has.
fn address_of(view: &TruthView) -> String {
    let pose = view.camera.world_from_camera;
    let (at, turn, lens) = (pose.translation, DQuat::from_mat3(&pose.matrix3), view.camera.intrinsics);
    format!(
        "#view={},{},{},{},{},{},{},1&frame={}&lens={},{},{},{},{},{}&bare",
        at.x,
        at.y,
        at.z,
        turn.x,
        turn.y,
        turn.z,
        turn.w,
        view.frame_number,
        lens.width,
        lens.height,
        lens.fx,
        lens.fy,
        lens.cx,
        lens.cy
    )
}

fn colors(picture: &image::RgbImage) -> Vec<[f32; 3]> {
    picture.pixels().map(|pixel| pixel.0.map(|channel| f32::from(channel) / 255.0)).collect()
}

/// Pixels that are black in a picture and not in another.
fn black_beside(picture: &[[f32; 3]], other: &[[f32; 3]]) -> usize {
    let brightest = |color: &[f32; 3]| color.iter().fold(0.0_f32, |all, channel| all.max(*channel));
    picture.iter().zip(other).filter(|(a, b)| brightest(a) < 0.04 && brightest(b) > 0.1).count()
}

#[test]
fn from_new_viewpoints_a_page_is_within_half_a_decibel_of_the_programs_own_pictures_and_black_nowhere() {
    let views = small_capture::views();
    let lens = views[0].camera.intrinsics;
    let Some(mut browser) = browser([lens.width, lens.height], &[]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = small_page(folder.path());
    let manifest = format!("{}/assets/small_capture/novel", env!("CARGO_MANIFEST_DIR"));
    let render = ["render", "scene.ovl", "--views", &manifest, "--out", "pictures", "--backend", "cpu"];
    succeed(overlook(folder.path(), &render));
    let mut means = [0.0; 2];
    for view in &views {
        load(&mut browser, &page, &address_of(view));
        let truth = (view.truth.as_ref().unwrap())().unwrap();
        let truth: Vec<[f32; 3]> = truth
            .color
            .as_slice()
            .iter()
            .map(|color| color.map(|channel| srgb_from_linear(channel.to_f32()).min(1.0)))
            .collect();
        let own =
            image::open(folder.path().join("pictures").join(&view.file_path).with_extension("png")).unwrap();
        let pictures = [browser.screenshot(), own.into_rgb8()].map(|picture| colors(&picture));
        for (mean, picture) in means.iter_mut().zip(&pictures) {
            *mean += psnr_db(picture, &truth, 0..truth.len()).unwrap() / views.len() as f64;
        }
        assert_eq!(black_beside(&pictures[0], &pictures[1]), 0, "{}", view.file_path);
    }
    let [page, own] = means;
    assert!(page > own - 0.5 && page > 20.0, "the page has {page:.2} dB, the program {own:.2} dB");
}

#[test]
fn a_page_whose_device_takes_its_memory_back_shows_the_same_picture_again() {
    let Some(mut browser) = browser([320, 240], &[]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = small_page(folder.path());
    load(&mut browser, &page, "");
    let shown = browser.screenshot();
    let lose = "window.memory = overlook.renderer.canvas.gl.getExtension('WEBGL_lose_context'); memory.loseContext()";
    browser.value(&format!("(() => {{ {lose}; }})()"));
    browser.wait_for("overlook.renderer === null");
    // Nobody fails meanwhile.
    browser.press("ArrowRight", "ArrowRight");
    browser.press("ArrowLeft", "ArrowLeft");
    browser.value("memory.restoreContext()");
    browser.wait_for("document.documentElement.dataset.loaded && !overlook.isAwake");
    assert_eq!(told(&mut browser, "state"), "ready");
    assert!(browser.screenshot() == shown, "another picture came back");
    assert_eq!(browser.problems(), Vec::<String>::new());
}

#[test]
fn where_a_policy_refuses_workers_a_page_decodes_by_itself() {
    let Some(mut browser) = browser([320, 240], &[]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = small_page(folder.path());
    let text = std::fs::read_to_string(&page).unwrap();
    let policy = "<head>\n<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'self' 'unsafe-inline'\">";
    std::fs::write(&page, text.replacen("<head>", policy, 1)).unwrap();
    load(&mut browser, &page, "");
    assert!(browser.problems().iter().any(|problem| problem.contains("worker")), "no worker was refused");
}

#[test]
fn keys_are_heard_while_a_picture_at_rest_is_drawn() {
    let Some(mut browser) = browser([640, 480], &[]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = small_page(folder.path());
    load(&mut browser, &page, "");
    // The device stays busy with the first step until the key is heard. So even a fast one does not end the picture before it.
    let busy = "const { canvas } = overlook.renderer; const isIdle = canvas.isIdle.bind(canvas); canvas.isIdle = () => 'heard' in window && isIdle(); overlook.stepsAtATime = 1";
    let listen = "addEventListener('keydown', () => { window.heard = Boolean(overlook.refining); })";
    browser.value(&format!("(() => {{ {busy}; {listen}; overlook.move((view) => view.orbit(0.1, 0)); }})()"));
    browser.wait_for("overlook.refining");
    browser.press("ArrowUp", "ArrowUp");
    assert_eq!(browser.value("heard"), true, "the key was heard after the picture was drawn");
    browser.wait_for("!overlook.isAwake && overlook.drawn.isFinal");
}

#[test]
fn every_control_is_named_reached_by_keys_and_inside_windows_of_every_size() {
    let Some(mut browser) = browser([390, 844], &[]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = small_page(folder.path());
    load(&mut browser, &page, "");
    let controls = "[...document.querySelectorAll('button, input, select, summary, canvas')].filter((c) => c.offsetParent && !c.closest('dialog'))";
    let unnamed = format!(
        "{controls}.concat(document.querySelector('canvas')).filter((c) => !(c.ariaLabel || c.labels?.[0]?.textContent.trim() || c.textContent.trim())).map((c) => c.outerHTML).join()"
    );
    assert_eq!(browser.value(&unnamed), "");
    for size in [[390, 844], [320, 568], [844, 390], [1920, 1080]] {
        browser.resize(size);
        browser.wait_for("!overlook.isAwake");
        let outside = format!(
            "{controls}.filter((c) => {{ const b = c.getBoundingClientRect(); return b.left < 0 || b.top < 0 || b.right > innerWidth || b.bottom > innerHeight; }}).map((c) => c.id).join()"
        );
        assert_eq!(browser.value(&outside), "", "{size:?}");
        let over = format!(
            "{controls}.flatMap((a, nth, all) => all.slice(nth + 1).filter((b) => {{ const [p, q] = [a.getBoundingClientRect(), b.getBoundingClientRect()]; return p.left < q.right - 1 && q.left < p.right - 1 && p.top < q.bottom - 1 && q.top < p.bottom - 1; }}).map((b) => `${{a.id}} and ${{b.id}}`)).join()"
        );
        assert_eq!(browser.value(&over), "", "{size:?}");
    }
    // Tab goes through all of them.
    let reached = "(() => { const seen = new Set(); for (const c of document.querySelectorAll('#bar button, #bar input, #bar select')) { if (!c.offsetParent) continue; c.focus(); seen.add(document.activeElement === c); } return seen.has(true) && !seen.has(false); })()";
    assert_eq!(browser.value(reached), true);
    browser.press("?", "Slash");
    browser.wait_for("document.getElementById('keys').open");
    browser.press("Escape", "Escape");
    browser.wait_for("!document.getElementById('keys').open");
}

#[test]
fn without_webgl2_and_where_the_file_is_damaged_the_page_says_so() {
    let Some(mut browser) = browser([640, 480], &["--disable-3d-apis"]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = small_page(folder.path());
    browser.load(&page, "");
    browser.wait_for("document.documentElement.dataset.state === 'failed'");
    let message = browser.value("document.getElementById('message').textContent");
    assert!(message.as_str().unwrap().contains("no WebGL2"), "{message}");
    drop(browser);

    let Some(mut browser) = self::browser([640, 480], &[]) else { return };
    let text = std::fs::read_to_string(&page).unwrap();
    let at = text.find("class=\"chunk\">").unwrap() + 200;
    let cut = folder.path().join("cut.html");
    std::fs::write(&cut, format!("{}AAAA{}", &text[..at], &text[at + 4..])).unwrap();
    browser.load(&cut, "");
    browser.wait_for("document.documentElement.dataset.state === 'failed'");
    let message = browser.value("document.getElementById('message').textContent");
    assert!(message.as_str().unwrap().contains("cannot be shown"), "{message}");
}
