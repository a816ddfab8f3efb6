//! How a person has arranged the screen, in a file of the run: a window that was killed comes back as it was.

use std::fs;
use std::path::{Path, PathBuf};

use scene::Scene;

use crate::screen::{Look, Views};

/// A view's name and some room.
const MOST_BYTES: u64 = 4096;

fn path(run_dir: &Path, window: &str) -> PathBuf {
    run_dir.join(format!("{window}.look"))
}

/// The arrangement in the file; that of a new window where there is none, or one of another scene.
pub fn read(run_dir: &Path, window: &str, scene: &Scene) -> Look {
    let text = scene::file::read_text(&path(run_dir, window), MOST_BYTES).unwrap_or_default();
    let value = |key: &str| {
        text.lines()
            .find_map(|line| line.strip_prefix(key)?.strip_prefix(" = "))
    };
    let of_name = |name: &str| scene.views.iter().position(|view| view.name == name);
    let of_word = |word: &str| Views::ALL.into_iter().find(|views| views.word() == word);
    Look {
        enlarged: value("enlarged").and_then(of_name),
        views: value("views").and_then(of_word).unwrap_or_default(),
        steps: value("steps") == Some("true"),
        ..Look::default()
    }
}

/// Keeps it.
///
/// # Errors
/// In words, where the file cannot be written; the window goes on.
pub fn write(run_dir: &Path, window: &str, look: &Look, scene: &Scene) -> Result<(), String> {
    let name = look
        .enlarged
        .and_then(|view| scene.views.get(view))
        .map(|view| view.name.as_str());
    let enlarged = name.map(|name| format!("enlarged = {name}\n")).unwrap_or_default();
    let text = format!("{enlarged}views = {}\nsteps = {}\n", look.views.word(), look.steps);
    let path = path(run_dir, window);
    // Whole or not at all: a window may be killed while it writes.
    let aside = path.with_extension("look.new");
    let written = fs::write(&aside, text).and_then(|()| fs::rename(&aside, &path));
    written.map_err(|error| format!("{}: {error}", path.display()))
}
