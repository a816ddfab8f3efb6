//! Pictures of the poses of a replay, as files.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use bus::message::{Ages, ToolPose};
use bus::{Bus, BusError};
use scene::Scene;

use super::renderers::{self, DrawnError, Renderer};

/// How often a renderer is asked.
const TRIES: usize = 20;

/// Why there are no pictures, or no more.
#[derive(Debug, thiserror::Error)]
pub enum ImagesError {
    /// The folder.
    #[error("folder for images {path}: {source}. Name a folder that you may write into, with `--out DIR`")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file.
    #[error(transparent)]
    Drawn(#[from] DrawnError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// Takes pictures.
#[derive(Debug)]
pub struct Images {
    folder: PathBuf,
    every: u64,
    renderers: Vec<Renderer>,
    ages: Ages,
    poses: u64,
    /// Files written.
    pub written: u64,
    /// Poses that were to be pictured and had nothing to show, with the renderers' reason for the last one.
    pub missing: u64,
    /// That reason.
    pub reason: String,
}

impl Images {
    /// Pictures of the first of `every` poses and so on, into `folder`; pictures of an earlier replay are removed from it.
    ///
    /// # Errors
    /// [`ImagesError::Folder`], [`ImagesError::Bus`].
    pub fn open(bus: &Bus, scene: &Scene, folder: &Path, every: u64) -> Result<Self, ImagesError> {
        let names: Vec<&str> = scene.views.iter().map(|view| view.name.as_str()).collect();
        clear(folder, &names).map_err(|source| ImagesError::Folder {
            path: folder.to_owned(),
            source,
        })?;
        Ok(Self {
            folder: folder.to_owned(),
            every: every.max(1),
            ages: Ages::of(&scene.limits),
            renderers: renderers::open(bus, scene)?,
            poses: 0,
            written: 0,
            missing: 0,
            reason: String::new(),
        })
    }

    /// A pose went out: takes its picture in every view if it is its turn. Calls `alive` now and then.
    ///
    /// # Errors
    /// [`ImagesError`].
    pub fn pose(
        &mut self,
        pose: &ToolPose,
        alive: &mut dyn FnMut() -> Result<(), BusError>,
    ) -> Result<(), ImagesError> {
        self.poses += 1;
        if !(self.poses - 1).is_multiple_of(self.every) {
            return Ok(());
        }
        for renderer in &self.renderers {
            if let Err(why) = renderer.ask(pose, TRIES, alive)? {
                self.missing += 1;
                self.reason = why;
                continue;
            }
            for view in &renderer.views {
                alive()?;
                let path = self.folder.join(file_name(&view.0, pose.seq));
                self.written += u64::from(renderers::write(&path, view, pose, self.ages)?);
            }
        }
        Ok(())
    }
}

/// The picture of a view for one pose.
pub fn file_name(view: &str, seq: u64) -> String {
    format!("{view}-{seq:06}.png")
}

/// Whether a file is named like a picture of one of these views.
fn is_picture(name: &str, views: &[&str]) -> bool {
    let of = |view: &&str| {
        let rest = name.strip_prefix(*view).and_then(|rest| rest.strip_prefix('-'));
        rest.and_then(|rest| rest.strip_suffix(".png"))
            .is_some_and(|digits| digits.len() >= 6 && digits.bytes().all(|b| b.is_ascii_digit()))
    };
    views.iter().any(of)
}

/// Makes the folder; pictures of an earlier replay must not be taken for this one's. Nobody else's file is touched.
fn clear(folder: &Path, views: &[&str]) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if is_picture(&entry.file_name().to_string_lossy(), views) {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pictures_of_an_earlier_replay_are_removed() {
        let tmp = tempfile::tempdir().unwrap();
        let ours = file_name("axial-local", 12);
        assert_eq!(ours, "axial-local-000012.png");
        let others = [
            "axial-local-12.png",
            "holiday-000012.png",
            "axial-local-00001x.png",
            "axial-local.png",
        ];
        for name in others.iter().copied().chain([ours.as_str()]) {
            fs::write(tmp.path().join(name), "x").unwrap();
        }
        clear(tmp.path(), &["axial", "axial-local"]).unwrap();
        assert!(!tmp.path().join(&ours).exists());
        assert!(others.iter().all(|name| tmp.path().join(name).exists()));
        assert!(clear(Path::new("/proc/trocar"), &[]).is_err());
    }
}
