//! A world in which something bad is tried: it must be refused and leave nothing behind.

use std::fs;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::Output;

use bus::run::{RunContext, SHM_DIR};

use super::{SMALL, World, stderr};

/// A world with one scene, `good`, and an output folder in which nothing may be left.
pub struct Room {
    world: World,
    pub good: PathBuf,
    pub out: PathBuf,
}

impl Deref for Room {
    type Target = World;
    fn deref(&self) -> &World {
        &self.world
    }
}

impl Room {
    pub fn new() -> Self {
        let world = World::new();
        let (good, out) = (world.file("good.toml", SMALL), world.path("out"));
        Self { world, good, out }
    }

    /// [`SMALL`] on a file of this world.
    pub fn scene_on(&self, volume: &str) -> PathBuf {
        let source = format!("source = {volume:?}");
        self.file("scene.toml", &SMALL.replace("source = \"phantom\"", &source))
    }

    /// A run of half a second.
    pub fn run(&self, scene: &Path, more: &[&str]) -> Output {
        let (scene, out) = (scene.to_str().unwrap(), self.out.to_str().unwrap());
        let all = ["run", scene, "--headless", "--out", out, "--for", "500ms"];
        self.output("pilot", &[&all, more].concat())
    }

    pub fn run_is_refused(&self, scene: &Path, more: &[&str], words: &str) {
        self.is_refused(&self.run(scene, more), words);
    }

    pub fn good_run(&self, more: &[&str]) {
        self.navigate(&self.good, &self.out, &[&["--for", "300ms"], more].concat());
    }

    /// One paragraph on stderr holds all `words`, between bars; neither files, memory nor processes are left.
    pub fn is_refused(&self, output: &Output, words: &str) {
        let (said, code) = (stderr(output), output.status.code());
        assert!(code.is_some_and(|code| code != 0), "{:?}: {said}", output.status);
        assert!(!said.contains("panicked"), "{said}");
        let is_it = |line: &&str| line.contains("error: ") && words.split(" | ").all(|word| line.contains(word));
        let paragraphs = said.lines().filter(is_it).count();
        assert_eq!(paragraphs, 1, "paragraphs with {words:?} in:\n{said}");
        let files: Vec<_> = fs::read_dir(&self.out).into_iter().flatten().collect();
        assert!(files.is_empty(), "{files:?} after {words:?}");
        self.nothing_is_left();
    }

    pub fn nothing_is_left(&self) {
        assert_eq!(self.left(), [""; 0]);
    }

    /// The command lines of this world's processes, and the names of its shared memory.
    pub fn left(&self) -> Vec<String> {
        // Each process of a world has that world's folder on its command line.
        let mark = self.path("").to_string_lossy().into_owned();
        let commands = fs::read_dir("/proc").unwrap().flatten();
        let commands = commands.filter_map(|entry| fs::read(entry.path().join("cmdline")).ok());
        let commands = commands.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        let commands = commands.filter(|command| command.contains(&mark));
        let prefix = RunContext::new(&self.run_dir("default"), 0).unwrap().folder_prefix();
        let shared = fs::read_dir(SHM_DIR).unwrap().flatten();
        let shared = shared.map(|entry| entry.file_name().to_string_lossy().into_owned());
        let shared = shared.filter(|name| name.starts_with(&prefix));
        commands.chain(shared).collect()
    }
}
