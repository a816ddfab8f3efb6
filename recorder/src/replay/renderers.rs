//! The renderers of a run, asked to draw one pose in every view: *held* images, which claim nothing of the present, so that they are, byte
//! for byte, the pictures of the same poses in the run that was recorded.

use std::path::Path;
use std::time::Duration;

use bus::message::{Ages, Command, ToolPose};
use bus::port::{CommandClient, FrameSubscriber};
use bus::topic::HELD_FRAME;
use bus::{Bus, BusError};
use picture::{Canvas, PngError, write_png};
use scene::Scene;

/// How long one request waits before this process gives a sign of life and asks again.
const PATIENCE: Duration = Duration::from_secs(1);

/// One renderer and its views.
#[derive(Debug)]
pub(crate) struct Renderer {
    client: CommandClient,
    /// The views that it draws, with their names.
    pub(crate) views: Vec<(String, FrameSubscriber)>,
}

/// The ends of all renderers of `scene`.
///
/// # Errors
/// [`BusError::Open`].
pub(crate) fn open(bus: &Bus, scene: &Scene) -> Result<Vec<Renderer>, BusError> {
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
    renderers.collect()
}

impl Renderer {
    /// Has the pose drawn, asking up to `tries` times and calling `alive` before each; the reason where there is nothing to draw.
    ///
    /// # Errors
    /// Those of `alive`.
    pub(crate) fn ask(
        &self,
        pose: &ToolPose,
        tries: usize,
        alive: &mut dyn FnMut() -> Result<(), BusError>,
    ) -> Result<Result<(), String>, BusError> {
        let mut last = String::new();
        for _ in 0..tries {
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

/// Why a picture was not written.
#[derive(Debug, thiserror::Error)]
pub enum DrawnError {
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The file.
    #[error(transparent)]
    Png(#[from] PngError),
}

/// Writes the image of a view to `path`, if it is that of the pose.
///
/// # Errors
/// [`DrawnError`].
pub(crate) fn write(
    path: &Path,
    (view, frames): &(String, FrameSubscriber),
    pose: &ToolPose,
    ages: Ages,
) -> Result<bool, DrawnError> {
    let Some(frame) = frames.newest()? else {
        return Ok(false);
    };
    let header = *frame.header();
    let is_it = (header.stamp.seq, header.stamp.t_capture_ns) == (pose.seq, pose.t_capture_ns);
    if !is_it || header.stamp.on_request != 1 {
        return Ok(false);
    }
    let mut canvas = Canvas::new(header.width, header.height);
    // Asked for: it claims nothing of the present.
    canvas.paste(frame.shown(header.stamp.t_framed_ns, ages).rgba, header.width, 0, 0);
    let mut texts = header.stamp.texts();
    texts.push(("view", view.clone()));
    write_png(path, &canvas, &texts)?;
    Ok(true)
}
