//! What a user installs: a tarball and a Debian package.
//!
//! ```text
//! trocar-VERSION/bin                    the programs; each finds its siblings in its own folder
//! trocar-VERSION/share/trocar/config    the scenes, which `pilot run config/demo.toml` finds from anywhere
//! trocar-VERSION/share/trocar/proto     the schemas of recordings
//! trocar-VERSION/share/doc/trocar       README, changes, licences, the book, the list of software of others
//! trocar-VERSION/share/man ...          manual pages, completions
//! ```
//!
//! The package puts the same below /opt/trocar, with links from where a system looks for programs, pages and completions.

use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::shell::{cargo, program, quietly, root, run, said, say, target};
use crate::software;

const PROGRAMS: [&str; 13] = [
    "pilot",
    "volume-loader",
    "tracker-proc",
    "localizer-proc",
    "slice-view-proc",
    "recorder",
    "gateway-proc",
    "tissue-proc",
    "window",
    "window-watch",
    "calib",
    "simulate",
    "study",
];
/// Files of the project that go along.
const PAPERS: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT"];

/// Builds all of it.
///
/// # Errors
/// [`Failure::Usage`], [`Failure::Start`], [`Failure::Ended`], [`Failure::File`].
pub(crate) fn dist(arguments: &[String]) -> Result<(), Failure> {
    if let Some(first) = arguments.first() {
        return Err(Failure::Usage(format!(
            "`cargo xtask dist` takes no arguments, found {first:?}"
        )));
    }
    run(cargo(&["build", "--release", "--bins"]).args(optimised()))?;
    let folder = target().join("dist");
    let stage = folder.join(format!("trocar-{}", version()));
    // What an earlier version left must not be packed.
    remove(&stage)?;
    programs(&stage.join("bin"))?;
    let share = stage.join("share");
    copy_folder(&root().join("config"), &share.join("trocar/config"))?;
    copy_folder(&root().join("recorder/proto"), &share.join("trocar/proto"))?;
    papers(&share.join("doc/trocar"))?;
    run(cargo(&["bench", "--package", "trocar", "--bench", "manuals", "--"]).arg(&share))?;
    let tarball = packed(&folder, &stage)?;
    say(&format!("tarball: {}", tarball.display()));
    match said(&mut program("dpkg-deb", &["--version"])) {
        Ok(_) => say(&format!("Debian package: {}", package(&folder, &stage)?.display())),
        Err(why) => say(&format!("no Debian package: {why}")),
    }
    Ok(())
}

/// What a cold build leaves without optimisation (Cargo.toml says why) is optimised in what is installed.
fn optimised() -> impl Iterator<Item = String> {
    let crates = ["naga", "wgpu", "wgpu-core", "wgpu-hal", "ash"];
    let level = |name| format!("--config=profile.release.package.{name}.opt-level=3");
    crates.into_iter().map(level)
}

/// All crates of the workspace have one version, this one's.
fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// Without debug information, which is many times the program: a panic still says its line, a backtrace names functions only.
fn programs(folder: &Path) -> Result<(), Failure> {
    make(folder)?;
    for name in PROGRAMS {
        let (from, to) = (target().join("release").join(name), folder.join(name));
        copy(&from, &to)?;
        let stripped = quietly(program("strip", &["--strip-debug"]).arg(&to));
        if let Err(why) = stripped {
            say(&format!("{name} keeps its debug information: {why}"));
        }
    }
    Ok(())
}

fn papers(folder: &Path) -> Result<(), Failure> {
    make(folder)?;
    for paper in PAPERS {
        copy(&root().join(paper), &folder.join(paper))?;
    }
    software::write(folder)?;
    let book = folder.join("book");
    let built = quietly(program("mdbook", &["build", "docs", "--dest-dir"]).arg(&book));
    if let Err(why) = built {
        say(&format!("the book goes along as its pages, not as HTML: {why}"));
        remove(&book)?;
        copy_folder(&root().join("docs"), &book)?;
    }
    Ok(())
}

