//! Manual pages and completions of every program: `cargo bench --bench manuals -- FOLDER` writes them below FOLDER, as packages
//! want them.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a chore that fails")]

#[path = "../tests/support/programs.rs"]
mod programs;

use std::fs;
use std::path::{Path, PathBuf};

use clap::Command;
use clap_complete::{Shell, generate_to};

fn main() {
    let folder = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let folder = PathBuf::from(folder.expect("the folder to write to"));
    let shells = [
        (Shell::Bash, "bash-completion/completions"),
        (Shell::Zsh, "zsh/site-functions"),
        (Shell::Fish, "fish/vendor_completions.d"),
    ];
    for program in programs::all() {
        let name = program.get_name().to_owned();
        manual(&program, &name, &folder.join("man/man1"));
        for (shell, place) in shells {
            let place = folder.join(place);
            fs::create_dir_all(&place).unwrap();
            generate_to(shell, &mut program.clone(), &name, &place).unwrap();
        }
    }
}

/// The page of a command and those of its subcommands, `calib-pivot.1` for instance.
fn manual(command: &Command, name: &str, folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    let mut page = Vec::new();
    // A command keeps its name as a constant; this program soon ends.
    let page_name: &'static str = Box::leak(name.to_owned().into_boxed_str());
    let named = command.clone().name(page_name);
    clap_mangen::Man::new(named).render(&mut page).unwrap();
    fs::write(folder.join(format!("{name}.1")), page).unwrap();
    for below in command.get_subcommands().filter(|below| !below.is_hide_set()) {
        manual(below, &format!("{name}-{}", below.get_name()), folder);
    }
}
