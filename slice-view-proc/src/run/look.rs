//! A plane that was asked for, whatever the tool does; and a surface that was turned.

use bus::message::{Command, FrameStamp, FrameState};

use scene::Plane;

use super::{RunError, SliceView};
use crate::output::Output;
use crate::overlay::Notice;
use crate::render::Rendered;
use crate::tissue::Tissues;

impl SliceView {
    /// Has a surface seen from elsewhere, or as the scene says again; why not, where that is refused. Images that are held stay as the
    /// scene says: who asks for the same is given the same, in a replay too.
    pub(super) fn turn(&mut self, command: &Command) -> Result<(), String> {
        let is_surface =
            |output: &&mut Output| output.index == command.view && output.renderer.view().plane == Plane::Surface;
        let Some(output) = self.outputs.iter_mut().find(is_surface) else {
            return Err(format!(
                "view {} is not a surface that this process draws",
                command.view
            ));
        };
        let size = output.renderer.view().size;
        let camera = match command.plane.pixel_mm == 0.0 {
            true => None,
            false => Some(command.plane.asked(size).map_err(|error| error.to_string())?.0),
        };
        output.renderer.turn(camera);
        // Drawn anew at once, whatever it shows.
        self.drawn = None;
        Ok(())
    }

    /// Draws the plane of a request and publishes the image; what to answer, or why it is refused. The image is none of those of poses:
    /// it has no number, it is not counted, and its stamp goes to who takes the image alone.
    pub(super) fn look(&mut self, command: &Command) -> Result<Result<String, String>, RunError> {
        let Some(volume) = &self.volume else {
            return Ok(Err("there is no volume yet".to_owned()));
        };
        let Some(output) = self.outputs.iter_mut().find(|output| output.index == command.view) else {
            return Ok(Err(format!("view {} is not drawn by this process", command.view)));
        };
        if output.renderer.view().plane == Plane::Surface {
            return Ok(Err(format!(
                "view {} is a surface: it shows no plane, and can be turned",
                command.view
            )));
        }
        let (plane, window) = match command.plane.asked(output.renderer.view().size) {
            Ok(asked) => asked,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let clock = self.process.session.clock();
        let t_seen_ns = clock.now_ns();
        let what = Rendered {
            volume: volume.view(),
            volume_name: &self.volume_name,
            marks: volume.header().marks(),
            pose: None,
            accuracy: None,
            notice: Notice::Look,
            origin: self.origin,
            remarks: &[],
            chosen: self.chosens.at(t_seen_ns).and_then(|said| said.chosen.as_ref()),
            seq: 0,
            registration_id: self.last.map_or(0, |(sample, _)| sample.registration_id),
            tissue: match self.process.scene.tissue {
                Some(_) => Tissues::rigid(),
                None => Tissues::default(),
            },
        };
        // Who asks for the same again is given the same.
        let resampler = self.resampler.exact();
        output
            .renderer
            .look(&what, (plane, window), &self.process.scene, resampler)?;
        let stamp = FrameStamp {
            t_seen_ns,
            t_rendered_ns: clock.now_ns(),
            registration_id: what.registration_id,
            volume_hash: volume.hash().0,
            state: FrameState::Look.code(),
            view: output.index,
            on_request: 1,
            replay: self.origin.code(),
            tissue: what.tissue.shown.code(),
            ..FrameStamp::default()
        };
        output.send_as(stamp, window, clock, i64::MAX)?;
        Ok(Ok("drawn".to_owned()))
    }
}
