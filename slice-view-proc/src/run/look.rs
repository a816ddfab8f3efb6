//! A plane that was asked for, whatever the tool does.

use bus::message::{Command, FrameStamp, FrameState};

use super::{RunError, SliceView};
use crate::overlay::Notice;
use crate::render::Rendered;

impl SliceView {
    /// Draws the plane of a request and publishes the image; what to answer, or why it is refused. The image is none of those of poses:
    /// it has no number, it is not counted, and its stamp goes to who takes the image alone.
    pub(super) fn look(&mut self, command: &Command) -> Result<Result<String, String>, RunError> {
        let Some(volume) = &self.volume else {
            return Ok(Err("there is no volume yet".to_owned()));
        };
        let Some(output) = self.outputs.iter_mut().find(|output| output.index == command.view) else {
            return Ok(Err(format!("view {} is not drawn by this process", command.view)));
        };
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
            ..FrameStamp::default()
        };
        output.send_as(stamp, window, clock, i64::MAX)?;
        Ok(Ok("drawn".to_owned()))
    }
}
