//! Headless Chromium, driven over a pair of pipes by its own protocol (Chrome `DevTools` Protocol), without any library of its own.

use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use base64::Engine as _;
use serde_json::{Value, json};

/// What waits longer has failed.
const PATIENCE: Duration = Duration::from_mins(2);

/// The browser that Debian calls `chromium`, if there is one.
pub(crate) fn chromium() -> Option<&'static str> {
    let is_there = |name: &&str| {
        let told = Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        told.is_ok_and(|status| status.success())
    };
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find(is_there)
}

/// A window of a browser of its own, which ends with it.
pub(crate) struct Browser {
    child: Child,
    _profile: tempfile::TempDir,
    commands: File,
    messages: Receiver<Value>,
    session: Option<String>,
    next: u64,
    events: Vec<Value>,
}

impl Browser {
    /// A window of `size` without decorations; `more` are further arguments.
    pub(crate) fn open(program: &str, size: [u32; 2], more: &[&str]) -> Self {
        let profile = tempfile::tempdir().unwrap();
        let pipes = ["commands", "messages"].map(|name| profile.path().join(name));
        for pipe in &pipes {
            assert!(Command::new("mkfifo").arg(pipe).status().unwrap().success());
        }
        let [commands, messages] = pipes;
        // The shell opens the pipes as the descriptors 3 and 4, which the browser expects.
        let child = Command::new("sh")
            .args(["-c", "in=$1; out=$2; shift 2; exec \"$@\" 3<\"$in\" 4>\"$out\"", "sh"])
            .args([&commands, &messages])
            .arg(program)
            .args([
                "--headless=new",
                "--no-sandbox",
                "--no-first-run",
                "--hide-scrollbars",
                "--remote-debugging-pipe",
            ])
            .args([
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
                "--disable-background-networking",
            ])
            .arg(format!("--user-data-dir={}", profile.path().join("profile").display()))
            .args(more)
            .arg("about:blank")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let commands = File::options().write(true).open(commands).unwrap();
        let messages = listen(File::open(messages).unwrap());
        let mut browser =
            Self { child, _profile: profile, commands, messages, session: None, next: 0, events: Vec::new() };
        let targets = browser.call("Target.getTargets", json!({}));
        let page = targets["targetInfos"].as_array().unwrap().iter().find(|target| target["type"] == "page");
        let id = page.unwrap()["targetId"].clone();
        let attached = browser.call("Target.attachToTarget", json!({ "targetId": id, "flatten": true }));
        browser.session = Some(attached["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Network", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser.resize(size);
        browser
    }

    pub(crate) fn resize(&mut self, [width, height]: [u32; 2]) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Calls a method and gives its result.
    #[expect(clippy::needless_pass_by_value, reason = "callers write the parameters where they call")]
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.next += 1;
        let mut message = json!({ "id": self.next, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        self.commands.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let answer =
                self.messages.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("no answer to {method}"));
            if answer["id"] == self.next {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    /// Loads a file; `fragment` begins with `#` or is empty.
    pub(crate) fn load(&mut self, file: &Path, fragment: &str) {
        // Another document, even if the address differs by its fragment alone.
        self.call("Page.navigate", json!({ "url": "about:blank" }));
        self.call("Page.navigate", json!({ "url": format!("file://{}{fragment}", file.display()) }));
    }

    /// The value of an expression; an exception fails the test.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let result = self.call("Runtime.evaluate", parameters);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {}", result["exceptionDetails"]);
        result["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub(crate) fn wait_for(&mut self, expression: &str) {
        let start = Instant::now();
        // The document may not be there yet.
        while self.value(&format!("Boolean(document.documentElement && ({expression}))")) != true {
            assert!(start.elapsed() < PATIENCE, "{expression} never was; {:?}", self.problems());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// What is on the screen.
    pub(crate) fn screenshot(&mut self) -> image::RgbImage {
        let shot = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let png = base64::engine::general_purpose::STANDARD.decode(shot["data"].as_str().unwrap()).unwrap();
        image::load_from_memory(&png).unwrap().into_rgb8()
    }

    /// Exceptions, messages on the console, and what the browser logged.
    pub(crate) fn problems(&self) -> Vec<String> {
        let told = ["Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"];
        let events = self.events.iter().filter(|event| told.iter().any(|method| event["method"] == *method));
        events.map(ToString::to_string).collect()
    }

    /// The addresses that were asked for.
    pub(crate) fn requests(&self) -> Vec<String> {
        let asked = self.events.iter().filter(|event| event["method"] == "Network.requestWillBeSent");
        asked.map(|event| event["params"]["request"]["url"].as_str().unwrap().to_owned()).collect()
    }

    /// Drags from a place in the window by a way.
    pub(crate) fn drag(&mut self, [x, y]: [f64; 2], [across, down]: [f64; 2]) {
        let mut send = |kind: &str, share: f64, buttons: u32| {
            let event = json!({
                "type": kind, "x": x + across * share, "y": y + down * share, "button": "left", "buttons": buttons, "clickCount": 1,
            });
            self.call("Input.dispatchMouseEvent", event);
        };
        send("mousePressed", 0.0, 1);
        send("mouseMoved", 0.5, 1);
        send("mouseMoved", 1.0, 1);
        send("mouseReleased", 1.0, 0);
    }

    /// Presses and releases a key, by its name and its place on the keyboard.
    pub(crate) fn press(&mut self, key: &str, code: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        // What the browser itself answers to goes by this number.
        let number = if key == "Escape" { 27 } else { 0 };
        for (kind, text) in [("keyDown", text), ("keyUp", "")] {
            let event = json!({ "type": kind, "key": key, "code": code, "text": text, "windowsVirtualKeyCode": number });
            self.call("Input.dispatchKeyEvent", event);
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The messages of a pipe, each ended by a zero.
fn listen(mut pipe: File) -> Receiver<Value> {
    /// Messages that may wait; the pipe holds the others back.
    const WAITING: usize = 1 << 16;
    let (sender, receiver) = sync_channel(WAITING);
    let listen = move || {
        let (mut waiting, mut piece) = (Vec::new(), vec![0; 1 << 16]);
        while let Ok(count @ 1..) = pipe.read(&mut piece) {
            waiting.extend_from_slice(&piece[..count]);
            while let Some(end) = waiting.iter().position(|byte| *byte == 0) {
                let message: Vec<u8> = waiting.drain(..=end).collect();
                let Ok(message) = serde_json::from_slice(&message[..end]) else { return };
                if sender.send(message).is_err() {
                    return;
                }
            }
        }
    };
    std::thread::Builder::new().name("browser messages".to_owned()).spawn(listen).unwrap();
    receiver
}