/// The same bytes for the same files: no times, no names of who built it.
fn packed(folder: &Path, stage: &Path) -> Result<PathBuf, Failure> {
    let name = stage.file_name().unwrap_or_default();
    let tarball = folder.join(format!("trocar-{}-{}.tar.gz", version(), std::env::consts::ARCH));
    let options = [
        "--sort=name",
        "--mtime=@0",
        "--owner=0",
        "--group=0",
        "--numeric-owner",
        "-czf",
    ];
    let mut tar = program("tar", &options);
    run(tar.arg(&tarball).arg("-C").arg(folder).arg(name))?;
    Ok(tarball)
}

/// A package of the Debian kind.
fn package(folder: &Path, stage: &Path) -> Result<PathBuf, Failure> {
    let root = folder.join("deb");
    remove(&root)?;
    let opt = root.join("opt/trocar");
    copy_folder(stage, &opt)?;
    links(&root)?;
    let architecture = said(&mut program("dpkg", &["--print-architecture"]))?;
    let notes = root.join("DEBIAN/control");
    make(&root.join("DEBIAN"))?;
    fs::write(&notes, control(architecture.trim())?).map_err(|e| Failure::file(&notes, e))?;
    let path = folder.join(format!("trocar_{}_{}.deb", version(), architecture.trim()));
    run(program("dpkg-deb", &["--root-owner-group", "--build"])
        .arg(&root)
        .arg(&path))?;
    Ok(path)
}

fn control(architecture: &str) -> Result<String, Failure> {
    // As new as where it was built: an older one may lack what the programs ask for.
    let libc = said(&mut program("getconf", &["GNU_LIBC_VERSION"]))?;
    let libc = libc.trim().rsplit(' ').next().unwrap_or_default();
    Ok(format!(
        "Package: trocar\n\
         Version: {}\n\
         Architecture: {architecture}\n\
         Maintainer: the Trocar project\n\
         Section: science\n\
         Priority: optional\n\
         Depends: libc6 (>= {libc}), libgcc-s1\n\
         Suggests: libvulkan1\n\
         Description: surgical navigation for operations through a rigid tube\n \
         Cuts a patient's CT at the tip of a tube, continuously. Research software; not a medical device.\n",
        version()
    ))
}

/// Links from where a system looks to where the package lies.
fn links(root: &Path) -> Result<(), Failure> {
    for name in PROGRAMS {
        link(&root.join("usr/bin").join(name), &format!("/opt/trocar/bin/{name}"))?;
    }
    for place in [
        "man/man1",
        "bash-completion/completions",
        "zsh/site-functions",
        "fish/vendor_completions.d",
    ] {
        let folder = root.join("opt/trocar/share").join(place);
        for entry in fs::read_dir(&folder).map_err(|e| Failure::file(&folder, e))?.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let from = root.join("usr/share").join(place).join(&name);
            link(&from, &format!("/opt/trocar/share/{place}/{name}"))?;
        }
    }
    Ok(())
}

fn link(at: &Path, to: &str) -> Result<(), Failure> {
    make(at.parent().unwrap_or(at))?;
    std::os::unix::fs::symlink(to, at).map_err(|e| Failure::file(at, e))
}

fn make(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|e| Failure::file(folder, e))
}

fn remove(folder: &Path) -> Result<(), Failure> {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Failure::file(folder, e)),
        _ => Ok(()),
    }
}

fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    fs::copy(from, to).map(|_| ()).map_err(|e| Failure::file(from, e))
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), Failure> {
    make(to)?;
    for entry in fs::read_dir(from).map_err(|e| Failure::file(from, e))?.flatten() {
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        match path.is_dir() {
            true => copy_folder(&path, &to)?,
            false => copy(&path, &to)?,
        }
    }
    Ok(())
}
