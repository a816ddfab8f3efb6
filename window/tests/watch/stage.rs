//! An X server of its own, a run's folder, the window and its watcher as processes.

use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bus::Bus;
use bus::clock::monotonic_ns;
use bus::message::Heartbeat;
use bus::port::Subscriber;
use bus::run::{RunContext, RunLock};
use bus::topic::HEARTBEAT;
use rustix::process::{Pid, Signal, kill_process};
use x11rb::connection::Connection;
use x11rb::protocol::randr::{ConnectionExt as _, Rotation};
use x11rb::protocol::xproto::{ConnectionExt as _, CreateWindowAux, ImageFormat, Window, WindowClass};
use x11rb::rust_connection::RustConnection;

/// In the environment of a process that a stage has started: its part, and the run's folder.
pub(crate) const PART: &str = "TROCAR_TEST_PART";
pub(crate) const RUN_DIR: &str = "TROCAR_TEST_RUN";
/// The window on the screen: left, top, width, height.
pub(crate) const WINDOW: (i16, i16, u16, u16) = (60, 40, 640, 480);
/// Of the window, on the screen: far from its cell, and from the words of a cover.
const CORNER: [i16; 2] = [695, 515];
pub(crate) const SQUARE: u32 = 4;
pub(crate) const CELL: [u32; 2] = [40, 30];
const XVFB: &str = "/usr/bin/Xvfb";
const WATCHDOG: Duration = Duration::from_secs(120);
const SCENE: &str = r#"
[volume]
source = "phantom"
[limits]
stale_ms = 200.0
[[views]]
name = "axial-global"
plane = "axial"
extent = "global"
"#;

/// One stage at a time: what they show is a matter of tenths of a second.
static ONE: Mutex<()> = Mutex::new(());

pub(crate) struct Stage {
    run: RunContext,
    bus: Option<Bus>,
    heartbeats: Option<Subscriber<Heartbeat>>,
    heard: Option<Heartbeat>,
    server: Child,
    display: String,
    eye: Option<RustConnection>,
    window: Option<(Child, ChildStdin)>,
    watcher: Option<Child>,
    _lock: RunLock,
    _folder: tempfile::TempDir,
    _one: MutexGuard<'static, ()>,
}

/// A server with a window and its watcher; `None`, with a word, where there is no Xvfb.
pub(crate) fn stage() -> Option<Stage> {
    if !PathBuf::from(XVFB).exists() {
        println!("skipped: there is no {XVFB} (Debian: xvfb)");
        return None;
    }
    let one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::Builder::new().prefix("tw").tempdir_in("/tmp").unwrap();
    let dir = folder.path().join("r").join("w");
    let lock = RunLock::acquire(&dir).unwrap();
    let run = RunContext::new(&dir, monotonic_ns()).unwrap();
    run.store_scene(SCENE).unwrap();
    run.store().unwrap();
    let bus = Bus::keep(&run).unwrap();
    let heartbeats = Subscriber::open(&bus, &HEARTBEAT, "window-watch", 1).unwrap();
    let (server, display) = serve(None);
    let mut stage = Stage {
        run,
        bus: Some(bus),
        heartbeats: Some(heartbeats),
        heard: None,
        server,
        eye: Some(RustConnection::connect(Some(&display)).unwrap().0),
        display,
        window: None,
        watcher: None,
        _lock: lock,
        _folder: folder,
        _one: one,
    };
    stage.start_window();
    stage.start_watcher();
    Some(stage)
}

/// Starts a server, as this display or as one that is free.
fn serve(display: Option<&str>) -> (Child, String) {
    let mut command = Command::new(XVFB);
    command.args(display);
    command.args([
        "-displayfd",
        "1",
        "-screen",
        "0",
        "1280x800x24",
        "-nolisten",
        "tcp",
        "-noreset",
    ]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut line)
        .unwrap();
    (child, format!(":{}", line.trim()))
}

/// The watcher, in a process that a stage has started.
pub(crate) fn watch() {
    let dir = std::env::var(RUN_DIR).unwrap();
    window::watch::cli::main_from(&["window-watch", "--run-dir", &dir]);
}

impl Stage {
    fn part(&self, part: &str) -> Command {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command
            .args(["a_part_on_the_stage", "--exact", "--nocapture"])
            .env(PART, part)
            .env(RUN_DIR, &self.run.dir)
            .env("DISPLAY", &self.display)
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        command
    }

    pub(crate) fn start_window(&mut self) {
        self.end_window();
        let mut child = self.part("window").stdin(Stdio::piped()).spawn().unwrap();
        let orders = child.stdin.take().unwrap();
        self.window = Some((child, orders));
    }

    pub(crate) fn start_watcher(&mut self) {
        self.watcher = Some(self.part("watcher").spawn().unwrap());
    }

    pub(crate) fn kill_watcher(&mut self) {
        let mut watcher = self.watcher.take().unwrap();
        watcher.kill().unwrap();
        watcher.wait().unwrap();
    }

