//! Pictures of the poses of a replay, as files.
//!
//! They are *held* images: drawn because they were asked for. They claim nothing of the present, so that they are, byte for
//! byte, the pictures of the same poses in the run that was recorded.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bus::message::{Ages, Command, ToolPose};
use bus::port::{CommandClient, FrameSubscriber};
use bus::topic::HELD_FRAME;
use bus::{Bus, BusError};
use picture::{Canvas, PngError, write_png};
use scene::Scene;

/// How long one request waits before this process gives a sign of life and asks again.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often it asks.
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
    Png(#[from] PngError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// One renderer and its views.
#[derive(Debug)]
struct Renderer {
    client: CommandClient,
    views: Vec<(String, FrameSubscriber)>,
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
        let view = |&index: &usize| -> Result<_, BusError> {
            let name = scene.views[index].name.clone();
            let frames = FrameSubscriber::open(bus, &HELD_FRAME, &name)?;
            Ok((name, frames))
        };
        let renderers = scene.renderers().into_iter().map(|(plane, indices)| {
            Ok(Renderer {
                client: CommandClient::open(bus, &plane.process())?,
                views: indices.iter().map(view).collect::<Result<_, BusError>>()?,
            })
        });
        Ok(Self {
            folder: folder.to_owned(),
            every: every.max(1),
            ages: Ages::of(&scene.limits),
            renderers: renderers.collect::<Result<_, BusError>>()?,
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
            if let Err(why) = renderer.ask(pose, alive)? {
                self.missing += 1;
                self.reason = why;
                continue;
            }
            for view in &renderer.views {
                alive()?;
                self.written += u64::from(write(&self.folder, view, pose.seq, self.ages)?);
            }
        }
        Ok(())
    }
}

impl Renderer {
    /// Has the pose drawn; the reason where there is nothing to draw.
    fn ask(
        &self,
        pose: &ToolPose,
        alive: &mut dyn FnMut() -> Result<(), BusError>,
    ) -> Result<Result<(), String>, BusError> {
        let mut last = String::new();
        for _ in 0..TRIES {
            alive()?;
            match self.client.ask(Command::render(*pose), PATIENCE) {
                Ok(reply) if reply.refused => return Ok(Err(reply.text)),
                Ok(_) => return Ok(Ok(())),
                // It may be busy, or just be started again.
                Err(error) => last = error.to_string(),
            }
        }
        Ok(Err(last))
    }
}

/// Writes the image of a view, if it is that of the pose.
fn write(folder: &Path, (view, frames): &(String, FrameSubscriber), seq: u64, ages: Ages) -> Result<bool, ImagesError> {
    let Some(frame) = frames.newest()? else {
        return Ok(false);
    };
    let header = *frame.header();
    if header.stamp.seq != seq || header.stamp.on_request != 1 {
        return Ok(false);
    }
    let mut canvas = Canvas::new(header.width, header.height);
    // Asked for: it claims nothing of the present.
    canvas.paste(frame.shown(header.stamp.t_framed_ns, ages).rgba, header.width, 0, 0);
    let mut texts = header.stamp.texts();
    texts.push(("view", view.clone()));
    write_png(&folder.join(file_name(view, seq)), &canvas, &texts)?;
    Ok(true)
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
