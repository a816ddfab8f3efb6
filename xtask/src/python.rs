//! A Python with the packages that tests compare with.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::shell::{program, quietly, root, say, target};

/// Names the interpreter to the tests; where the user has set it, that one is used as it is.
pub(crate) const INTERPRETER_VARIABLE: &str = "TROCAR_PYTHON";
const REQUIREMENTS: &str = "tests/python/requirements.txt";

/// The interpreter, in a virtual environment in the build folder, or why there is none. An environment that was made
/// for the same list of packages is used again.
pub(crate) fn prepare() -> Result<PathBuf, String> {
    if let Some(given) = std::env::var_os(INTERPRETER_VARIABLE).filter(|given| !given.is_empty()) {
        say(&format!("{INTERPRETER_VARIABLE} is set to {}", given.display()));
        return Ok(PathBuf::from(given));
    }
    let list = root().join(REQUIREMENTS);
    let wanted = fs::read_to_string(&list).map_err(|e| format!("reading {}: {e}", list.display()))?;
    let folder = target().join("venv");
    let interpreter = folder.join("bin/python");
    // Written last: an environment with it is whole.
    let stamp = folder.join("requirements.txt");
    if fs::read_to_string(&stamp).is_ok_and(|made_for| made_for == wanted) && works(&interpreter) {
        say(&format!("using {}", folder.display()));
        return Ok(interpreter);
    }
    make(&folder)?;
    let list = list.to_string_lossy();
    quietly(&mut program(
        &interpreter,
        &["-m", "pip", "install", "--disable-pip-version-check", "-r", &list],
    ))?;
    fs::write(&stamp, wanted).map_err(|e| format!("writing {}: {e}", stamp.display()))?;
    say(&format!("made {}", folder.display()));
    Ok(interpreter)
}

fn works(interpreter: &Path) -> bool {
    quietly(&mut program(interpreter, &["-c", "import pip"])).is_ok()
}

/// A new, empty environment. On Debian `venv` is a package of its own: it is installed where that is allowed.
fn make(folder: &Path) -> Result<(), String> {
    let create = || {
        if folder.exists() {
            fs::remove_dir_all(folder).map_err(|e| format!("removing {}: {e}", folder.display()))?;
        }
        quietly(&mut program("python3", &["-m", "venv", &folder.to_string_lossy()]))
    };
    create().or_else(|reason| match install_packages() {
        Ok(()) => create(),
        Err(why_not) => Err(format!("{reason}; {why_not}")),
    })
}

fn install_packages() -> Result<(), String> {
    // The folder belongs to the user that this process runs as.
    let is_root = fs::metadata("/proc/self").is_ok_and(|process| process.uid() == 0);
    if !is_root {
        return Err("install python3 with its venv module (on Debian: apt-get install python3-venv)".to_owned());
    }
    say("installing python3-venv");
    quietly(&mut program("apt-get", &["update"]))?;
    let mut install = program("apt-get", &["install", "-y", "--no-install-recommends", "python3-venv"]);
    quietly(install.env("DEBIAN_FRONTEND", "noninteractive"))
}