    /// Gives the screen another size, as where monitors come and go.
    pub(crate) fn resize_screen(&self, [width, height]: [u16; 2]) {
        let eye = self.eye.as_ref().unwrap();
        let root = eye.setup().roots[0].root;
        let found = eye.randr_get_screen_resources_current(root).unwrap().reply().unwrap();
        for crtc in found.crtcs {
            let off = eye.randr_set_crtc_config(crtc, 0, found.config_timestamp, 0, 0, 0, Rotation::ROTATE0, &[]);
            off.unwrap().reply().unwrap();
        }
        let resized = eye.randr_set_screen_size(root, width, height, width.into(), height.into());
        resized.unwrap().check().unwrap();
    }

    fn end_window(&mut self) {
        if let Some((mut child, _)) = self.window.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }

    /// Tells the window what to do from now on.
    pub(crate) fn order(&mut self, order: &str) {
        let (_, orders) = self.window.as_mut().unwrap();
        writeln!(orders, "{order}").unwrap();
    }

    pub(crate) fn signal(&mut self, signal: Signal) {
        let (child, _) = self.window.as_ref().unwrap();
        kill_process(Pid::from_child(child), signal).unwrap();
    }

    pub(crate) fn signal_server(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.server), signal).unwrap();
    }

    pub(crate) fn kill_server(&mut self) {
        self.eye = None;
        self.server.kill().unwrap();
        self.server.wait().unwrap();
    }

    /// The same display once more.
    pub(crate) fn start_server(&mut self) {
        let number = self.display.trim_start_matches(':');
        // What a killed server leaves behind.
        let _ = std::fs::remove_file(format!("/tmp/.X{number}-lock"));
        let _ = std::fs::remove_file(format!("/tmp/.X11-unix/X{number}"));
        (self.server, _) = serve(Some(&self.display));
        self.eye = Some(RustConnection::connect(Some(&self.display)).unwrap().0);
    }

    /// Process of the watcher.
    pub(crate) fn watcher_pid(&self) -> u32 {
        self.watcher.as_ref().unwrap().id()
    }

    /// The watcher's last sign of life.
    pub(crate) fn heard(&mut self) -> Option<Heartbeat> {
        self.bus.as_ref().unwrap().remove_dead_processes();
        let newest = self.heartbeats.as_ref().unwrap().newest().unwrap();
        self.heard = newest.or(self.heard);
        self.heard
    }

    fn wait(&mut self, what: &str, mut ready: impl FnMut(&mut Self) -> bool) {
        let began = Instant::now();
        while !ready(self) {
            let note = self.heard.map(|heard| heard.note_text());
            assert!(
                began.elapsed() < WATCHDOG,
                "waited for {what}; the watcher says {note:?}"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until the watcher says so in its sign of life.
    pub(crate) fn wait_for_note(&mut self, words: &str) {
        self.wait(words, |stage| {
            stage.heard().is_some_and(|heard| heard.note_text().contains(words))
        });
    }

    /// When the watcher read a picture, behind that moment, ns.
    pub(crate) fn wait_for_reading(&mut self, behind_ns: i64) -> i64 {
        self.wait("a reading", |stage| {
            stage.heard().is_some_and(|beat| beat.t_painted_ns > behind_ns)
        });
        self.heard().map_or(0, |beat| beat.t_painted_ns)
    }

    /// Waits until the window is red, or is not.
    pub(crate) fn wait_red(&mut self, red: bool) {
        self.wait(if red { "red" } else { "no red" }, |stage| stage.is_red() == red);
    }

    pub(crate) fn is_red(&self) -> bool {
        let picture::Rgb(r, g, b) = picture::palette::ALARM;
        self.pixel(CORNER) == [b, g, r]
    }

    /// Waits until what `overlap` has put there is covered itself.
    pub(crate) fn wait_no_blue_at(&mut self, at: [i16; 2]) {
        self.wait("the cover above the other window", |stage| {
            stage.pixel(at) != [255, 0, 0]
        });
    }

    fn pixel(&self, [x, y]: [i16; 2]) -> [u8; 3] {
        let eye = self.eye.as_ref().unwrap();
        let root = eye.setup().roots[0].root;
        let image = eye.get_image(ImageFormat::Z_PIXMAP, root, x, y, 1, 1, u32::MAX);
        let image = image.unwrap().reply().unwrap();
        [image.data[0], image.data[1], image.data[2]]
    }

    /// Somebody else's blue window above all that is there.
    pub(crate) fn overlap(&mut self, [x, y, width, height]: [i16; 4]) -> Window {
        let eye = self.eye.as_ref().unwrap();
        let (root, window) = (eye.setup().roots[0].root, eye.generate_id().unwrap());
        let values = CreateWindowAux::new().background_pixel(0xff).override_redirect(1);
        let (class, size) = (WindowClass::INPUT_OUTPUT, [width as u16, height as u16]);
        eye.create_window(0, window, root, x, y, size[0], size[1], 0, class, 0, &values)
            .unwrap();
        eye.map_window(window).unwrap().check().unwrap();
        window
    }

    pub(crate) fn remove(&mut self, window: Window) {
        let eye = self.eye.as_ref().unwrap();
        eye.destroy_window(window).unwrap().check().unwrap();
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.end_window();
        for child in self.watcher.iter_mut().chain([&mut self.server]) {
            let _ = child.kill();
            let _ = child.wait();
        }
        (self.heartbeats, self.bus) = (None, None);
        self.run.sweep();
    }
}
