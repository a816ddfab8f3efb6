//! Scenes that came with an installed Trocar.

use std::path::{Path, PathBuf};

/// The shipped scene of the name `path`, where there is none at that path itself: `config/demo.toml`, for instance, of an
/// installation with its programs in `bin` and its scenes in `share/trocar`. Whoever takes it says so.
pub fn instead_of(path: &Path) -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    beside(&program, path).filter(|shipped| !path.exists() && shipped.is_file())
}

/// Where an installation that `program` belongs to has `path`. Only plain relative paths: nothing leads out of its folder.
fn beside(program: &Path, path: &Path) -> Option<PathBuf> {
    let is_plain = path
        .components()
        .all(|part| matches!(part, std::path::Component::Normal(_)));
    let root = program.parent()?.parent()?;
    is_plain.then(|| root.join("share/trocar").join(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_paths_are_looked_for_in_the_installation() {
        let program = Path::new("/opt/trocar/bin/pilot");
        let found = beside(program, Path::new("config/demo.toml"));
        assert_eq!(found, Some("/opt/trocar/share/trocar/config/demo.toml".into()));
        for path in ["../demo.toml", "/etc/passwd", "config/../../x", "./demo.toml"] {
            assert_eq!(beside(program, Path::new(path)), None, "{path}");
        }
    }
}
